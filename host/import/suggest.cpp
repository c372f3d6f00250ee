#include "host/import/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "core/phase.h"
#include "host/import/scope_header.h"

namespace powbench::host {
namespace {

struct Words {
  Channel channel;
  std::vector<std::string_view> words;
};
/// Parts of names, in lower case; the longest that fits decides.
const std::vector<Words>& vocabulary() {
  static const std::vector<Words> table{
      {Channel::pvdf_a,
       {"pvdf_a", "pvdf a", "pvdf1", "force_a", "force a", "force1", "force 1", "f_a", "kraft a", "kraft1"}},
      {Channel::pvdf_b,
       {"pvdf_b", "pvdf b", "pvdf2", "force_b", "force b", "force2", "force 2", "f_b", "kraft b", "kraft2"}},
      {Channel::laser, {"laser", "travel", "displacement", "distance", "position", "stroke", "hub", "weg"}},
      {Channel::coil_current,
       {"coil_current", "coil current", "icoil", "i_coil", "i coil", "current", "spulenstrom", "strom"}},
      {Channel::coil_voltage,
       {"coil_voltage", "coil voltage", "ucoil", "vcoil", "u_coil", "v_coil", "spulenspannung"}},
      {Channel::mains_voltage, {"mains", "line voltage", "umains", "netz", "grid", "supply"}},
      {Channel::contact_a, {"contact", "pole", "kontakt"}},
      {Channel::aux, {"accel", "aux"}},
  };
  return table;
}

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

struct Title {
  std::string name, unit;
};
Title title_of(const std::string& header) {
  Title title;
  title.name = header;
  const std::size_t open = header.rfind(" [");
  if (open == std::string::npos || header.back() != ']') return title;
  title.name.resize(open);
  title.unit.assign(header, open + 2, header.size() - open - 3);
  return title;
}

std::optional<Channel> named(const std::string& name) {
  const std::string text = lower(name);
  std::optional<Channel> best;
  std::size_t length = 0;
  for (const Words& w : vocabulary())
    for (const std::string_view word : w.words)
      if (word.size() > length && text.find(word) != std::string::npos)
        best = w.channel, length = word.size();
  return best;
}

/// What a column looks like; values thinned to a few thousand.
struct Shape {
  double low = 0, high = 0;
  double sine_early = 0,
         sine_late = 0;  ///< share of the variance that a sine of 40 to 70 Hz explains, first and last third
  double early = 0, late = 0;  ///< rms about the mean, first and last third
  double start = 0, end = 0;   ///< mean of the first and the last tenth
  double between = 1;          ///< share of samples that are near neither start nor end
  double beyond = 0;           ///< largest excursion outside start .. end, of their distance
  double span() const { return high - low; }
};

/// Share of the variance of v that a mean and the best sine of 45 to 65 Hz explain; the rest is noise and others.
double sine_share(const std::vector<double>& t, const std::vector<double>& v, std::size_t from,
                  std::size_t to) {
  double best = 0;
  for (double hertz = 45; hertz <= 65; hertz += 1) {
    // least squares of mean, cosine and sine, by normal equations
    std::array<std::array<double, 4>, 3> m{};
    double vv = 0, sum = 0;
    for (std::size_t i = from; i < to; ++i) {
      const double phase = 2 * pi * hertz * t[i];
      const std::array<double, 3> row{1.0, std::cos(phase), std::sin(phase)};
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) m[a][b] += row[a] * row[b];
        m[a][3] += row[a] * v[i];
      }
      vv += v[i] * v[i], sum += v[i];
    }
    const auto n = static_cast<double>(to - from);
    const double total = vv - sum * sum / n;
    if (!(total > 0)) return 0;
    const std::array<double, 3> rhs{m[0][3], m[1][3], m[2][3]};
    bool singular = false;
    for (std::size_t p = 0; p < 3; ++p)
      for (std::size_t r = p + 1; r < 3; ++r) {
        if (std::abs(m[p][p]) < 1e-12) singular = true;
        const double f = m[r][p] / m[p][p];
        for (std::size_t c = p; c < 4; ++c) m[r][c] -= f * m[p][c];
      }
    if (singular) continue;
    std::array<double, 3> x{};
    for (std::size_t p = 3; p-- > 0;) {
      double s = m[p][3];
      for (std::size_t c = p + 1; c < 3; ++c) s -= m[p][c] * x[c];
      x[p] = s / m[p][p];
    }
    const double fitted = x[0] * rhs[0] + x[1] * rhs[1] + x[2] * rhs[2] - sum * sum / n;
    best = std::max(best, fitted / total);
  }
  return best;
}

double mean(const std::vector<double>& v, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += v[i];
  return sum / static_cast<double>(to - from);
}

