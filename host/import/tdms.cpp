#include "host/import/tdms.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "host/config/bad_input.h"
#include "host/import/bytes.h"
#include "host/import/scope_header.h"

namespace powbench::host {
namespace {

enum Toc : std::uint32_t {
  metadata = 1U << 1,
  new_list = 1U << 2,
  raw = 1U << 3,
  interleaved = 1U << 5,
  big = 1U << 6,
  daqmx = 1U << 7
};
constexpr std::uint64_t open_end = ~std::uint64_t{0};
constexpr std::uint32_t no_index = 0xFFFFFFFFU, same_index = 0;

std::optional<Number> number_type(std::uint32_t code) {
  switch (code) {
    case 1:
      return Number::i8;
    case 2:
      return Number::i16;
    case 3:
      return Number::i32;
    case 4:
      return Number::i64;
    case 5:
      return Number::u8;
    case 6:
      return Number::u16;
    case 7:
      return Number::u32;
    case 8:
      return Number::u64;
    case 9:
    case 0x19:
      return Number::f32;
    case 10:
    case 0x1A:
      return Number::f64;
    case 0x21:
      return Number::u8;  // a truth value
    default:
      return std::nullopt;
  }
}

struct Index {
  std::uint32_t type = 0;
  std::uint64_t values = 0, bytes = 0;  ///< of one chunk
};

struct Channel {
  std::string path;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> texts;
  std::optional<Index> index;
  std::vector<double> value;
  bool numeric = true;
};

class Reader {
 public:
  Reader(std::string_view all, const std::string& file) : all_(all), file_(file) {}

  CsvTable read() {
    std::uint64_t at = 0;
    while (at < all_.size()) at = segment(at);
    return table();
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw BadInput({file_ + ": " + why}); }

  /// Returns where the next one begins.
  std::uint64_t segment(std::uint64_t at) {
    Bytes lead(all_.substr(at));
    if (lead.take(4) != "TDSm")
      refuse(fmt::format("no segment begins at byte {}, where one should: it is damaged", at));
    const auto toc = lead.integer<std::uint32_t>();
    const bool big_endian = (toc & big) != 0;
    Bytes head(all_.substr(at + 8), big_endian);
    const auto version = head.integer<std::uint32_t>();
    if (version != 4712 && version != 4713)
      refuse(fmt::format("TDMS version {}; allowed 4712 and 4713", version));
    auto next = head.integer<std::uint64_t>();
    const auto data = head.integer<std::uint64_t>();
    const std::uint64_t left = head.left();
    if (next == open_end) next = left;
    if (next > left)
      refuse(fmt::format("a segment ends {} bytes behind the end of the file: it is cut", next - left));
    if (data > next) refuse("a segment's data begin behind its end: it is damaged");
    if (toc & daqmx)
      refuse("holds raw data of DAQmx, which need the driver's scaling; save the channels as numbers");
    if ((toc & new_list) != 0) order_.clear();
    if ((toc & metadata) != 0) {
      Bytes meta(all_.substr(at + 28, data), big_endian);
      for (auto objects = meta.integer<std::uint32_t>(); objects > 0; --objects) object(meta);
    }
    if ((toc & raw) != 0)
      take_raw(all_.substr(at + 28 + data, next - data), big_endian, (toc & interleaved) != 0);
    return at + 28 + next;
  }

