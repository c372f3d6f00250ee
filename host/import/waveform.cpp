#include "host/import/waveform.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>

#include "core/counted.h"
#include "core/origin.h"
#include "dsp/events/switch_off.h"
#include "host/config/bad_input.h"
#include "host/config/csv_table.h"
#include "host/config/test_record.h"
#include "host/import/clock.h"
#include "host/import/column.h"
#include "host/import/counts.h"
#include "host/import/foreign_table.h"

namespace powbench::host {

namespace {

constexpr std::size_t least_samples = 8;
constexpr double slowest = 1e3, fastest = 1e9;  // Hz
constexpr double quick_enough = 2.5e6;          // Hz: faster records are averaged down to about 1 MS/s
constexpr std::size_t most_ticks = 20'000'000;

/// Largest swing that is not a wrong unit, SI, by quantity.
double largest_swing(Channel c) {
  const std::string_view unit = info(c).unit;
  return unit == "N" ? 1e5 : unit == "m" ? 0.2 : unit == "A" ? 1e4 : 1e5;
}

struct Series {
  Column column;
  std::vector<double> value;  ///< (ticks) SI
  std::vector<bool> valid;    ///< (ticks) measured, or between measured ones of a slower channel
};

std::string without_semicolons(std::string text) {
  std::replace(text.begin(), text.end(), ';', ',');
  return text;
}

class Importer {
 public:
  Importer(const std::string& file, const Calibration& k, const std::string& calibration_file)
      : file_(file), k_(k), calibration_file_(calibration_file) {}

