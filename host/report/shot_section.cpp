#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/compare.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr std::size_t most_listed = 400;

std::string value_text(const ReportShot& shot, std::string_view symbol) {
  return shot.events ? with_uncertainty(find_quantity(symbol)->of(*shot.events), 2, 1e3, 3)
                     : std::string(no_value);
}

std::string reached_text(const ReportShot& shot) {
  if (!shot.events) return std::string(no_value);
  Measured m = shot.events->coil.closing_angle;
  // shown next to the commanded angle: 359.9 deg for a commanded 0 deg reads as -0.1
  const double asked = effective_angle(shot.conditions);
  m.value = asked + wrap_half_turn(m.value - asked);
  return with_uncertainty(m, 2, degrees(1), 2);
}

/// What the simulation of its angle says at the angle, voltage and frequency that this closing reached.
std::string own_simulated(const ReportInput& input, const ReportShot& shot, std::string_view symbol) {
  const auto by = shot.moved.find(std::string(symbol));
  for (const SimulatedClosing& s : input.simulated)
    if (by != shot.moved.end() && same_angle(s.closing_angle, effective_angle(shot.conditions)))
      return fixed((find_quantity(symbol)->of(s.events).value + by->second) * 1e3, 3);
  return std::string(no_value);
}

/// Everything that makes a shot doubtful: its reason in words, its flags as letters that are explained below the table.
class Remarks {
 public:
  std::string of(const ReportShot& shot) {
    std::string text = shot.reason;
    if (!shot.events) return text;
    const Events& e = *shot.events;
    const std::uint32_t flags = e.flags | e.coil.flags | e.core.flags | timing_train(e).flags;
    std::string letters;
    for (std::uint32_t flag = 1; flag != 0; flag <<= 1) {
      if ((flags & flag) == 0 || flags_text(flag).empty()) continue;
      const auto seen = std::find(seen_.begin(), seen_.end(), flag);
      letters +=
          (letters.empty() ? "" : ", ") + std::string(1, static_cast<char>('a' + (seen - seen_.begin())));
      if (seen == seen_.end()) seen_.push_back(flag);
    }
    if (!text.empty() && !letters.empty()) text += "; ";
    return text + letters;
  }
  /// "a: clipped; b: ..."; empty without a flag.
  std::string legend() const {
    std::string text;
    for (std::size_t i = 0; i < seen_.size(); ++i)
      text +=
          fmt::format("{}{}: {}", i ? "; " : "Remarks: ", static_cast<char>('a' + i), flags_text(seen_[i]));
    return text;
  }

 private:
  std::vector<std::uint32_t> seen_;
};

/// "2 shots were fired again after an error: 2 (ERROR), 8 (TIMEOUT, ERROR)."; empty: none was.
std::string fired_again(const ReportInput& input) {
  constexpr std::size_t most_named = 20;
  std::string list;
  std::size_t n = 0;
  for (const ReportShot& shot : input.shots) {
    if (shot.earlier.empty() || ++n > most_named) continue;
    std::string how;
    for (const Outcome o : shot.earlier) how += fmt::format("{}{}", how.empty() ? "" : ", ", name(o));
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", shot.index, how);
  }
  if (n == 0) return {};
  if (n > most_named) list += fmt::format(" and {} more", n - most_named);
  return fmt::format("{} fired again after an error: {}.",
                     n == 1 ? "1 shot was" : fmt::format("{} shots were", n), list);
}

}  // namespace

Markup shot_section(const ReportInput& input) {
  Markup out;
  out.open("section", {{"id", "shots"}, {"tabindex", "0"}, {"aria-label", "every shot"}});
  out.element("h2", "Every shot, in executed order");
  if (input.shots.empty()) {
    out.element("p", "No shot has been fired.");
    return out.close();
  }
  out.open("table", {{"class", "shots"}}).open("thead").open("tr");
  for (const std::string_view head :
       {"shot", "asked", "reached \xC2\xB1 U / \xC2\xB0", "U of rig / \xC2\xB0", "outcome",
        "t_ct1 \xC2\xB1 U / ms", "t_ct1 sim. / ms", "t_ct_bon \xC2\xB1 U / ms", "t_xt1 \xC2\xB1 U / ms",
        "re-openings", "seed", "record", "remarks"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  std::size_t left_out = 0, listed = 0;
  Remarks remarks;
  for (const auto& shot : input.shots) {
    // of a long campaign those that are not in order come first of all
    const bool plain = shot.outcome == Outcome::pass || shot.outcome == Outcome::not_judged;
    if ((plain && input.shots.size() > most_listed && listed >= most_listed / 2) || listed >= most_listed) {
      ++left_out;
      continue;
    }
    ++listed;
    out.open("tr");
    out.element("td", fmt::format("{}", shot.index));
    // an import was not commanded, unless its file says so: the angle found is no angle asked for
    const double asked = effective_angle(shot.conditions);
    const bool found = input.origin == Origin::import && shot.events &&
                       std::fabs(wrap_half_turn(shot.events->coil.closing_angle.value - asked)) < 1e-9;
    out.element("td", found ? std::string(no_value) : angle_text(asked));
    out.element("td", reached_text(shot), {{"class", "nowrap"}});
    out.element("td", fixed(degrees(2 * shot.phase_u), 3));
    out.open("td").element("span", name(shot.outcome), {{"class", badge_class(shot.outcome)}}).close();
    for (const std::string_view symbol : {"t_ct1", "t_ct_bon", "t_xt1"}) {
      out.element("td", value_text(shot, symbol), {{"class", "nowrap"}});
      if (symbol == "t_ct1") out.element("td", own_simulated(input, shot, symbol), {{"class", "sim"}});
    }
    const bool train = shot.events && !timing_train(*shot.events).contacts.empty();
    out.element("td",
                train ? fmt::format("{}", timing_train(*shot.events).bounce_count) : std::string(no_value));
    out.element("td",
                input.origin == Origin::import ? std::string(no_value)  // nobody drew one
                                               : fmt::format("{:x}", shot.conditions.seed),
                {{"class", "code"}});
    out.element("td", short_hash(shot.record_hash), {{"class", "code"}});
    out.element("td", remarks.of(shot), {{"class", "left"}});
    out.close();
  }
  out.close().close();
  if (left_out > 0)
    out.element("p",
                fmt::format("{} more are not listed here; powbench shots lists all, powbench show ID one.",
                            left_out));
  if (const std::string again = fired_again(input); !again.empty()) out.element("p", again);
  if (const std::string legend = remarks.legend(); !legend.empty())
    out.element("p", legend + ".", {{"class", "fine"}});
  out.element(
      "p",
      "Contact times are those of the channel named under Definitions. \xC2\xB1 is U (k = 2). Simulated: at "
      "the angle, voltage and frequency that this closing reached. U of rig: that "
      "of the phase of the mains at the closing angle, as the rig knew it when it fired. Seeds are "
      "hexadecimal.",
      {{"class", "fine"}});
  return out.close();
}

}  // namespace powbench::host
