#include "host/import/wvf.h"

#include <fmt/format.h>

#include <map>
#include <optional>

#include "host/config/bad_input.h"
#include "host/config/cells.h"
#include "host/import/bytes.h"
#include "host/import/scope_header.h"

namespace powbench::host {
namespace {

using Words = std::vector<std::string>;

Words words_of(std::string_view line) {
  Words list;
  std::string word;
  for (const char c : line) {
    if (c != ' ' && c != '\t') {
      word += c;
    } else if (!word.empty()) {
      list.push_back(std::move(word));
      word.clear();
    }
  }
  if (!word.empty()) list.push_back(word);
  return list;
}

std::optional<Number> number_type(const std::string& word) {
  static const std::map<std::string, Number> known{
      {"IS1", Number::i8},  {"IU1", Number::u8},  {"IS2", Number::i16}, {"IU2", Number::u16},
      {"IS4", Number::i32}, {"IU4", Number::u32}, {"FS4", Number::f32}, {"FS8", Number::f64}};
  const auto at = known.find(word);
  return at == known.end() ? std::nullopt : std::optional(at->second);
}

struct Trace {
  std::string name, unit, time_unit = "s";
  Number type = Number::i16;
  std::uint64_t samples = 0;  ///< of a block
  double resolution = 1, offset = 0, step = 0, start = 0;
  std::vector<double> value;
};

class Reader {
 public:
  Reader(std::string_view header, const std::string& file) : file_(file) {
    Lines lines(plain_text(header, file));
    if (!lines.next() || lines.text.find("YOKOGAWA") == std::string_view::npos)
      throw BadInput(
          {file + ":1: is no header of Yokogawa: it does not begin with //YOKOGAWA ASCII FILE FORMAT"});
    std::map<std::string, Words>* section = nullptr;
    while (lines.next()) {
      Words words = words_of(lines.text);
      if (words.empty() || words[0].starts_with("//")) continue;
      if (words[0].starts_with("$Group")) {
        groups_.emplace_back();
        section = &groups_.back();
      } else if (words[0].starts_with('$')) {
        section = words[0] == "$PublicInfo" ? &public_ : nullptr;
      } else if (section != nullptr) {
        auto& to = (*section)[words[0]];  // long lists go on in further lines of the same key
        to.insert(to.end(), words.begin() + 1, words.end());
      }
    }
  }

  CsvTable read(std::string_view data, const std::string& data_file) {
    const bool big = text(public_, "Endian", 0) == "Big";
    const bool blocks = text(public_, "DataFormat", 0) == "Block";
    const double skip = number(public_, "DataOffset", 0, 0.0);
    if (groups_.empty()) refuse("has no $Group");
    std::uint64_t first = skip >= 0 && skip < 1e15 ? static_cast<std::uint64_t>(skip) : data.size() + 1;
    Bytes bytes(data, big);
    std::vector<Trace> all;
    try {
      bytes.take(first);
      for (const auto& group : groups_) {
        std::vector<Trace> traces = traces_of(group);
        const double many = number(group, "BlockNumber", 0, 1.0);
        if (!(many >= 1 && many <= 1e6)) refuse(fmt::format("BlockNumber {:g}; allowed 1 to 1e6", many));
        const auto n = static_cast<std::uint64_t>(many);
        if (blocks)
          for (std::uint64_t b = 0; b < n; ++b)
            for (Trace& t : traces) take(t, bytes, 1);
        else
          for (Trace& t : traces) take(t, bytes, n);
        for (Trace& t : traces) all.push_back(std::move(t));
      }
    } catch (const CutShort&) {
      throw BadInput({data_file + ": has fewer samples than " + file_ + " states: it is cut or damaged"});
    }
    CsvTable t = table(all);
    if (bytes.left() > 0)
      t.notes.push_back(fmt::format("{} bytes behind the samples were left out", bytes.left()));
    return t;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw BadInput({file_ + ": " + why}); }

  std::string text(const std::map<std::string, Words>& from, const std::string& key, std::size_t i) const {
    const auto at = from.find(key);
    return at != from.end() && i < at->second.size() ? at->second[i] : "";
  }
  double number(const std::map<std::string, Words>& from, const std::string& key, std::size_t i,
                double without) const {
    const std::string word = text(from, key, i);
    if (word.empty()) return without;
    const auto value = cell_number(word, false);
    if (!value || !std::isfinite(*value)) refuse(fmt::format("{} = '{}': is no number", key, word));
    return *value;
  }