  Imported run(CsvTable table, const std::string& today) {
    table_ = std::move(table);
    columns_ = read_header(table_.header, file_, table_.header_line, std::isnan(k_.sample_rate), k_.columns);
    for (const std::string& text : table_.notes) note(text);
    for (const std::string& text : k_.notes) note(text);
    for (const Column& c : columns_)
      if (c.passed_over) note(fmt::format("column '{}': not asked for, passed over", c.title));
    check_calibrated();
    if (table_.rows() < least_samples)
      fail(table_.header_line, fmt::format("the file has {}; allowed {} or more",
                                           counted(table_.rows(), "sample"), least_samples));
    make_clock();
    Record& r = out_.record;
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (columns_[c].channel) add_channel(c);
    if (r.channels.empty()) fail(table_.header_line, "no channel has a number; allowed one or more that do");
    set_clock(r);
    set_conditions(r, today);
    if (table_.over_range)
      note(fmt::format("{} cells hold an over-range code; they count as lost", table_.over_range));
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const {
    throw BadInput({file_ + ":" + std::to_string(line) + ": " + what});
  }
  void note(std::string text) { out_.notes.push_back(std::move(text)); }

  /// Volts of a force, travel or current mean nothing without a gain; newtons with one mean two things.
  void check_calibrated() const {
    std::vector<std::string> mistakes;
    for (const Column& c : columns_) {
      if (!c.channel) continue;
      const bool gain = !std::isnan(k_.of(*c.channel).gain), voltage = info(*c.channel).unit == "V";
      const std::string_view unit = info(*c.channel).unit;
      const std::string key = fmt::format("gain_{}_per_V", unit == "m" ? "mm" : unit);
      if (!c.calibrated && !gain)
        mistakes.push_back(
            fmt::format("{}:{}: column '{}': volts need a calibration; write [{}] {} = ... into {}", file_,
                        table_.header_line, c.title, info(*c.channel).name, key, calibration_file_));
      if (c.calibrated && gain && !voltage)
        mistakes.push_back(fmt::format(
            "{}:{}: column '{}': the unit is {} already, but {} has [{}] {}; allowed one of both", file_,
            table_.header_line, c.title, unit, calibration_file_, info(*c.channel).name, key));
    }
    if (!mistakes.empty()) throw BadInput(mistakes);
  }

  std::size_t time_column() const {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (!columns_[c].channel && !columns_[c].passed_over) return c;
    return columns_.size();
  }

  void make_clock() {
    const std::size_t at = time_column();
    if (!std::isnan(k_.sample_rate)) {
      clock_.rate = k_.sample_rate;
      clock_.n = table_.rows();
      const bool first_known = at < columns_.size() && std::isfinite(table_.columns[at].front());
      clock_.t0 = first_known ? table_.columns[at].front() * columns_[at].factor : 0.0;
      for (std::size_t i = 0; i < clock_.n; ++i) clock_.tick.push_back(static_cast<std::int64_t>(i));
      return;
    }
    seconds_ = table_.columns[at];
    for (double& t : seconds_) t *= columns_[at].factor;
    const StampMistake m = check_stamps(seconds_);
    if (!m.what.empty())
      fail(static_cast<int>(table_.line[m.row]),
           fmt::format("column '{}' = {:.15g}: {}; allowed rising time stamps with enough digits, or "
                       "sample_rate_hertz in {} and no stamps",
                       columns_[at].title, table_.columns[at][m.row], m.what, calibration_file_));
    clock_ = find_clock(seconds_);
    if (!(clock_.rate >= slowest && clock_.rate <= fastest))
      fail(table_.header_line,
           fmt::format(
               "column '{}': the stamps are {:.3g} s apart; allowed {:.0e}..{:.0e} s; is the unit right?",
               columns_[at].title, 1 / clock_.rate, 1 / fastest, 1 / slowest));
    if (clock_.n > most_ticks)
      fail(table_.header_line,
           fmt::format(
               "column '{}': {:.6g} s at {:.6g} Hz, rests included, are {} samples; allowed {}: cut the file",
               columns_[at].title, seconds_.back() - seconds_.front(), clock_.rate, clock_.n, most_ticks));
    if (clock_.even)
      note(fmt::format("clock {:.9g} Hz, stamps within {:.3g} us of it", clock_.rate, clock_.error * 1e6));
    else
      note(fmt::format("time stamps are uneven: resampled at {:.9g} Hz by cubics", clock_.rate));
  }

  void add_channel(std::size_t c) {
    Series s{columns_[c], {}, {}};
    const Channel channel = *s.column.channel;
    const auto& k = k_.of(channel);
    const auto& cells = table_.columns[c];
    const auto numbers = static_cast<std::size_t>(
        std::count_if(cells.begin(), cells.end(), [](double v) { return std::isfinite(v); }));
    if (numbers == 0) {
      note(fmt::format("{}: no numbers, left out", info(channel).name));
      return;
    }
    const double gain = s.column.factor * (s.column.calibrated && std::isnan(k.gain) ? 1.0 : k.gain);
    if (clock_.even)
      place(s, cells);
    else
      interpolate(s, cells);
    for (double& v : s.value) v *= gain;
    check_swing(s);
    average(s);
    ChannelRecord to;
    to.channel = channel;
    const bool film = channel == Channel::pvdf_a || channel == Channel::pvdf_b;
    const CountsNote counts = to_counts(s.value, s.valid, film, std::abs(k.step * gain), to);
    set_clip(to, (gain > 0 ? k.clip_low : k.clip_high) * gain, (gain > 0 ? k.clip_high : k.clip_low) * gain);
    to.delay = delay_of(info(channel).name, k.delay, table_.delay.empty() ? 0.0 : table_.delay[c]);
    to.corner_hertz = k.corner_hertz;
    add_gaps(to, s.valid);
    tell(to, s, counts);
    out_.record.channels.push_back(std::move(to));
  }

  /// s: that of the sensor by the calibration and the channel's skew by the file are two delays, unless they are
  /// equal: an exported file has the sensor's as its skew.
  double delay_of(std::string_view name, double sensor, double skew) {
    constexpr double same = 0.1e-6;  // the digits of a skew
    if (sensor == 0.0 || skew == 0.0) return sensor + skew;
    const bool once = std::abs(sensor - skew) < same;
    note(fmt::format("{}: delay_us = {:g} in {} and a skew of {:g} us in the file are {}", name, sensor * 1e6,
                     calibration_file_, -skew * 1e6,
                     once ? "the same delay: it counts once" : "two delays: their sum counts"));
    return once ? sensor : sensor + skew;
  }

  /// Cells to the ticks of an even clock; between the cells of a slower channel, straight lines.
  void place(Series& s, const std::vector<double>& cells) const {
    s.value.assign(clock_.n, 0.0);
    s.valid.assign(clock_.n, false);
    std::vector<std::size_t> at;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!std::isfinite(cells[i])) continue;
      at.push_back(static_cast<std::size_t>(clock_.tick[i]));
      s.value[at.back()] = cells[i];
      s.valid[at.back()] = true;
    }
    std::vector<std::size_t> steps;
    for (std::size_t i = 1; i < at.size(); ++i) steps.push_back(at[i] - at[i - 1]);
    if (steps.empty()) return;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const std::size_t pace = *middle;
    if (pace < 2) return;
    for (std::size_t i = 1; i < at.size(); ++i) {
      const std::size_t a = at[i - 1], b = at[i];
      if (2 * (b - a) > 5 * pace) continue;
      for (std::size_t j = a + 1; j < b; ++j) {
        s.value[j] =
            s.value[a] + (s.value[b] - s.value[a]) * static_cast<double>(j - a) / static_cast<double>(b - a);
        s.valid[j] = true;
      }
    }
  }

