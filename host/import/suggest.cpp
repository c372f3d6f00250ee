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
       {"coil_current", "coil current", "icoil", "i_coil", "i coil", "current", "spulenstrom", "strom",
        "ispule", "i_spule"}},
      {Channel::coil_voltage,
       {"coil_voltage", "coil voltage", "ucoil", "vcoil", "u_coil", "v_coil", "spulenspannung", "uspule",
        "u_spule"}},
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
  if (header.starts_with("in ")) return {header, header.substr(3)};  // the time, as some instruments write it
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

/// Words that leave more than one channel: either film, the coil's voltage or current.
std::vector<Channel> hinted(const Title& title) {
  const std::string text = lower(title.name);
  const auto has = [&](std::string_view word) { return text.find(word) != std::string::npos; };
  if (has("force") || has("kraft") || has("pvdf")) return {Channel::pvdf_a, Channel::pvdf_b};
  if (!has("coil") && !has("spule")) return {};
  if (title.unit == "A" || title.unit == "mA") return {Channel::coil_current};
  return {Channel::coil_voltage, Channel::coil_current};
}

/// A contact [N] is a force: the unit is not one of the channel's, nor volts before a gain.
bool fits_unit(Channel c, const std::string& unit) {
  if (unit.empty() || unit == "V" || unit == "mV") return true;
  const std::string_view own = info(c).unit;
  return own != "V" && (unit == own || unit == "m" + std::string(own) || (own == "m" && unit == "um"));
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
        take_time(c, "its name");
        continue;
      }
      out_.columns.push_back(
          {.column = c, .channel = {}, .ground = Ground::guess, .sure = Sureness::unsure, .why = ""});
    }
    std::erase_if(out_.columns, [&](const Suggestion& s) {
      if (time_ < table.header.size() || !rises(table.columns[s.column])) return false;
      take_time(s.column, "rises from row to row");
      return true;
    });
  }

  Suggested run() {
    each(Ground::name, [&](Suggestion& s) -> std::optional<Channel> {
      const Title title = title_of(table_.header[s.column]);
      auto channel = named(title.name);
      if (channel == Channel::contact_a && !hinted(title).empty()) channel.reset();  // a contact force
      if (!channel || !fits_unit(*channel, title.unit)) return std::nullopt;
      s.why = "its name", s.sure = Sureness::sure;
      return channel;
    });
    each(Ground::name, [&](Suggestion& s) -> std::optional<Channel> {
      const Title title = title_of(table_.header[s.column]);
      const auto list = hinted(title);
      for (const Channel c : list)
        if (!taken_[index(c)] && fits_unit(c, title.unit)) {
          s.why = "the first free channel with such a name";
          s.sure = list.size() == 1 ? Sureness::sure : Sureness::likely;
          return c;
        }
      return std::nullopt;
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
      if (rises(table_.columns[s.column])) {
        s.why = "rises from row to row: a time or a count, no channel";
        return std::nullopt;
      }
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
  void take_time(std::size_t column, const char* why) {
    time_ = column;
    out_.time = table_.header[column];
    out_.time_why = why;
    seconds_ = table_.columns[column];
    const ScopeUnit unit = scope_unit(title_of(out_.time).unit);
    const double factor = unit.unit == "ms" ? 1e-3 : unit.unit == "us" ? 1e-6 : 1.0;
    for (double& s : seconds_) s *= factor * unit.factor;
  }

  /// No channel does so without one equal pair of neighbours.
  static bool rises(const std::vector<double>& v) {
    constexpr std::size_t least = 20;
    return v.size() >= least &&
           std::adjacent_find(v.begin(), v.end(), [](double a, double b) { return !(b > a); }) == v.end();
  }

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

  /// Coil voltage, or without one the current, by name, unit or by what it looks like up to its own end: when it
  /// begins and ends. All others are judged by the time in between.
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

/// The section of a channel whose column is in volts, with its gain as a comment.
std::string gain_lines(Channel channel, const std::string& unit) {
  if (unit != "V" && unit != "mV" && !unit.empty()) return "";
  const std::string_view own = info(channel).unit, name = info(channel).name;
  if (own == "V")
    return fmt::format(
        "\n[{}]\n# gain_V_per_V = 100   # of a 1:100 probe that the instrument was not told of; without it "
        "1\n",
        name);
  return fmt::format(
      "\n[{}]\n# gain_{}_per_V = ?   # the column is in {}: what one volt stands for; or certificate = "
      "\"FILE.xml\"\n",
      name, own == "m" ? "mm" : own, unit.empty() ? "V" : unit);
}

/// The time of a column without a unit, or in one that is none of time's, is taken as seconds.
std::string with_time_unit(const std::string& header) {
  const Title title = title_of(header);
  for (const char* unit : {"s", "ms", "us"})
    if (title.unit == unit) return header;
  return title.name + " [s]";
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
  if (s.time.empty())
    out +=
        "# time = \"NAME [s]\"   # no column is the time by its name, none rises; or sample_rate_hertz "
        "above\n";
  else if (lower(title_of(s.time).name) != "time")
    out += fmt::format("time = {}  # {}\n", quoted(with_time_unit(s.time)), s.time_why);
  for (const Suggestion& c : s.columns)
    out += c.channel
               ? fmt::format("{} = {}  # {}, by {}: {}\n", info(*c.channel).name,
                             quoted(with_unit(table.header[c.column])), name(c.sure), name(c.ground), c.why)
               : fmt::format("# {} : {}\n", quoted(table.header[c.column]), c.why);
  for (const Suggestion& c : s.columns)
    if (c.channel) out += gain_lines(*c.channel, title_of(table.header[c.column]).unit);
  return out;
}

}  // namespace powbench::host