  std::vector<Trace> traces_of(const std::map<std::string, Words>& group) const {
    const double many = number(group, "TraceNumber", 0, 0.0);
    if (!(many >= 1 && many <= 63)) refuse(fmt::format("TraceNumber {:g}; allowed 1 to 63", many));
    std::vector<Trace> list;
    for (std::size_t i = 0; i < static_cast<std::size_t>(many); ++i) {
      Trace t;
      t.name = text(group, "TraceName", i);
      if (t.name.empty()) refuse(fmt::format("trace {}: has no TraceName", i + 1));
      const auto type = number_type(text(group, "VDataType", i));
      if (!type)
        refuse(fmt::format("trace {}: VDataType '{}'; allowed IS1, IU1, IS2, IU2, IS4, IU4, FS4, FS8", t.name,
                           text(group, "VDataType", i)));
      t.type = *type;
      const double samples = number(group, "BlockSize", i, 0.0);
      if (!(samples >= 1 && samples <= static_cast<double>(most_rows)))
        refuse(fmt::format("trace {}: BlockSize {:g}; allowed 1 to {}", t.name, samples, most_rows));
      t.samples = static_cast<std::uint64_t>(samples);
      t.unit = text(group, "VUnit", i);
      t.resolution = number(group, "VResolution", i, 1.0);
      t.offset = number(group, "VOffset", i, 0.0);
      t.step = number(group, "HResolution", i, 0.0);
      t.start = number(group, "HOffset", i, 0.0);
      if (const std::string u = text(group, "HUnit", i); !u.empty()) t.time_unit = u;
      if (!(t.step > 0)) refuse(fmt::format("trace {}: HResolution {:g}; allowed above 0", t.name, t.step));
      list.push_back(std::move(t));
    }
    return list;
  }

  void take(Trace& t, Bytes& bytes, std::uint64_t blocks) const {
    const std::size_t size = size_of(t.type);
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::string_view part = bytes.take(t.samples * size);
      if (t.value.size() + t.samples > most_rows)
        refuse(fmt::format("trace {}: more than {} samples", t.name, most_rows));
      for (std::size_t i = 0; i < t.samples; ++i)
        t.value.push_back(t.resolution * number_at(&part[i * size], t.type, bytes.big()) + t.offset);
    }
  }

  CsvTable table(std::vector<Trace>& all) const {
    const Trace& first = all.front();
    if (all.size() > 63) refuse(fmt::format("{} traces; allowed up to 63", all.size()));
    for (const Trace& t : all)
      if (t.value.size() != first.value.size() || t.step != first.step || t.start != first.start)
        refuse(fmt::format("traces {} and {} have other clocks or lengths; allowed one: export them apart",
                           first.name, t.name));
    const ScopeUnit seconds = scope_unit(first.time_unit);
    const double factor = seconds.unit == "s"    ? seconds.factor
                          : seconds.unit == "ms" ? 1e-3
                          : seconds.unit == "us" ? 1e-6
                                                 : 0.0;
    if (factor == 0.0) refuse(fmt::format("HUnit '{}'; allowed s, ms, us, ns", first.time_unit));
    CsvTable out;
    out.header.emplace_back("time [s]");
    out.columns.emplace_back(first.value.size());
    for (std::size_t i = 0; i < first.value.size(); ++i) {
      out.columns[0][i] = factor * (first.start + first.step * static_cast<double>(i));
      out.line.push_back(static_cast<std::uint32_t>(i + 1));
    }
    for (Trace& t : all) {
      ScopeUnit u = scope_unit(t.unit);
      if (u.unit.empty()) {
        out.notes.push_back(fmt::format("trace {}: the file states no unit, taken as V", t.name));
        u.unit = "V";
      }
      for (double& v : t.value) v *= u.factor;
      out.header.push_back(t.name + " [" + u.unit + "]");
      out.columns.push_back(std::move(t.value));
    }
    return out;
  }

  const std::string& file_;
  std::map<std::string, Words> public_;
  std::vector<std::map<std::string, Words>> groups_;
};

}  // namespace

CsvTable parse_wvf(std::string_view header, std::string_view data, const std::string& header_file,
                   const std::string& data_file) {
  return Reader(header, header_file).read(data, data_file);
}

}  // namespace powbench::host