  void interpolate(Series& s, const std::vector<double>& cells) {
    double correction = 0;
    s.value = resample(clock_, seconds_, cells, correction);
    s.valid.assign(clock_.n, true);
    for (const Gap& g : clock_.gaps)
      for (std::int64_t i = g.first; i < g.first + g.count; ++i) s.valid[static_cast<std::size_t>(i)] = false;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (std::isfinite(cells[i])) continue;
      const auto tick = std::clamp(std::lround((seconds_[i] - clock_.t0) * clock_.rate), 0L,
                                   static_cast<long>(clock_.n) - 1);
      s.valid[static_cast<std::size_t>(tick)] = false;
    }
    note(fmt::format("{}: interpolating changed no value by more than {:.3g} {}",
                     info(*s.column.channel).name, correction * s.column.factor,
                     info(*s.column.channel).unit));
  }

  void check_swing(const Series& s) const {
    double low = INFINITY, high = -INFINITY;
    for (std::size_t i = 0; i < s.value.size(); ++i)
      if (s.valid[i]) low = std::min(low, s.value[i]), high = std::max(high, s.value[i]);
    const Channel c = *s.column.channel;
    if (!(high - low <= largest_swing(c)) || !(std::max(std::abs(low), std::abs(high)) < 1e9))
      fail(table_.header_line,
           fmt::format(
               "column '{}': the values reach from {:.4g} to {:.4g} {}; allowed a swing of {:g} {}; is the "
               "unit right, or the gain in {}?",
               s.column.title, low, high, info(c).unit, largest_swing(c), info(c).unit, calibration_file_));
  }

  std::size_t per() const {
    return clock_.rate > quick_enough ? static_cast<std::size_t>(clock_.rate / 1e6) : 1;
  }

