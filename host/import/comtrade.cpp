#include "host/import/comtrade.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t most_channels = 999'999;

struct AnalogRow {
  double factor = 1.0, offset = 0.0;
};
struct Rate {
  double hertz = 0.0;
  std::int64_t last = 0;  ///< number of its last sample
};

std::string_view bare(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(bare(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

template <class Number>
std::optional<Number> number_of(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  Number value{};
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || rest != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// Time of the day of `hh:mm:ss.ffffff`, whole nanoseconds, and how many decimals it has.
struct Clock {
  double nanoseconds = 0.0;
  int decimals = 0;
};

class Parser {
 public:
  Parser(std::string_view configuration, std::string_view data, const std::string& configuration_file,
         const std::string& data_file)
      : rest_(configuration), data_(data), file_(configuration_file), data_file_(data_file) {}

  Comtrade run() {
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
    read_head();
    read_channels();
    read_times();
    if (format_ == "ASCII")
      read_ascii();
    else
      read_binary();
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw BadInput({fmt::format("{}:{}: {}", file_, line_, what)});
  }
  [[noreturn]] void fail_data(std::int64_t row, const std::string& what) const {
    throw BadInput({fmt::format("{}: row {}: {}", data_file_, row, what)});
  }

  std::vector<std::string_view> next(const char* what) {
    ++line_;
    if (rest_.empty()) fail(fmt::format("the file ends before {}", what));
    const std::size_t end = rest_.find('\n');
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    return cells_of(line);
  }
  template <class Number>
  Number number(const std::vector<std::string_view>& cells, std::size_t at, const char* what, Number least,
                Number most) {
    const std::string_view cell = at < cells.size() ? cells[at] : std::string_view();
    const std::optional<Number> value = number_of<Number>(cell);
    if (!value || !(*value >= least && *value <= most))
      fail(fmt::format("{} = '{}'; allowed {} .. {}", what, cell, least, most));
    return *value;
  }

  void read_head() {
    const auto head = next("the station");
    out_.station = head[0];
    if (head.size() > 2 && !head[2].empty())
      out_.revision = number<int>(head, 2, "revision year", 1991, 2099);
    const auto counts = next("the number of channels");
    const auto count = [&](std::size_t at, char kind) -> std::int64_t {
      std::string_view cell = at < counts.size() ? counts[at] : std::string_view();
      if (cell.empty() || (cell.back() != kind && cell.back() != kind + 32))
        fail(fmt::format("'{}'; allowed a number and {}", cell, kind));
      cell.remove_suffix(1);
      return number<std::int64_t>({cell}, 0, "number of channels", 0, most_channels);
    };
    analog_ = count(1, 'A');
    digital_ = count(2, 'D');
    if (analog_ == 0) fail("no analogue channel; allowed one or more");
  }

  void read_channels() {
    constexpr double any = 1e30;
    for (std::int64_t i = 0; i < analog_; ++i) {
      const auto cells = next("the last analogue channel");
      if (cells.size() < 10) fail(fmt::format("{} cells; an analogue channel has 10 or 13", cells.size()));
      Comtrade::Channel channel{
          .name = std::string(cells[1]), .unit = std::string(cells[4]), .skew = 0.0, .value = {}};
      rows_.push_back(
          {number<double>(cells, 5, "factor a", -any, any), number<double>(cells, 6, "offset b", -any, any)});
      if (!cells[7].empty()) channel.skew = 1e-6 * number<double>(cells, 7, "skew in us", -1e6, 1e6);
      out_.channels.push_back(std::move(channel));
    }
    for (std::int64_t i = 0; i < digital_; ++i) next("the last status channel");
  }

  Clock clock_of(const std::vector<std::string_view>& cells) {
    const std::string_view text = cells.size() > 1 ? cells[1] : std::string_view();
    const auto part = [&](std::size_t from, std::size_t length) {
      return from < text.size() ? number_of<double>(text.substr(from, length)) : std::nullopt;
    };
    const auto hours = part(0, 2), minutes = part(3, 2), seconds = part(6, std::string_view::npos);
    if (!hours || !minutes || !seconds) fail(fmt::format("time '{}'; allowed hh:mm:ss.ssssss", text));
    const std::size_t point = text.find('.');
    return {(*hours * 3600 + *minutes * 60) * 1e9 + std::round(*seconds * 1e9),
            point == std::string_view::npos ? 0 : static_cast<int>(text.size() - point - 1)};
  }

  void read_times() {
    const auto line_frequency = next("the line frequency");
    if (!line_frequency[0].empty())
      out_.line_hertz = number<double>(line_frequency, 0, "line frequency", 0.0, 1e4);
    const auto rates = number<int>(next("the number of rates"), 0, "number of sampling rates", 0, 1000);
    for (int i = 0; i < std::max(rates, 1); ++i) {
      const auto cells = next("the sampling rates");
      const std::int64_t before = rates_.empty() ? 0 : rates_.back().last;
      rates_.push_back({number<double>(cells, 0, "sampling rate", 0.0, 1e9),
                        number<std::int64_t>(cells, 1, "number of the last sample", before + 1,
                                             static_cast<std::int64_t>(most_rows))});
    }
    const Clock start = clock_of(next("the time of the first sample"));
    const Clock trigger = clock_of(next("the time of the trigger"));
    constexpr double day = 86400e9;
    before_trigger_ = 1e-9 * std::remainder(trigger.nanoseconds - start.nanoseconds, day);
    stamp_ = start.decimals > 6 ? 1e-9 : 1e-6;
    format_ = std::string(next("the format of the data")[0]);
    for (char& c : format_) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
    if (format_ != "ASCII" && format_ != "BINARY" && format_ != "BINARY32" && format_ != "FLOAT32")
      fail(fmt::format("format '{}'; allowed ASCII, BINARY, BINARY32, FLOAT32", format_));
    if (!bare(rest_.substr(0, rest_.find('\n'))).empty())
      stamp_ *= number<double>(next("the multiplier of time"), 0, "multiplier of the time stamps", 1e-9, 1e9);
  }

  /// Time of sample `n`, counted from 0; `stamp` where the file states no rate.
  double time_of(std::int64_t n, double stamp) const {
    if (rates_.front().hertz == 0.0) return stamp * stamp_ - before_trigger_;
    double time = 0.0;
    std::int64_t first = 0;
    for (const Rate& r : rates_) {
      // the interval behind a sample is that of the rate the sample belongs to
      if (n < r.last || &r == &rates_.back())
        return time + static_cast<double>(n - first) / r.hertz - before_trigger_;
      time += static_cast<double>(r.last - first) / r.hertz;
      first = r.last;
    }
    return time;
  }

  void begin_row(std::int64_t row, std::optional<double> stamp) {
    if (rates_.front().hertz == 0.0 && !stamp)
      fail_data(row, "has no time stamp, and the configuration no sampling rate");
    out_.time.push_back(time_of(row - 1, stamp.value_or(0.0)));
  }
  void add(std::size_t channel, std::optional<double> raw) {
    const AnalogRow& a = rows_[channel];
    out_.channels[channel].value.push_back(raw ? a.factor * *raw + a.offset : nothing);
  }

  void read_ascii() {
    const std::int64_t rows = rates_.back().last;
    std::string_view rest = data_;
    for (std::int64_t row = 1; row <= rows; ++row) {
      while (!rest.empty() && (rest.front() == '\n' || rest.front() == '\r' || rest.front() == '\x1a'))
        rest.remove_prefix(1);
      if (rest.empty())
        fail_data(row, fmt::format("the file ends; the configuration promises {} rows", rows));
      const std::size_t end = rest.find('\n');
      const auto cells = cells_of(rest.substr(0, end));
      rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
      if (cells.size() < static_cast<std::size_t>(2 + analog_))
        fail_data(row, fmt::format("{} cells; allowed {} or more", cells.size(), 2 + analog_));
      begin_row(row, number_of<double>(cells[1]));
      for (std::size_t c = 0; c < rows_.size(); ++c) {
        const std::string_view cell = cells[2 + c];
        const auto raw = number_of<double>(cell);
        if (!raw && !cell.empty())
          fail_data(row, fmt::format("channel {} = '{}'; allowed a number", out_.channels[c].name, cell));
        add(c, raw && *raw == 99999.0 ? std::nullopt : raw);
      }
    }
  }

  template <class Word>
  Word word(std::size_t at) const {
    std::array<unsigned char, sizeof(Word)> bytes{};
    std::memcpy(bytes.data(), data_.data() + at, sizeof(Word));
    if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Word>(bytes);
  }

  std::optional<double> sample(std::size_t at) const {
    if (format_ == "BINARY") {
      const auto raw = word<std::int16_t>(at);
      return raw == std::numeric_limits<std::int16_t>::min() ? std::nullopt : std::optional<double>(raw);
    }
    if (format_ == "BINARY32") {
      const auto raw = word<std::int32_t>(at);
      return raw == std::numeric_limits<std::int32_t>::min() ? std::nullopt : std::optional<double>(raw);
    }
    const auto raw = static_cast<double>(word<float>(at));
    return std::isfinite(raw) && raw != static_cast<double>(std::numeric_limits<float>::lowest())
               ? std::optional<double>(raw)
               : std::nullopt;
  }

  void read_binary() {
    const std::size_t width = format_ == "BINARY" ? 2 : 4;
    const std::size_t step = 8 + width * rows_.size() + 2 * ((static_cast<std::size_t>(digital_) + 15) / 16);
    const std::int64_t rows = rates_.back().last;
    if (data_.size() < step * static_cast<std::size_t>(rows))
      throw BadInput({fmt::format("{}: {} bytes; {} rows of {} bytes make {}", data_file_, data_.size(), rows,
                                  step, step * static_cast<std::size_t>(rows))});
    for (std::int64_t row = 1; row <= rows; ++row) {
      const std::size_t at = step * static_cast<std::size_t>(row - 1);
      const auto stamp = word<std::uint32_t>(at + 4);
      begin_row(row, stamp == 0xFFFFFFFFU ? std::nullopt : std::optional<double>(stamp));
      for (std::size_t c = 0; c < rows_.size(); ++c) add(c, sample(at + 8 + width * c));
    }
  }

  std::string_view rest_, data_;
  std::string file_, data_file_, format_;
  int line_ = 0;
  std::int64_t analog_ = 0, digital_ = 0;
  std::vector<AnalogRow> rows_;
  std::vector<Rate> rates_;
  double before_trigger_ = 0.0, stamp_ = 1e-6;
  Comtrade out_;
};

std::string bytes_of(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw BadInput({path.string() + ": cannot be read: " + std::strerror(errno != 0 ? errno : ENOENT)});
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string ending(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  return text;
}

/// One file with headings `--- file type: CFG ---` and `--- file type: DAT ASCII ---`.
Comtrade parse_single(std::string_view text, const std::string& file) {
  constexpr std::string_view heading = "--- file type:";
  std::string_view configuration, data;
  for (std::size_t at = text.find(heading); at != std::string_view::npos;) {
    const std::size_t line = text.find('\n', at);
    if (line == std::string_view::npos) break;
    const std::string_view kind = bare(text.substr(at + heading.size(), line - at - heading.size()));
    const bool binary = kind.starts_with("DAT") && kind.find("ASCII") == std::string_view::npos;
    // bytes may look like a heading: what follows them is not looked at
    const std::size_t next = binary ? std::string_view::npos : text.find(heading, line);
    const std::string_view part =
        text.substr(line + 1, next == std::string_view::npos ? next : next - line - 1);
    if (kind.starts_with("CFG")) configuration = part;
    if (kind.starts_with("DAT")) data = part;
    at = next;
  }
  if (configuration.empty() || data.empty())
    throw BadInput({file + ": no part " + (configuration.empty() ? "CFG" : "DAT") +
                    "; allowed a COMTRADE file of 2013"});
  return parse_comtrade(configuration, data, file, file);
}

}  // namespace

Comtrade parse_comtrade(std::string_view configuration, std::string_view data,
                        const std::string& configuration_file, const std::string& data_file) {
  return Parser(configuration, data, configuration_file, data_file).run();
}

bool is_comtrade(const std::filesystem::path& path) {
  const std::string e = ending(path);
  return e == ".cfg" || e == ".dat" || e == ".cff";
}

Comtrade read_comtrade(const std::filesystem::path& path) {
  if (ending(path) == ".cff") return parse_single(bytes_of(path), path.string());
  const bool upper = path.extension().string().find_first_of("CD") == 1;
  std::filesystem::path configuration = path, data = path;
  configuration.replace_extension(upper ? ".CFG" : ".cfg");
  data.replace_extension(upper ? ".DAT" : ".dat");
  return parse_comtrade(bytes_of(configuration), bytes_of(data), configuration.string(), data.string());
}

CsvTable to_table(const Comtrade& c) {
  CsvTable table;
  table.header.emplace_back("time [s]");
  table.columns.push_back(c.time);
  table.delay.push_back(0.0);
  for (const Comtrade::Channel& channel : c.channels) {
    table.header.push_back(channel.name + " [" + channel.unit + "]");
    table.columns.push_back(channel.value);
    table.delay.push_back(-channel.skew);
  }
  for (std::size_t row = 0; row < c.time.size(); ++row)
    table.line.push_back(static_cast<std::uint32_t>(row + 1));
  return table;
}

}  // namespace powbench::host
