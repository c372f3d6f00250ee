#include "host/import/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "host/import/scope_header.h"
#include "host/import/trace_shape.h"

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
      out_.columns.push_back(
          {.column = c, .channel = {}, .ground = Ground::guess, .sure = Sureness::unsure, .why = ""});
    }
  }

  Suggested run() {
    each(Ground::name, [&](Suggestion& s) {
      s.why = "its name", s.sure = Sureness::sure;
      return named(title_of(table_.header[s.column]).name);
    });
    each(Ground::unit, [&](Suggestion& s) -> std::optional<Channel> {
      const Title title = title_of(table_.header[s.column]);
      const std::string& unit = title.unit;
      for (const Channel c : by_unit(unit))
        if (!taken_[index(c)]) {
          s.why = "the first free channel in " + unit;
          s.sure = by_unit(unit).size() == 1 ? Sureness::sure : Sureness::likely;
          return c;
        }
      return std::nullopt;
    });
    if (time_ < table_.header.size()) {
      find_coil();
      each(Ground::shape, [&](Suggestion& s) -> std::optional<Channel> {
        if (unit_is_other(s.column)) return std::nullopt;
        const auto looks = looks_of(s.column);
        if (!looks) return std::nullopt;
        s.why = looks->why, s.sure = looks->sure;
        return looks->channel;
      });
      find_hold();
    }
    each(Ground::guess, [&](Suggestion& s) -> std::optional<Channel> {
      if (unit_is_other(s.column)) return std::nullopt;
      s.sure = Sureness::unsure;
      const auto shape = shape_in(s.column);
      if (shape && shape->is_mains()) {
        s.why = "a sine of mains frequency: no force; the channels of the mains are taken";
        return std::nullopt;
      }
      if (shape && shape->arrives() && shape->rise > slow_rise && !taken_[index(Channel::laser)]) {
        s.why = "rest, then another level: a travel, or the current of a DC coil";
        return Channel::laser;
      }
      for (const Channel c : {Channel::pvdf_a, Channel::pvdf_b, Channel::coil_current, Channel::aux})
        if (!taken_[index(c)]) {
          s.why = "what is left over, in the order of the columns";
          return c;
        }
      return std::nullopt;
    });
    for (Suggestion& s : out_.columns)
      if (!s.channel && s.why.empty()) s.why = "no channel fits, or it is taken";
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

  std::optional<TraceShape> shape_in(std::size_t column) const {
    if (time_ == table_.header.size()) return std::nullopt;
    CoilOn on = on_;
    if (!std::isfinite(on.to)) on.to = returns_at(seconds_, table_.columns[column]);
    return shape_of(seconds_, table_.columns[column], on);
  }
  std::optional<Looks> looks_of(std::size_t column) const {
    const auto shape = shape_in(column);
    return shape ? shaped(*shape) : std::nullopt;
  }

  /// Coil voltage, or without one the current, by name, unit or by what it looks like up to its own end: when it begins,
  /// and when it ends. All others are judged by the time in between.
  void find_coil() {
    for (const Channel wanted : {Channel::coil_voltage, Channel::coil_current})
      for (const Suggestion& s : out_.columns) {
        if (s.channel ? s.channel != wanted : unit_is_other(s.column)) continue;
        const auto& v = table_.columns[s.column];
        const double from = begins(v), to = returns_at(seconds_, v);
        if (!s.channel) {
          const auto shape = shape_of(seconds_, v, {from, to});
          const auto looks = shape ? shaped(*shape) : std::nullopt;
          if (!looks || looks->channel != wanted) continue;
        }
        on_ = {from, to};
        off_seen_in_ = wanted;
        if (wanted == Channel::coil_voltage && std::isfinite(from)) out_.switch_on = from;
        return;
      }
  }

  /// First sample that stands out of the first twentieth; infinite where that is not quiet.
  double begins(const std::vector<double>& v) const {
    double peak = 0, quiet = 0;
    for (const double x : v)
      if (std::isfinite(x)) peak = std::max(peak, std::abs(x));
    for (std::size_t i = 0; i < v.size() / 20; ++i)
      if (std::isfinite(v[i])) quiet = std::max(quiet, std::abs(v[i]));
    if (quiet <= 0.1 * peak)
      for (std::size_t i = 0; i < v.size(); ++i)
        if (std::abs(v[i]) > std::max(3 * quiet, 0.05 * peak)) return seconds_[i];
    return std::numeric_limits<double>::infinity();
  }

  /// A column that was looked at as the coil's and became another's by its name says nothing.
  void find_hold() {
    const bool there = std::any_of(out_.columns.begin(), out_.columns.end(),
                                   [&](const Suggestion& s) { return s.channel == off_seen_in_; });
    if (!there || !std::isfinite(on_.to)) return;
    const double hold = on_.to - out_.switch_on.value_or(0.0);
    if (!(hold > 0)) return;
    out_.hold = hold;
    out_.hold_why = fmt::format(
        "{} ends at {:.1f} ms; what comes later is no closing",
        off_seen_in_ == Channel::coil_voltage ? "the coil voltage" : "the coil current", on_.to * 1e3);
  }

  const CsvTable& table_;
  std::size_t time_ = table_.header.size();
  std::vector<double> seconds_;
  CoilOn on_;
  Channel off_seen_in_ = Channel::coil_voltage;
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

std::string_view name(Sureness sure) {
  static constexpr std::array names{"sure", "likely", "unsure"};
  return names[static_cast<std::size_t>(sure)];
}

Suggested suggest_columns(const CsvTable& table) {
  return Chooser(table).run();
}

std::string suggested_file(const CsvTable& table, const Suggested& s, const std::string& waveform) {
  std::string out = fmt::format(
      "# What the columns of {} are taken for. A suggestion: check every line, above all those that are not "
      "sure.\n"
      "# All keys of this file: powbench plan template calibration\n\n"
      "# calibration = \"NAME\"   # of the calibration in force; without it all results are flagged\n",
      waveform);
  if (s.switch_on)
    out += fmt::format("switch_on_s = {:.9g}  # where the coil voltage begins\n", *s.switch_on);
  else
    out += "# switch_on_s = 0.0   # when the coil was switched on, on the time column\n";
  if (s.hold)
    out += fmt::format("hold_ms = {:.6g}  # {}\n", *s.hold * 1e3, s.hold_why);
  else
    out += "# hold_ms = 100.0   # how long the coil was on, where the record goes on behind its switch-off\n";
  out +=
      "# closing_angle_deg = 90.0   # where you know it and the record does not show it\n"
      "\n[columns]\n";
  if (!s.time.empty() && lower(title_of(s.time).name) != "time")
    out += fmt::format("time = {}\n", quoted(s.time));
  for (const Suggestion& c : s.columns)
    out += c.channel
               ? fmt::format("{} = {}  # {}, by {}: {}\n", info(*c.channel).name,
                             quoted(with_unit(table.header[c.column])), name(c.sure), name(c.ground), c.why)
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
