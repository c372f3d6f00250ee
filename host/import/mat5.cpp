#include "host/import/mat5.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "host/config/bad_input.h"
#include "host/import/bytes.h"
#include "host/import/scope_header.h"

namespace powbench::host {
namespace {

constexpr std::uint32_t mi_matrix = 14, mi_compressed = 15;
constexpr std::uint32_t class_struct = 2, class_double = 6, class_uint64 = 15;
constexpr std::size_t most_inflated = std::size_t{2} << 30;
constexpr int deepest = 8;

std::optional<Number> number_type(std::uint32_t mi) {
  switch (mi) {
    case 1:
      return Number::i8;
    case 2:
      return Number::u8;
    case 3:
      return Number::i16;
    case 4:
      return Number::u16;
    case 5:
      return Number::i32;
    case 6:
      return Number::u32;
    case 7:
      return Number::f32;
    case 9:
      return Number::f64;
    case 12:
      return Number::i64;
    case 13:
      return Number::u64;
    default:
      return std::nullopt;
  }
}

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

/// A tag and its bytes, with the padding to 8 behind them.
Element next_element(Bytes& from, bool padded = true) {
  const auto first = from.integer<std::uint32_t>();
  if (first >> 16 != 0) {  // small: length and type in one word
    const std::uint32_t length = first >> 16;
    if (length > 4) throw CutShort();
    return {first & 0xFFFFU, from.take(4).substr(0, length)};
  }
  const auto length = from.integer<std::uint32_t>();
  Element e{first, from.take(length)};
  if (padded && length % 8 != 0) from.take(std::min<std::uint64_t>(8 - length % 8, from.left()));
  return e;
}

std::vector<double> numbers_of(const Element& e, bool big) {
  const auto n = number_type(e.type);
  if (!n) throw CutShort();
  const std::size_t size = size_of(*n);
  std::vector<double> out(e.data.size() / size);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = number_at(&e.data[i * size], *n, big);
  return out;
}

struct Variable {
  std::string name;
  std::size_t rows = 0, columns = 0;
  std::vector<double> value;  ///< column by column
};

class Reader {
 public:
  Reader(std::string_view all, const std::string& file) : all_(all), file_(file) {}

  CsvTable read() {
    if (all_.size() < 128 || !all_.starts_with("MATLAB"))
      refuse("is no MAT-file of level 5: it does not begin with MATLAB");
    if (all_.substr(0, 20).find("MATLAB 7.3") != std::string_view::npos ||
        all_.substr(128).starts_with("\x89HDF"))
      refuse("is a MAT-file of level 7.3 (HDF5); save it with -v7");
    const std::string_view order = all_.substr(126, 2);
    if (order != "IM" && order != "MI") refuse("its byte order is neither MI nor IM: it is damaged");
    Bytes bytes(all_.substr(128), order == "MI");
    while (bytes.left() >= 8) top(next_element(bytes, false), bytes.big());
    return table();
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw BadInput({file_ + ": " + why}); }

  void top(const Element& e, bool big) {
    if (e.type == mi_matrix) return matrix(e.data, big, "", 0);
    if (e.type != mi_compressed) return;  // what a reader does not know it passes over
    const std::string plain = inflated(e.data);
    Bytes inside(plain, big);
    while (inside.left() >= 8) {
      const Element part = next_element(inside, false);
      if (part.type == mi_matrix) matrix(part.data, big, "", 0);
    }
  }

  std::string inflated(std::string_view data) const {
    z_stream z{};
    if (inflateInit(&z) != Z_OK) refuse("no memory to unpack it");
    const struct End {
      z_stream* z;
      ~End() { inflateEnd(z); }
    } end{&z};
    std::string out;
    std::string piece(1 << 16, '\0');
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
    z.avail_in = static_cast<uInt>(data.size());
    int status = Z_OK;
    while (status == Z_OK) {
      z.next_out = reinterpret_cast<Bytef*>(piece.data());
      z.avail_out = static_cast<uInt>(piece.size());
      status = inflate(&z, Z_NO_FLUSH);
      out.append(piece, 0, piece.size() - z.avail_out);
      if (out.size() > most_inflated) refuse("a variable unpacks to more than 2 GiB");
    }
    if (status != Z_STREAM_END) refuse("a compressed variable cannot be unpacked: it is cut or damaged");
    return out;
  }

  void matrix(std::string_view data, bool big, const std::string& prefix, int depth) {
    if (data.empty()) return;  // an empty field of a structure
    Bytes in(data, big);
    const std::vector<double> flags = numbers_of(next_element(in), big);
    if (flags.empty()) throw CutShort();
    const auto word = static_cast<std::uint32_t>(flags[0]);
    const std::uint32_t kind = word & 0xFFU;
    const bool complex = (word & 0x800U) != 0;
    const std::vector<double> dims = numbers_of(next_element(in), big);
    const std::string own(next_element(in).data);
    const std::string name = prefix.empty() ? own : prefix;
    if (dims.size() != 2) return;
    for (const double d : dims)
      if (!(d >= 0 && d <= 1e10)) refuse("variable '" + name + "': its size makes no sense: it is damaged");
    if (kind == class_struct && dims[0] * dims[1] == 1 && depth < deepest)
      return structure(in, big, name, depth);
    if (kind < class_double || kind > class_uint64 || complex) return;
    const Element e = next_element(in);
    Variable v{name, static_cast<std::size_t>(dims[0]), static_cast<std::size_t>(dims[1]),
               numbers_of(e, big)};
    if (static_cast<double>(v.value.size()) != dims[0] * dims[1])
      refuse(fmt::format("variable '{}': {:g} x {:g} numbers are stated, {} are there: it is damaged", name,
                         dims[0], dims[1], v.value.size()));
    variables_.push_back(std::move(v));
  }