double rms(const std::vector<double>& v, std::size_t from, std::size_t to) {
  const double m = mean(v, from, to);
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += (v[i] - m) * (v[i] - m);
  return std::sqrt(sum / static_cast<double>(to - from));
}

std::optional<Shape> shape_of(const std::vector<double>& time, const std::vector<double>& column) {
  std::vector<double> t, v;
  const std::size_t step = std::max<std::size_t>(1, column.size() / 4000);
  for (std::size_t i = 0; i < column.size(); i += step)
    if (std::isfinite(column[i]) && std::isfinite(time[i])) t.push_back(time[i]), v.push_back(column[i]);
  const std::size_t n = v.size();
  if (n < 60) return std::nullopt;
  Shape s;
  s.low = *std::min_element(v.begin(), v.end()), s.high = *std::max_element(v.begin(), v.end());
  s.early = rms(v, 0, n / 5), s.late = rms(v, 2 * n / 3, n);
  s.sine_early = sine_share(t, v, 0, n / 3), s.sine_late = sine_share(t, v, 2 * n / 3, n);
  s.start = mean(v, 0, n / 10), s.end = mean(v, n - n / 10, n);
  const double distance = std::abs(s.end - s.start);
  if (!(distance > 0)) return s;
  std::size_t between = 0;
  for (const double x : v) {
    if (std::abs(x - s.start) > 0.15 * distance && std::abs(x - s.end) > 0.15 * distance) ++between;
    s.beyond =
        std::max(s.beyond, std::max(std::min(s.start, s.end) - x, x - std::max(s.start, s.end)) / distance);
  }
  s.between = static_cast<double>(between) / static_cast<double>(n);
  return s;
}

/// Shapes that only one channel has.
std::optional<Channel> shaped(const Shape& s, std::string& why) {
  constexpr double a_sine = 0.9;
  if (s.sine_early > a_sine && s.sine_late > a_sine && s.early > 0.5 * s.late) {
    why = "a sine of mains frequency from beginning to end";
    return Channel::mains_voltage;
  }
  if (s.sine_late > a_sine && s.early < 0.2 * s.late && s.span() > 20) {
    why = "rest, then a sine of mains frequency of some volts and more";
    return Channel::coil_voltage;
  }
  const double distance = std::abs(s.end - s.start);
  const bool arrives = distance > 0.6 * s.span() && s.late < 0.1 * distance && s.early < 0.1 * distance;
  if (arrives && std::abs(s.end) < 0.1 * std::abs(s.start) && s.between < 0.03) {
    why = "one level, then zero, hardly anything between";
    return Channel::contact_a;
  }
  if (arrives && s.beyond < 0.3 && std::abs(s.start) < 0.5 * std::abs(s.end) && s.between < 0.3) {
    why = "rest, then another level, and no pulsation there";
    return Channel::laser;
  }
  return std::nullopt;
}

std::vector<Channel> by_unit(const std::string& unit) {
  std::vector<Channel> list;
  if (unit == "N" || unit == "mN") list = {Channel::pvdf_a, Channel::pvdf_b};
  if (unit == "m" || unit == "mm" || unit == "um") list = {Channel::laser};
  if (unit == "A" || unit == "mA") list = {Channel::coil_current};
  return list;
}

class Chooser {
 public:
  explicit Chooser(const CsvTable& table) : table_(table) {
    for (std::size_t c = 0; c < table.header.size(); ++c) {
      const Title t = title_of(table.header[c]);
      if (time_ == table.header.size() && is_time_name(t.name)) {
        time_ = c;
        out_.time = table.header[c];
        seconds_ = table.columns[c];
        const ScopeUnit unit = scope_unit(t.unit);
        const double factor = unit.unit == "ms" ? 1e-3 : unit.unit == "us" ? 1e-6 : 1.0;
        for (double& s : seconds_) s *= factor * unit.factor;
        continue;
      }
      out_.columns.push_back({.column = c, .channel = {}, .ground = Ground::guess, .why = ""});
    }
  }