  void object(Bytes& meta) {
    const std::string path = meta.text();
    const auto [known, fresh] = by_path_.try_emplace(path, channels_.size());
    if (fresh) channels_.emplace_back().path = path;
    Channel& c = channels_[known->second];
    const auto length = meta.integer<std::uint32_t>();
    if (length != no_index) {
      if (length == 0x69120000U || length == 0x69130000U || length == 0x69120D00U)
        refuse("holds raw data of DAQmx, which need the driver's scaling; save the channels as numbers");
      if (length != same_index) {
        Index i{.type = meta.integer<std::uint32_t>()};
        if (meta.integer<std::uint32_t>() != 1)
          refuse("channel " + path + ": more than one dimension; allowed one");
        i.values = meta.integer<std::uint64_t>();
        const auto type = number_type(i.type);
        if (i.values > all_.size())
          refuse(fmt::format("channel {}: {} values in a file of {} bytes: it is damaged", path, i.values,
                             all_.size()));
        if (i.type == 0x20)
          i.bytes = meta.integer<std::uint64_t>();
        else if (type)
          i.bytes = i.values * size_of(*type);
        else if (i.type == 0x44)
          i.bytes = 16 * i.values;
        else
          refuse(fmt::format("channel {}: data type {:#x}; allowed integers and floating-point numbers", path,
                             i.type));
        if (i.bytes > all_.size())
          refuse(
              fmt::format("channel {}: {} bytes in a file of {}: it is damaged", path, i.bytes, all_.size()));
        c.numeric = c.numeric && type.has_value();
        c.index = i;
      }
      if (!c.index)
        refuse("channel " + path + ": its layout is that of an earlier one that is not there: it is damaged");
      if (std::find(order_.begin(), order_.end(), known->second) == order_.end())
        order_.push_back(known->second);
    }
    for (auto n = meta.integer<std::uint32_t>(); n > 0; --n) property(meta, channels_[known->second]);
  }

  void property(Bytes& meta, Channel& c) {
    const std::string name = meta.text();
    const auto type = meta.integer<std::uint32_t>();
    if (type == 0x20) {
      c.texts[name] = meta.text();
    } else if (type == 0x44) {
      meta.take(16);
    } else if (const auto n = number_type(type)) {
      c.numbers[name] = meta.number(*n);
    } else {
      refuse(fmt::format("property '{}' of {}: data type {:#x} is not known", name, c.path, type));
    }
  }

  void take_raw(std::string_view data, bool big_endian, bool mixed) {
    std::uint64_t chunk = 0, step = 0;
    for (const std::size_t k : order_) {
      chunk += channels_[k].index->bytes;
      if (mixed && !channels_[k].numeric)
        refuse("interleaved data that are no numbers; save them contiguous");
      if (mixed && channels_[k].index->values != channels_[order_[0]].index->values)
        refuse("interleaved channels of unequal length: it is damaged");
      if (const auto n = number_type(channels_[k].index->type)) step += size_of(*n);
    }
    if (chunk == 0) return;
    for (; data.size() >= chunk; data.remove_prefix(chunk)) {
      std::size_t at = 0;
      for (const std::size_t k : order_) {
        Channel& c = channels_[k];
        const auto n = number_type(c.index->type);
        if (n && c.value.size() + c.index->values > most_rows)
          refuse(fmt::format("channel {}: more than {} values", c.path, most_rows));
        const std::size_t stride = mixed ? step : n ? size_of(*n) : 0;
        for (std::size_t i = 0; n && i < c.index->values; ++i)
          c.value.push_back(number_at(&data[at + i * stride], *n, big_endian));
        at += mixed ? (n ? size_of(*n) : 0) : c.index->bytes;
      }
    }
    lost_ += data.size();
  }

  static double property_of(const Channel& c, const std::string& name, double without) {
    const auto at = c.numbers.find(name);
    return at == c.numbers.end() ? without : at->second;
  }
  static std::string text_of(const Channel& c, const std::string& name) {
    const auto at = c.texts.find(name);
    return at == c.texts.end() ? "" : at->second;
  }

  /// `/'Group'/'Name'` -> `Name`; the quotes inside are doubled.
  static std::string name_of(const std::string& path) {
    const std::size_t open = path.rfind("/'");
    std::string name = open == std::string::npos ? path : path.substr(open + 2);
    if (!name.empty() && name.back() == '\'') name.pop_back();
    return name;
  }

