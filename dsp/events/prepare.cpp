#include "dsp/events/prepare.h"

#include <algorithm>

#include "dsp/events/coil.h"
#include "dsp/filter/force.h"
#include "dsp/filter/sos.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

/// Filtered copy; the input itself when the band does not fit below half the rate; empty when the record is
/// too short.
Signal low_passed(const Signal& in, const FilterSpec& spec, std::size_t& memory) {
  if (in.empty() || spec.high_hertz >= 0.5 * in.rate()) return in;
  try {
    ZeroPhase out = filter_zero_phase(to_sections(spec), in);
    memory = out.memory;
    return std::move(out.signal);
  } catch (const FilterMemoryError&) {
    return {};
  }
}

Signal from_zero(Signal s) {
  const auto quiet = std::span(s.value).first(s.index_at(0.0));
  const double zero = quiet.empty() ? 0.0 : median(quiet);
  for (double& v : s.value) v -= zero;
  return s;
}

}  // namespace

Prepared prepare(const Record& record, const ExtractOptions& o) {
  check(o);
  Prepared p;
  const auto supply = supply_fit(record, o);
  const std::optional<double> hertz = supply ? std::optional(supply->hertz) : std::nullopt;
  const auto film = [&](Channel c) {
    const Signal restored = restore_force(record, c, o, hertz).signal;
    const double rate = restored.empty() ? 0.0 : restored.rate();
    return low_passed(restored, {FilterKind::low, o.display_order, 0.0, o.display_hertz, rate, true},
                      p.edge_samples);
  };
  p.pvdf_a = film(Channel::pvdf_a);
  p.pvdf_b = film(Channel::pvdf_b);
  p.laser = from_zero(to_signal(record, Channel::laser));
  p.coil_current = from_zero(to_signal(record, Channel::coil_current));
  p.coil_voltage = to_signal(record, Channel::coil_voltage);
  p.mains_voltage = to_signal(record, Channel::mains_voltage);
  p.contact_voltage = to_signal(record, Channel::contact_a);
  return p;
}

}  // namespace powbench::dsp