  void structure(Bytes& in, bool big, const std::string& name, int depth) {
    const std::vector<double> length = numbers_of(next_element(in), big);
    const std::string_view names = next_element(in).data;
    if (length.size() != 1 || !(length[0] >= 1 && length[0] <= 64)) throw CutShort();
    const auto size = static_cast<std::size_t>(length[0]);
    for (std::size_t i = 0; (i + 1) * size <= names.size(); ++i) {
      const std::string field(
          names.substr(i * size, size).substr(0, names.substr(i * size, size).find('\0')));
      const Element e = next_element(in);
      if (e.type == mi_matrix) matrix(e.data, big, name + "." + field, depth + 1);
    }
  }

  /// The scalar of one of these names, the last part of a structure's field too.
  std::optional<double> scalar(std::initializer_list<const char*> names) const {
    for (const char* wanted : names)
      for (const Variable& v : variables_)
        if (v.value.size() == 1 && v.name.substr(v.name.rfind('.') + 1) == wanted) return v.value[0];
    return std::nullopt;
  }

  CsvTable table() {
    std::size_t rows = 0;
    for (const Variable& v : variables_) rows = std::max(rows, std::max(v.rows, v.columns));
    if (rows < 2) refuse("holds no vector of real numbers");
    if (rows > most_rows) refuse(fmt::format("{} samples; at most {} are read", rows, most_rows));
    CsvTable t;
    t.header.emplace_back("time [s]");
    t.columns.emplace_back();
    for (Variable& v : variables_) {
      if (std::max(v.rows, v.columns) != rows || std::min(v.rows, v.columns) == 0) {
        if (v.value.size() > 1)
          t.notes.push_back(fmt::format("variable '{}': {} x {}, passed over", v.name, v.rows, v.columns));
        continue;
      }
      const std::size_t many = std::min(v.rows, v.columns);
      if (many + t.columns.size() > 64) refuse("more than 63 columns of samples; allowed up to that");
      const bool along = v.rows != rows;  // samples lie along the rows
      for (std::size_t k = 0; k < many; ++k) {
        std::vector<double> column(rows);
        for (std::size_t i = 0; i < rows; ++i) column[i] = v.value[along ? k + i * v.rows : k * v.rows + i];
        if (many == 1 && t.columns[0].empty() && is_time_name(v.name.substr(v.name.rfind('.') + 1)))
          t.columns[0] = std::move(column);
        else
          add(t, many == 1 ? v.name : fmt::format("{}_{}", v.name, k + 1), std::move(column));
      }
    }
    if (t.columns.size() < 2) refuse("holds no vector of samples beside the time");
    if (t.columns[0].empty()) t.columns[0] = clock(rows);
    for (std::size_t i = 0; i < rows; ++i) t.line.push_back(static_cast<std::uint32_t>(i + 1));
    return t;
  }

  static void add(CsvTable& t, const std::string& name, std::vector<double> column) {
    const std::size_t at = name.rfind('_');
    const std::string behind = at == std::string::npos ? "" : name.substr(at + 1);
    const bool stated = at != std::string::npos && at > 0 && is_unit_word(behind) &&
                        !std::isdigit(static_cast<unsigned char>(behind[0]));
    const ScopeUnit u = stated ? scope_unit(behind) : ScopeUnit{"V", 1.0};
    if (!stated) t.notes.push_back(fmt::format("variable '{}': a MAT-file states no unit, taken as V", name));
    for (double& v : column) v *= u.factor;
    t.header.push_back((stated ? name.substr(0, at) : name) + " [" + u.unit + "]");
    t.columns.push_back(std::move(column));
  }

  std::vector<double> clock(std::size_t rows) const {
    double step = scalar({"Tinterval", "dt", "Ts", "delta_t"}).value_or(0.0);
    if (const auto rate = scalar({"fs", "Fs", "rate", "sample_rate"}); step == 0.0 && rate && *rate > 0)
      step = 1.0 / *rate;
    if (!(step > 0))
      refuse("has no clock: no vector called time or t, no number called Tinterval, dt, Ts, fs or Fs");
    const double start = scalar({"Tstart", "t0"}).value_or(0.0);
    std::vector<double> time(rows);
    for (std::size_t i = 0; i < rows; ++i) time[i] = start + step * static_cast<double>(i);
    return time;
  }

  std::string_view all_;
  const std::string& file_;
  std::vector<Variable> variables_;
};

}  // namespace

CsvTable parse_mat(std::string_view bytes, const std::string& file) {
  try {
    return Reader(bytes, file).read();
  } catch (const CutShort& e) {
    throw BadInput({file + ": " + e.what()});
  }
}

}  // namespace powbench::host