  Suggested run() {
    each(Ground::name, [&](Suggestion& s) {
      s.why = "its name";
      return named(title_of(table_.header[s.column]).name);
    });
    each(Ground::unit, [&](Suggestion& s) -> std::optional<Channel> {
      const Title title = title_of(table_.header[s.column]);
      const std::string& unit = title.unit;
      for (const Channel c : by_unit(unit))
        if (!taken_[index(c)]) {
          s.why = "the first free channel in " + unit;
          return c;
        }
      return std::nullopt;
    });
    if (time_ < table_.header.size()) {
      each(Ground::shape, [&](Suggestion& s) -> std::optional<Channel> {
        if (unit_is_other(s.column)) return std::nullopt;
        const auto shape = shape_of(seconds_, table_.columns[s.column]);
        return shape ? shaped(*shape, s.why) : std::nullopt;
      });
      find_switch_on();
    }
    each(Ground::guess, [&](Suggestion& s) -> std::optional<Channel> {
      if (unit_is_other(s.column)) return std::nullopt;
      for (const Channel c : {Channel::pvdf_a, Channel::pvdf_b, Channel::coil_current, Channel::aux})
        if (!taken_[index(c)]) {
          s.why = "what is left over, in the order of the columns";
          return c;
        }
      return std::nullopt;
    });
    for (Suggestion& s : out_.columns)
      if (!s.channel) s.why = "no channel fits, or it is taken";
    return std::move(out_);
  }

 private:
  template <class F>
  void each(Ground ground, F&& choose) {
    for (Suggestion& s : out_.columns) {
      if (s.channel) continue;
      const auto c = choose(s);
      if (!c || taken_[index(*c)]) continue;
      s.channel = c, s.ground = ground;
      taken_[index(*c)] = true;
    }
  }

  /// In a unit that no channel has, or one whose channels are taken.
  bool unit_is_other(std::size_t column) const {
    const Title title = title_of(table_.header[column]);
    const std::string& unit = title.unit;
    return unit != "V" && unit != "mV" && !unit.empty();
  }

  void find_switch_on() {
    for (const Suggestion& s : out_.columns) {
      if (s.channel != Channel::coil_voltage) continue;
      const auto& t = seconds_;
      const auto& v = table_.columns[s.column];
      double peak = 0, quiet = 0;
      for (const double x : v)
        if (std::isfinite(x)) peak = std::max(peak, std::abs(x));
      for (std::size_t i = 0; i < v.size() / 20; ++i)
        if (std::isfinite(v[i])) quiet = std::max(quiet, std::abs(v[i]));
      if (quiet > 0.1 * peak) return;
      for (std::size_t i = 0; i < v.size(); ++i)
        if (std::abs(v[i]) > std::max(3 * quiet, 0.05 * peak)) {
          out_.switch_on = t[i];
          return;
        }
    }
  }

  const CsvTable& table_;
  std::size_t time_ = table_.header.size();
  std::vector<double> seconds_;
  std::array<bool, channel_count> taken_{};
  Suggested out_;
};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  }
  return out + "\"";
}

/// A column without a unit is taken as V; the file says so where a person sees it.
std::string with_unit(const std::string& header) {
  return title_of(header).unit.empty() ? header + " [V]" : header;
}

}  // namespace

std::string_view name(Ground ground) {
  static constexpr std::array names{"name", "shape", "unit", "guess"};
  return names[static_cast<std::size_t>(ground)];
}

Suggested suggest_columns(const CsvTable& table) {
  return Chooser(table).run();
}

std::string suggested_file(const CsvTable& table, const Suggested& s, const std::string& waveform) {
  std::string out = fmt::format(
      "# What the columns of {} are taken for. A suggestion: check every line, above all those of `guess`.\n"
      "# All keys of this file: powbench plan template calibration\n\n"
      "# calibration = \"NAME\"   # of the calibration in force; without it all results are flagged\n",
      waveform);
  if (s.switch_on)
    out += fmt::format("switch_on_s = {:.9g}  # where the coil voltage begins\n", *s.switch_on);
  else
    out += "# switch_on_s = 0.0   # when the coil was switched on, on the time column\n";
  out +=
      "# closing_angle_deg = 90.0   # where you know it and the record does not show it\n"
      "\n[columns]\n";
  if (!s.time.empty() && lower(title_of(s.time).name) != "time")
    out += fmt::format("time = {}\n", quoted(s.time));
  for (const Suggestion& c : s.columns)
    out += c.channel ? fmt::format("{} = {}  # {}: {}\n", info(*c.channel).name,
                                   quoted(with_unit(table.header[c.column])), name(c.ground), c.why)
                     : fmt::format("# {} : {}\n", quoted(table.header[c.column]), c.why);
  for (const Suggestion& c : s.columns) {
    if (!c.channel || info(*c.channel).unit == "V") continue;
    const Title title = title_of(table.header[c.column]);
    const std::string& unit = title.unit;
    if (unit != "V" && unit != "mV" && !unit.empty()) continue;
    const std::string_view own = info(*c.channel).unit;
    out += fmt::format(
        "\n[{}]\n# gain_{}_per_V = ?   # the column is in {}: what one volt stands for; or certificate = "
        "\"FILE.xml\"\n",
        info(*c.channel).name, own == "m" ? "mm" : own, unit.empty() ? "V" : unit);
  }
  return out;
}

}  // namespace powbench::host