  void average(Series& s) const {
    const std::size_t m = per();
    if (m < 2) return;
    const std::size_t n = s.value.size() / m;
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0, good = 0;
      for (std::size_t j = i * m; j < (i + 1) * m; ++j)
        if (s.valid[j]) sum += s.value[j], good += 1;
      s.valid[i] = 2 * good > static_cast<double>(m);
      s.value[i] = good > 0 ? sum / good : 0.0;
    }
    s.value.resize(n);
    s.valid.resize(n);
  }

  static void add_gaps(ChannelRecord& to, const std::vector<bool>& valid) {
    for (std::size_t i = 0; i < valid.size();) {
      std::size_t j = i;
      while (j < valid.size() && !valid[j]) ++j;
      if (j > i) to.gaps.push_back({static_cast<std::int64_t>(i), static_cast<std::int64_t>(j - i)});
      i = std::max(j, i + 1);
    }
  }

  void tell(const ChannelRecord& c, const Series& s, const CountsNote& counts) {
    const std::string_view name = info(c.channel).name, unit = info(c.channel).unit;
    std::int64_t lost = 0;
    for (const Gap& g : c.gaps) lost += g.count;
    std::string text = fmt::format("{}: {} samples, one count is {:.4g} {}{}", name, s.value.size(),
                                   counts.step, unit, counts.grid ? ", as in the file" : "");
    if (lost) text += fmt::format(", {} lost in {} gaps", lost, c.gaps.size());
    if (counts.clipped) text += fmt::format(", {} taken as saturated", counts.clipped);
    note(text);
    const auto [low, high] = std::minmax_element(c.raw.begin(), c.raw.end());
    if (*low == *high) note(fmt::format("{}: every value is the same: a dead channel", name));
  }

  void set_clock(Record& r) {
    const auto m = static_cast<double>(per());
    r.sample_rate = clock_.rate / m;
    const double t0 = clock_.t0 + 0.5 * (m - 1) / clock_.rate;
    const double fire = std::ceil((k_.switch_on - t0) * r.sample_rate - 1e-6);
    // a closing takes less than a second, and a recorder that is triggered by the contact may begin as late
    constexpr double beside = 1.0;  // s
    const double end = t0 + static_cast<double>(clock_.n) / clock_.rate;
    if (!(k_.switch_on >= t0 - beside && k_.switch_on <= end + beside))
      fail(table_.header_line, fmt::format("switch_on_s = {:g}: the record is from {:g} to {:g} s on its "
                                           "time column; allowed up to {:g} s "
                                           "beside it",
                                           k_.switch_on, t0, end, beside));
    r.fire_sample = static_cast<std::int64_t>(fire);
    r.fire_offset = std::max(0.0, t0 + fire / r.sample_rate - k_.switch_on);
    if (r.fire_offset * r.sample_rate < 1e-9) r.fire_offset = 0;  // rounding of the stamps
    if (m > 1) note(fmt::format("averaged by {:g} to {:.9g} Hz", m, r.sample_rate));
  }

  /// What comes behind switch-off is no part of the closing: an opening is no bounce.
  double seen_hold(const Record& r) {
    const double off = dsp::seen_switch_off(r);
    if (std::isfinite(off))
      note(fmt::format(
          "the {} ends {:.1f} ms after switch-on: evaluated up to there, as with hold_ms = {:.1f}",
          r.find(Channel::coil_voltage) ? "coil voltage" : "coil current", off * 1e3, off * 1e3));
    return off;
  }

  void set_conditions(Record& r, const std::string& today) {
    Conditions& c = r.conditions;
    c.mains_hertz = k_.mains_hertz;  // what nobody gave stays unknown
    c.supply_volts = c.ambient = c.closing_angle = std::numeric_limits<double>::quiet_NaN();
    c.specimen = "imported";
    c.hold_time = std::isnan(k_.hold_time) ? seen_hold(r) : k_.hold_time;
    if (k_.recorded > today)
      throw BadInput({fmt::format("{}: recorded = \"{}\": is a day to come; allowed up to {}",
                                  calibration_file_, k_.recorded, today)});
    out_.recorded = k_.recorded;
    out_.source = k_.source;
    if (!k_.id.empty() && !k_.valid_until.empty())
      out_.calibration =
          fmt::format("{}; {}; {}", waveform_calibration, without_semicolons(k_.id), k_.valid_until);
    out_.angle_commanded = !std::isnan(k_.closing_angle);
    if (out_.angle_commanded) c.closing_angle = k_.closing_angle;
    r.rig = "imported: " + std::filesystem::path(file_).filename().string();
    r.calibration = in_force(k_, today) ? k_.id : "";
    if (k_.id.empty())
      note("no calibration is named: the results are flagged no_calibration");
    else if (r.calibration.empty())
      note(fmt::format("calibration '{}' was valid until {}: the results are flagged no_calibration", k_.id,
                       k_.valid_until));
    if (std::isfinite(k_.mains_hertz)) out_.options.mains_hertz = k_.mains_hertz;
    out_.options.crosstalk_a = k_.of(Channel::pvdf_a).crosstalk;
    out_.options.crosstalk_b = k_.of(Channel::pvdf_b).crosstalk;
  }

  const std::string file_;
  const Calibration& k_;
  const std::string calibration_file_;
  CsvTable table_;
  std::vector<Column> columns_;
  std::vector<double> seconds_;
  UniformClock clock_;
  Imported out_;
};

/// What a waveform exported by powbench says in its first line; "" = nothing.
std::string source_by_first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line(200, '\0');
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(std::min(static_cast<std::size_t>(file.gcount()), line.find_first_of("\r\n")));
  for (const Origin o : {Origin::simulated_rig, Origin::emulated_board, Origin::board, Origin::simulation})
    if (line.starts_with(fmt::format("# {}, ", name(o)))) return line.substr(2);
  return {};
}

}  // namespace

Imported import_waveform(std::string_view text, const std::string& file, const Calibration& k,
                         const std::string& calibration_file, const std::string& today) {
  return Importer(file, k, calibration_file).run(parse_table(text, file), today);
}

Imported import_file(const std::filesystem::path& path,
                     const std::optional<std::filesystem::path>& calibration) {
  const std::string name = path.string();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw BadInput({name + ": is a directory, not a file"});
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored))
    throw BadInput(
        {name + ": is no file but a pipe or a device, and is read twice; write it to a file first"});
  const std::filesystem::path beside = calibration.value_or(calibration_path(path));
  const bool given = calibration || std::filesystem::exists(beside, ignored);
  Calibration k = given && beside != path ? read_calibration(beside) : Calibration{};
  if (k.source.empty()) k.source = source_by_first_line(path);
  return Importer(name, k, beside.string()).run(read_table(path), utc_today());
}

}  // namespace powbench::host
