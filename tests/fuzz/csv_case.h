#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <source_location>
#include <string>
#include <string_view>

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/doubt.h"
#include "dsp/events/extract.h"
#include "host/config/bad_input.h"
#include "host/export/events_json.h"
#include "host/import/waveform.h"

/// One input of the fuzzer: a text that claims to be a waveform. It is refused with a sentence, or it becomes a
/// record whose events are numbers inside the record with a stated uncertainty, or openly unknown. Ends the program
/// when that does not hold.
namespace powbench::fuzz {

inline void must(bool holds, std::source_location at = std::source_location::current()) {
  if (holds) return;
  std::fprintf(stderr, "%s:%u does not hold\n", at.file_name(), static_cast<unsigned>(at.line()));
  std::abort();
}

/// Finite with a finite, not negative uncertainty, or unknown.
inline void must_be_honest(const char* name, const Measured& m) {
  const bool honest = m.known() ? std::isfinite(m.u) && m.u >= 0 : std::isnan(m.value);
  if (!honest) std::fprintf(stderr, "%s = %g +- %g\n", name, m.value, m.u);
  must(honest);
}

inline void must_be_honest(const ContactTrain& t, double first, double last) {
  must(std::isfinite(t.noise) && t.noise >= 0 && std::isfinite(t.resolution) && t.bounce_count >= 0);
  must(t.present || t.contacts.empty());
  const auto inside = [&](const char* name, const Measured& m) {
    must_be_honest(name, m);
    if (m.known() && !(m.value >= first && m.value <= last))
      std::fprintf(stderr, "%s = %g, record %g .. %g\n", name, m.value, first, last);
    must(!m.known() || (m.value >= first && m.value <= last));
  };
  for (std::size_t i = 0; i < t.contacts.size(); ++i) {
    const Contact& c = t.contacts[i];
    inside("touch", c.touch);
    inside("release", c.release);
    must_be_honest("peak", c.peak);
    must_be_honest("impulse", c.impulse);
    must(!c.release.known() || !c.touch.known() || c.release.value >= c.touch.value);
    if (i > 0) must(t.contacts[i - 1].release.known());
  }
  inside("settled", t.settled);
  must_be_honest("settled force", t.settled_force);
  must_be_honest("bounce time", t.bounce_time);
}

inline void must_be_honest(const Events& e, const Record& r) {
  const double margin = 1e-3;
  const double first = r.samples() ? r.time(0) - margin : 0.0;
  const double last = r.samples() ? r.time(r.samples() - 1) + margin : 0.0;
  for (const ContactTrain* t : {&e.pvdf_a, &e.pvdf_b, &e.contact_voltage, &e.pole.by_force})
    must_be_honest(*t, first, last);
  must_be_honest("disagreement", e.pole.disagreement);
  must_be_honest("longest disagreement", e.pole.longest_disagreement);
  must_be_honest("seat", e.core.seat);
  must_be_honest("core settled", e.core.settled);
  must_be_honest("core bounce time", e.core.bounce_time);
  must_be_honest("impact velocity", e.core.impact_velocity);
  must_be_honest("travel", e.core.travel);
  must_be_honest("closing angle", e.coil.closing_angle);
  must_be_honest("switch on", e.coil.switch_on);
  must_be_honest("mains hertz", e.coil.mains_hertz);
  must_be_honest("supply", e.coil.supply_volts);
  must_be_honest("peak current", e.coil.peak_current);
  if (r.calibration.empty()) must((e.flags & flag_no_calibration) != 0);
}

/// True when the text was taken.
inline bool run_csv(std::string_view text) {
  static const host::Calibration calibration = host::parse_calibration(
      "[pvdf_a]\ngain_N_per_V = 10\ncorner_hertz = 0.5\ncrosstalk_percent = 2\n[laser]\ngain_mm_per_V = -1\n",
      "c");
  static const host::Calibration names = host::parse_calibration(
      "[columns]\ntime = \"TIME [s]\"\npvdf_a = \"CH1\"\nlaser = \"CH2 [mm]\"\n[pvdf_a]\ngain_N_per_V = 10\n",
      "n");
  static const host::Calibration none;
  host::Imported in;
  try {
    const bool foreign = text.substr(0, 100).find("CH1") != std::string_view::npos;
    const bool volts = text.substr(0, 100).find("[V]") != std::string_view::npos;
    in = host::import_waveform(text, "fuzz.csv",
                               foreign ? names
                               : volts ? calibration
                                       : none,
                               "fuzz.toml", "2030-01-01");
  } catch (const host::BadInput& e) {
    must(!e.errors().empty() && !e.errors().front().empty());
    return false;
  }
  must(in.record.samples() > 0 && std::isfinite(in.record.sample_rate));
  if (in.record.samples() > 20'000) return true;  // a stretched clock: right, but slow to search
  const Events e = dsp::extract_events(in.record, in.options);
  must_be_honest(e, in.record);
  must(!host::to_events_json(e, in.record).empty());
  return true;
}

}  // namespace powbench::fuzz
