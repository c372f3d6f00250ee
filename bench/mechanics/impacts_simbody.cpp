#include <Simbody.h>

#include <cmath>
#include <memory>

#include "bench/mechanics/impacts_peer.h"
#include "core/cpu_time.h"

namespace powbench::bench {
namespace {

using namespace SimTK;

/// F = force - k d^1.5 along the slider, d its place.
class Hertz : public Force::Custom::Implementation {
 public:
  explicit Hertz(const Bounces& b) : b_(b) {}
  void calcForce(const State& state, Vector_<SpatialVec>&, Vector_<Vec3>&, Vector& along) const override {
    const double d = state.getQ()[0];
    along[0] += b_.force - (d > 0 ? b_.stiffness * d * std::sqrt(d) : 0.0);
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }
  bool dependsOnlyOnPositions() const override { return true; }

 private:
  Bounces b_;
};

/// Writes down when the place rises through zero.
class Touches : public TriggeredEventReporter {
 public:
  explicit Touches(std::vector<double>& times) : TriggeredEventReporter(Stage::Position), times_(times) {
    getTriggerInfo().setTriggerOnFallingSignTransition(false);
  }
  Real getValue(const State& state) const override { return state.getQ()[0]; }
  void handleEvent(const State& state) const override { times_.push_back(state.getTime()); }

 private:
  std::vector<double>& times_;
};

std::unique_ptr<Integrator> integrator_of(int method, const MultibodySystem& system) {
  if (method == 0) return std::make_unique<RungeKuttaMersonIntegrator>(system);
  return std::make_unique<CPodesIntegrator>(system, method == 1 ? CPodes::Adams : CPodes::BDF);
}
constexpr const char* method_names[] = {"Simbody, Runge-Kutta-Merson", "Simbody, CPodes Adams",
                                        "Simbody, CPodes BDF"};

PeerRow bounce(const Bounces& b, int method, double accuracy, double last_touch) {
  MultibodySystem system;
  SimbodyMatterSubsystem matter(system);
  GeneralForceSubsystem forces(system);
  const Body::Rigid body(MassProperties(b.mass, Vec3(0), Inertia(1e-7)));
  MobilizedBody::Slider mass(matter.Ground(), Transform(), body, Transform());
  Force::Custom(forces, new Hertz(b));
  std::vector<double> times;
  system.addEventReporter(new Touches(times));
  system.realizeTopology();
  State state = system.getDefaultState();
  state.updQ()[0] = -b.height;
  auto integrator = integrator_of(method, system);
  integrator->setAccuracy(accuracy);
  TimeStepper stepper(system, *integrator);
  stepper.initialize(state);
  const double start = process_cpu_seconds();
  const double end = last_touch * 1.01;
  stepper.stepTo(end);
  const double cpu = process_cpu_seconds() - start;
  const auto count = static_cast<std::size_t>(b.touches);
  const double error = times.size() < count ? std::nan("") : std::fabs(times[count - 1] - last_touch);
  return {method_names[method], accuracy, error, cpu};
}

/// A ball that cannot turn on a half-space: Hunt-Crossley with friction that is regular below the transition speed.
PeerRow dry_stop(const DryStop& d, int method, double transition, double accuracy) {
  MultibodySystem system;
  SimbodyMatterSubsystem matter(system);
  GeneralForceSubsystem forces(system);
  GeneralContactSubsystem contacts(system);
  constexpr double gravity = 10, friction = 0.1, radius = 0.1, stiffness = 1e6;  // 0.1 of 10 N
  Force::UniformGravity(forces, matter, Vec3(0, -gravity, 0));
  const Body::Rigid body(MassProperties(1, Vec3(0), Inertia(0.004)));
  MobilizedBody::Translation ball(matter.Ground(), Transform(), body, Transform());
  Force::MobilityLinearSpring(forces, ball, MobilizerQIndex(0), 1, 0);
  const ContactSetIndex set = contacts.createContactSet();
  contacts.addBody(set, ball, ContactGeometry::Sphere(radius), Transform());
  contacts.addBody(set, matter.Ground(), ContactGeometry::HalfSpace(),
                   Transform(Rotation(-0.5 * Pi, ZAxis), Vec3(0)));  // fills y < 0
  HuntCrossleyForce law(forces, contacts, set);
  for (const int surface : {0, 1})
    law.setBodyParameters(ContactSurfaceIndex(surface), stiffness, 1, friction, friction, 0);
  law.setTransitionVelocity(transition);
  system.realizeTopology();
  State state = system.getDefaultState();
  // F = 4/3 sqrt(R) k d^1.5, k of both surfaces in series: at rest under the weight
  const double depth = std::pow(gravity / (4.0 / 3 * std::sqrt(radius) * stiffness / 2), 2.0 / 3);
  ball.setQ(state, Vec3(d.start, radius - depth, 0));
  auto integrator = integrator_of(method, system);
  integrator->setAccuracy(accuracy);
  TimeStepper stepper(system, *integrator);
  stepper.initialize(state);
  const double start = process_cpu_seconds();
  stepper.stepTo(d.end);
  const double cpu = process_cpu_seconds() - start;
  return {method_names[method], transition, std::fabs(stepper.getState().getQ()[0] - d.place), cpu};
}

}  // namespace

bool simbody_is_here() {
  return true;
}

std::vector<PeerRow> simbody_bounces(const Bounces& b, double last_touch) {
  std::vector<PeerRow> rows;
  for (int method = 0; method < 3; ++method)
    for (const double accuracy : {1e-4, 1e-6, 1e-8, 1e-10})
      rows.push_back(bounce(b, method, accuracy, last_touch));
  return rows;
}

std::vector<PeerRow> simbody_dry_stop(const DryStop& d) {
  std::vector<PeerRow> rows;
  for (const double transition : {1e-2, 1e-3}) rows.push_back(dry_stop(d, 0, transition, 1e-6));
  for (const double transition : {1e-2, 1e-3, 1e-4}) rows.push_back(dry_stop(d, 2, transition, 1e-6));
  return rows;
}

}  // namespace powbench::bench
