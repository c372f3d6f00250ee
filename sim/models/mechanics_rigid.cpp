#include <atomic>
#include <cstdint>

#include "sim/models/counting_potential.h"
#include "sim/models/mechanics_kinds.h"
#include "sim/models/rigid_closing.h"

namespace powbench::sim {
namespace {

using Run = std::function<Trajectory(const Case&, double duration, double tolerance, double sample_dt)>;

/// A rigid closing whose energies are looked at: the first and one in forty after it run once more with the ledger,
/// which throws std::runtime_error where it does not balance within a hundred tolerances. That run is not used
/// otherwise, so an audit changes no bit. (The plant carries its ledger in every run, `modal` and `deformable` too.)
struct Audited {
  Run run, with_ledger;
  std::shared_ptr<std::atomic<std::uint64_t>> calls = std::make_shared<std::atomic<std::uint64_t>>(0);

  Trajectory operator()(const Case& c, double duration, double tolerance, double sample_dt) const {
    constexpr std::uint64_t every = 40;
    Trajectory result = run(c, duration, tolerance, sample_dt);
    if (calls->fetch_add(1) % every == 0)
      result.energy_residual = with_ledger(c, duration, tolerance, 0).energy_residual;
    return result;
  }
};

Run with_circuit(bool ledger) {
  return [ledger](const Case& c, double duration, double tolerance, double sample_dt) {
    return simulate_rigid(c.specimen, c.conditions, duration, sample_dt, tolerance, ledger, c.bench);
  };
}

Run with_fields(const FieldRung& fields, bool ledger) {
  return [fields, ledger](const Case& c, double duration, double tolerance, double sample_dt) {
    const CountingPotential potential(fields.potential(c));
    return potential.told(simulate_rigid_with(potential, c.specimen, c.conditions, duration, sample_dt,
                                              tolerance, ledger, c.bench));
  };
}

Rung rigid_rung(const FieldRung& fields) {
  if (fields.name == circuit_field().name)
    return {fields.name, "rigid", "lumped circuit, rigid parts with two ends each",
            Audited{with_circuit(false), with_circuit(true)}};
  Rung r{fields.name, "rigid", fields.meaning + ", rigid parts", nullptr};
  // a field solved anew costs seconds: once is enough
  r.run = fields.costly ? with_fields(fields, false)
                        : Run(Audited{with_fields(fields, false), with_fields(fields, true)});
  r.costly = fields.costly;
  if (fields.costly) r.settings = {1e-3, 1e-4, 1e-5};
  return r;
}

}  // namespace

Mechanics rigid_mechanics() {
  return {.name = "rigid",
          .detail = 0,
          .any_fields = true,
          .costly = false,
          .unknown = [](const Case&) { return std::string(); },
          .rung = rigid_rung};
}

}  // namespace powbench::sim
