#include <catch2/catch.hpp>

#include "bench/dsp_methods.h"
#include "bench/dsp_metrics.h"
#include "bench/dsp_synth.h"

/// The bars the extraction must hold on synthetic truth (1 MS/s unless said, 40 dB, fixed seeds).

using namespace powbench;
using namespace powbench::bench;

namespace {

Score full_chain(ForceCase c, PulseForm form, double snr, int seeds, double rate = 1e6) {
  SynthSettings s;
  s.force_case = c;
  s.form = form;
  s.snr_db = snr;
  s.rate = rate;
  Scorer scorer;
  for (int k = 0; k < seeds; ++k) {
    const SynthRecord r = synthesise(s, static_cast<std::uint64_t>(k));
    scorer.add(r.contacts, methods().back().contacts(r.record));
  }
  return scorer.score();
}

void check_clean(const Score& s) {
  CHECK(s.recall == 1.0);
  CHECK(s.precision == 1.0);
  CHECK(s.exact == 1.0);
  CHECK(s.touch_rmse < 4e-6);
  CHECK(s.release_rmse < 4e-6);
  CHECK(std::abs(s.duration_bias) < 3e-6);
  CHECK(s.z_std > 0.8);
  CHECK(s.z_std < 1.25);
}

}  // namespace

TEST_CASE("score: clean and hum, fixed subset") {
  check_clean(full_chain(ForceCase::clean, PulseForm::half_sine, 40, 12));
  check_clean(full_chain(ForceCase::hum, PulseForm::half_sine, 40, 12));
}

TEST_CASE("score: ringing in the band, fixed subset") {
  const Score s = full_chain(ForceCase::ring_in_band, PulseForm::half_sine, 40, 40);
  CHECK(s.recall == 1.0);
  CHECK(s.precision >= 0.98);
  CHECK(s.exact >= 0.95);
  CHECK(s.touch_rmse < 10e-6);
}

TEST_CASE("score: all forms and disturbances on 40 seeds", "[.slow]") {
  for (const PulseForm form : {PulseForm::half_sine, PulseForm::hertz, PulseForm::asymmetric})
    check_clean(full_chain(ForceCase::clean, form, 40, 40));
  for (const ForceCase c : {ForceCase::hum, ForceCase::short_pulses, ForceCase::droop, ForceCase::clip})
    check_clean(full_chain(c, PulseForm::half_sine, 40, 40));
  for (const ForceCase c : {ForceCase::ring_in_band, ForceCase::ring_overlap}) {
    const Score s = full_chain(c, PulseForm::half_sine, 40, 40);
    CHECK(s.precision >= 0.98);
    CHECK(s.exact >= 0.95);
    CHECK(s.touch_rmse < 10e-6);
  }
  const Score loud = full_chain(ForceCase::clean, PulseForm::half_sine, 20, 40);
  CHECK(loud.exact >= 0.97);
  CHECK(loud.touch_rmse < 25e-6);
}

TEST_CASE("score: the textbook threshold is as bad as measured elsewhere, so the score can tell") {
  Scorer scorer;
  for (std::uint64_t k = 0; k < 12; ++k) {
    const SynthRecord r = synthesise({}, k);
    scorer.add(r.contacts, methods().front().contacts(r.record));
  }
  const Score s = scorer.score();
  CHECK(s.recall < 0.8);
  CHECK(s.touch_rmse > 100e-6);
}
