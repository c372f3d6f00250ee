#include "host/cli/calibrate.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

using rigs::IioLink;
using Device = IioLink::Device;
using rigs::ChannelCalibration;

constexpr int readings = 64;
constexpr double closest_counts = 2000.0;  // of the 65536: then one count is 0.05 % of the gain

double number(const std::string& text, const std::string& what) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw BadInput({fmt::format("answer '{}' for {}: not a number", text, what)});
  return value;
}

MeanCounts read_counts(IioLink& link, Channel channel) {
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < readings; ++i) {
    const double n = number(link.read_channel(channel, "raw"), "raw");
    sum += n;
    squares += n * n;
  }
  const double mean = sum / readings;
  return {mean, std::sqrt(std::max(0.0, squares / readings - mean * mean))};
}

/// A whole number in units of 10^-digits.
std::int64_t fixed(const std::string& text, int digits, const std::string& what) {
  return std::llround(number(text, what) * std::pow(10.0, digits));
}

struct Reading {
  double applied = 0.0;
  MeanCounts counts;
};

class Desk {
 public:
  Desk(IioLink& link, const std::string& token, const Ask& ask) : link_(link), token_(token), ask_(ask) {}

  /// Nothing: the channel stays as it is.
  std::optional<Reading> point(Channel channel, const char* which) {
    const ChannelInfo& c = info(channel);
    const auto text = ask_(fmt::format(
        "{}: {} known quantity in {}, applied to this input (empty: keep as it is)", c.name, which, c.unit));
    if (!text || text->empty()) return std::nullopt;
    Reading r;
    r.applied = number(*text, std::string(c.name));
    renew();
    if (link_.has_source())
      link_.write(Device::plant, "reference",
                  fmt::format("{}:{} {}", c.name, std::llround(r.applied * 1e6), token_));
    r.counts = read_counts(link_, channel);
    return r;
  }
  std::optional<std::string> ask(const std::string& question) { return ask_(question); }
  void disconnect() {
    renew();
    if (link_.has_source()) link_.write(Device::plant, "reference", "none " + token_);
  }
  void renew() { link_.write(Device::control, "lease", token_ + " 600000 calibrate"); }

 private:
  IioLink& link_;
  const std::string& token_;
  const Ask& ask_;
};

std::string table(const ChannelInfo& c, const Reading& a, const Reading& b, const ChannelCalibration& was,
                  const ChannelCalibration& is) {
  const double shift =
      100.0 * (static_cast<double>(is.scale_pico) / static_cast<double>(was.scale_pico) - 1.0);
  return fmt::format(
      "\n[{}]\nunit = \"{}\"\napplied = [{:.9g}, {:.9g}]\ncounts = [{:.3f}, {:.3f}]\ndeviation_counts = "
      "[{:.3f}, {:.3f}]\n"
      "scale_pico = {}\nzero_counts = {}\ngain_change_percent = {:.4f}\n",
      c.name, c.unit, a.applied, b.applied, a.counts.mean, b.counts.mean, a.counts.deviation,
      b.counts.deviation, is.scale_pico, is.zero_counts, shift);
}

}  // namespace

Line line_through(double x1, const MeanCounts& n1, double x2, const MeanCounts& n2) {
  if (std::abs(n2.mean - n1.mean) < closest_counts)
    throw BadInput(
        {fmt::format("the two quantities {} and {} differ by {:.0f} counts only: at least {:.0f} are needed",
                     x1, x2, std::abs(n2.mean - n1.mean), closest_counts)});
  const double scale = (x2 - x1) / (n2.mean - n1.mean);
  if (!(scale > 0.0))
    throw BadInput({fmt::format("the counts fall from {} to {}: is the input the right way round?", x1, x2)});
  return {scale, n1.mean - x1 / scale};
}

rigs::Calibrations rows_of(IioLink& link) {
  rigs::Calibrations rows;
  for (std::size_t i = 0; i < channel_count; ++i) {
    const auto channel = static_cast<Channel>(i);
    const auto get = [&](const char* what, int digits) {
      return fixed(link.read_channel(channel, what), digits, what);
    };
    ChannelCalibration& row = rows[i];
    row.scale_pico = get("scale", 12);
    row.zero_counts = -get("offset", 0);
    row.delay_ns = get("delay_ns", 0);
    if (channel_table[i].unit != "N") continue;
    row.corner_microhertz = get("corner_frequency", 6);
    row.film_area_pico = get("film_area", 12);
    row.sensitivity_femto = get("charge_sensitivity", 15);
  }
  return rows;
}