  void scale(Channel& c) const {
    const double scales = property_of(c, "NI_Number_Of_Scales", 0.0);
    for (int i = 0; i < std::min(scales, 16.0); ++i) {
      const std::string key = fmt::format("NI_Scale[{}]_", i);
      const std::string type = text_of(c, key + "Scale_Type");
      if (type.empty()) continue;
      if (type != "Linear")
        refuse(fmt::format("channel {}: a scaling of type {}; allowed Linear", c.path, type));
      const double slope = property_of(c, key + "Linear_Slope", 1.0),
                   zero = property_of(c, key + "Linear_Y_Intercept", 0.0);
      for (double& v : c.value) v = slope * v + zero;
    }
  }

  CsvTable table() {
    std::vector<Channel*> columns;
    const Channel* clock = nullptr;
    bool waves = false;
    for (Channel& c : channels_)
      waves = waves || (c.numeric && !c.value.empty() && property_of(c, "wf_increment", 0) > 0);
    for (Channel& c : channels_) {
      if (!c.numeric || c.value.empty()) continue;
      scale(c);
      if (waves && !(property_of(c, "wf_increment", 0) > 0)) continue;
      if (!waves && clock == nullptr && is_time_name(name_of(c.path)))
        clock = &c;
      else
        columns.push_back(&c);
    }
    if (columns.empty()) refuse("holds no channel with numbers");
    if (!waves && clock == nullptr)
      refuse("no channel has a clock (property wf_increment), and none is called time");
    const Channel& first = *columns.front();
    const double step = property_of(first, "wf_increment", 0.0),
                 start = property_of(first, "wf_start_offset", 0.0);
    for (const Channel* c : columns) {
      if (c->value.size() != (clock ? clock : &first)->value.size())
        refuse(fmt::format(
            "channel {} has {} values, {} has {}; allowed equally many: export channels of one clock",
            c->path, c->value.size(), (clock ? clock : &first)->path,
            (clock ? clock : &first)->value.size()));
      if (waves &&
          (property_of(*c, "wf_increment", 0.0) != step || property_of(*c, "wf_start_offset", 0.0) != start))
        refuse(fmt::format("channels {} and {} have other clocks; allowed one", first.path, c->path));
    }
    CsvTable t;
    t.header_line = 1;
    t.header.emplace_back("time [s]");
    t.columns.emplace_back(clock ? clock->value : std::vector<double>(first.value.size()));
    for (std::size_t i = 0; !clock && i < t.columns[0].size(); ++i)
      t.columns[0][i] = start + step * static_cast<double>(i);
    for (Channel* c : columns) {
      std::string unit = text_of(*c, "unit_string");
      if (unit.empty()) unit = text_of(*c, "NI_UnitDescription");
      ScopeUnit u = scope_unit(unit);
      if (u.unit.empty()) {
        t.notes.push_back(fmt::format("channel {}: the file states no unit, taken as V", c->path));
        u.unit = "V";
      }
      if (u.factor != 1.0)
        for (double& v : c->value) v *= u.factor;
      t.header.push_back(name_of(c->path) + " [" + u.unit + "]");
      t.columns.push_back(std::move(c->value));
    }
    for (std::size_t i = 0; i < t.columns[0].size(); ++i) t.line.push_back(static_cast<std::uint32_t>(i + 1));
    if (lost_ > 0) t.notes.push_back(fmt::format("{} bytes of an unfinished chunk were left out", lost_));
    return t;
  }

  std::string_view all_;
  const std::string& file_;
  std::vector<Channel> channels_;
  std::map<std::string, std::size_t> by_path_;
  std::vector<std::size_t> order_;  ///< of the channels in the raw data
  std::uint64_t lost_ = 0;
};

}  // namespace

CsvTable parse_tdms(std::string_view bytes, const std::string& file) {
  try {
    return Reader(bytes, file).read();
  } catch (const CutShort& e) {
    throw BadInput({file + ": " + e.what()});
  }
}

}  // namespace powbench::host