Walk walk(IioLink& link, const std::string& token, const Ask& ask) {
  Desk desk(link, token, ask);
  Walk w{.rows = rows_of(link), .switch_delay = 0.0, .report = {}, .measured = {}};
  for (std::size_t i = 0; i < channel_count; ++i) {
    const ChannelInfo& c = channel_table[i];
    ChannelCalibration& row = w.rows[i];
    const ChannelCalibration was = row;
    if (row.scale_pico == 0) continue;
    if (c.unit == "N") {  // a film gives no steady signal: its charge is what is calibrated
      const auto text = desk.ask(
          fmt::format("{}: sensitivity of the film in pC/N, from its certificate (empty: keep {:.4g})",
                      c.name, 1e-3 * static_cast<double>(was.sensitivity_femto)));
      if (!text || text->empty()) continue;
      row.sensitivity_femto = fixed(*text, 3, std::string(c.name));
      if (row.sensitivity_femto <= 0) throw BadInput({fmt::format("{}: a sensitivity is above 0", c.name)});
      row.scale_pico =
          std::llround(static_cast<double>(was.scale_pico) * static_cast<double>(was.sensitivity_femto) /
                       static_cast<double>(row.sensitivity_femto));
      w.report += fmt::format("\n[{}]\nunit = \"N\"\nsensitivity_pC_per_N = {:.6g}\nscale_pico = {}\n",
                              c.name, 1e-3 * static_cast<double>(row.sensitivity_femto), row.scale_pico);
      w.measured[i] = true;
      continue;
    }
    const auto low = desk.point(static_cast<Channel>(i), "low");
    if (!low) continue;
    const auto high = desk.point(static_cast<Channel>(i), "high");
    if (!high) continue;
    const Line line = line_through(low->applied, low->counts, high->applied, high->counts);
    row.scale_pico = std::llround(line.si_per_count / c.si_per_iio_unit * 1e12);
    row.zero_counts = std::llround(line.zero);
    w.report += table(c, *low, *high, was, row);
    w.measured[i] = true;
  }
  desk.disconnect();
  if (const auto text = desk.ask("switch: time from the gate to the coil's voltage in us (empty: 0)");
      text && !text->empty())
    w.switch_delay = 1e-6 * number(*text, "the switch");
  return w;
}

void store(IioLink& link, const std::string& token, const Walk& w, const std::string& id, std::uint32_t date,
           std::uint32_t expires) try {
  link.write(Device::control, "lease", token + " 600000 calibrate");
  for (std::size_t i = 0; i < channel_count; ++i) {
    const ChannelCalibration& r = w.rows[i];
    link.write(Device::control, "calibration_draft",
               fmt::format("{}:{}:{}:{}:{}:{}:{} {}", channel_table[i].name, r.scale_pico, r.zero_counts,
                           r.delay_ns, r.corner_microhertz, r.film_area_pico, r.sensitivity_femto, token));
  }
  link.write(Device::control, "calibration_store",
             fmt::format("{}:{}:{}:{}:{:08x} {}", id, date, expires, std::llround(w.switch_delay * 1e9),
                         rigs::rows_crc32(w.rows), token));
  std::string state;
  for (int i = 0; i < 1000; ++i) {  // a board answers behind its 30 ms of writing
    state = link.read(Device::control, "calibration_store");
    if (!state.starts_with("writing")) break;
  }
  const std::string in_force = link.read(Device::daq, "calibration");
  if (!state.starts_with("stored") || in_force != id)
    throw rigs::RigError(
        fmt::format("the rig did not store the calibration: {}, in force is {}", state, in_force));
} catch (const rigs::Refusal& refusal) {
  throw rigs::RigError(rigs::sentence(refusal) + ": " + link.read(Device::control, "last_error"));
}

}  // namespace powbench::host
