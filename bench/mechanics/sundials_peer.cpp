#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>

#include "bench/mechanics/rigid_runs.h"

namespace powbench::bench {
namespace {

using Contactor = sim::RigidContactor<double>;
constexpr int room = sim::EventSolver<Contactor>::capacity;
constexpr long most_steps = 100000000;

/// What the callbacks of SUNDIALS get. The contactor follows the sign of each depth, since these integrators know no
/// modes; its lanes read and write past the states, so they work on copies with room.
struct Peer {
  explicit Peer(const sim::RigidParts& parts) : contactor(parts) {
    contactor.equilibrium(y);
    contactor.follow_depths(true);
    states = contactor.size();
    for (int c = 0; c < sim::rigid_contacts; ++c)
      if (contactor.uses(contactor.number_of(c))) contacts.push_back(c);
  }
  Contactor contactor;
  alignas(64) double y[room] = {};
  alignas(64) double dy[room] = {};
  int states = 0;
  long evaluations = 0;
  std::vector<int> contacts;  ///< by lane
  std::vector<sim::RigidEvent> events;

  void take_roots(double t, const std::vector<int>& found) {
    for (std::size_t i = 0; i < contacts.size(); ++i)
      if (found[i] != 0) events.push_back({contactor.number_of(contacts[i]), found[i] > 0, t, 0});
  }
};

int rate(realtype t, N_Vector y, N_Vector ydot, void* user) {
  auto& p = *static_cast<Peer*>(user);
  std::copy_n(N_VGetArrayPointer(y), p.states, p.y);
  p.contactor.derivative(t, p.y, p.dy);
  std::copy_n(p.dy, p.states, N_VGetArrayPointer(ydot));
  ++p.evaluations;
  return 0;
}

int roots(realtype, N_Vector y, realtype* g, void* user) {
  auto& p = *static_cast<Peer*>(user);
  std::copy_n(N_VGetArrayPointer(y), p.states, p.y);
  sim::Lanes<double> d[sim::rigid_groups];
  p.contactor.depths(p.y, d);
  for (std::size_t i = 0; i < p.contacts.size(); ++i)
    g[i] = d[p.contacts[i] / sim::rigid_lanes][p.contacts[i] % sim::rigid_lanes];
  return 0;
}

/// Vectors of one run.
struct Vectors {
  Vectors(Peer& p, double tolerance) {
    SUNContext_Create(nullptr, &context);
    y = N_VNew_Serial(p.states, context);
    scale = N_VNew_Serial(p.states, context);
    std::copy_n(p.y, p.states, N_VGetArrayPointer(y));
    for (int i = 0; i < p.states; ++i) N_VGetArrayPointer(scale)[i] = tolerance * p.contactor.scale(i);
  }
  Vectors(const Vectors&) = delete;
  Vectors& operator=(const Vectors&) = delete;
  ~Vectors() {
    N_VDestroy(y);
    N_VDestroy(scale);
    SUNContext_Free(&context);
  }
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  N_Vector scale = nullptr;
};

ClosingRun cvode(Peer& p, double tolerance, bool adams, bool restart) {
  ClosingRun r;
  Vectors v(p, tolerance);
  const double begin = cpu_ms();
  void* c = CVodeCreate(adams ? CV_ADAMS : CV_BDF, v.context);
  CVodeInit(c, rate, 0, v.y);
  CVodeSVtolerances(c, 1e-14, v.scale);
  CVodeSetUserData(c, &p);
  CVodeSetMaxNumSteps(c, most_steps);
  CVodeRootInit(c, static_cast<int>(p.contacts.size()), roots);
  CVodeSetMaxStep(c, 1e-3);
  CVodeSetStopTime(c, closing_end);
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  SUNNonlinearSolver nonlinear = nullptr;
  if (adams) {
    nonlinear = SUNNonlinSol_FixedPoint(v.y, 0, v.context);
    CVodeSetNonlinearSolver(c, nonlinear);
  } else {
    matrix = SUNDenseMatrix(p.states, p.states, v.context);
    linear = SUNLinSol_Dense(v.y, matrix, v.context);
    CVodeSetLinearSolver(c, linear, matrix);
  }
  double t = 0;
  long steps = 0;
  std::vector<int> found(p.contacts.size());
  while (t < closing_end * (1 - 1e-14)) {
    const int flag = CVode(c, closing_end, v.y, &t, CV_NORMAL);
    if (flag != CV_ROOT_RETURN) {
      r.finished = flag >= 0;
      break;
    }
    CVodeGetRootInfo(c, found.data());
    p.take_roots(t, found);
    if (!restart) continue;
    CVodeGetNumSteps(c, &steps);
    r.steps += steps;
    CVodeReInit(c, t, v.y);
    CVodeSetStopTime(c, closing_end);
  }
  CVodeGetNumSteps(c, &steps);
  r.steps += steps;
  CVodeFree(&c);
  r.cpu_ms = cpu_ms() - begin;
  if (matrix != nullptr) SUNMatDestroy(matrix);
  if (linear != nullptr) SUNLinSolFree(linear);
  if (nonlinear != nullptr) SUNNonlinSolFree(nonlinear);
  return r;
}

ClosingRun arkode(Peer& p, double tolerance, ARKODE_ERKTableID table) {
  ClosingRun r;
  Vectors v(p, tolerance);
  const double begin = cpu_ms();
  void* c = ERKStepCreate(rate, 0, v.y, v.context);
  ERKStepSVtolerances(c, 1e-14, v.scale);
  ERKStepSetUserData(c, &p);
  ERKStepSetMaxNumSteps(c, most_steps);
  ERKStepSetTableNum(c, table);
  ERKStepRootInit(c, static_cast<int>(p.contacts.size()), roots);
  ERKStepSetMaxStep(c, 1e-3);
  ERKStepSetStopTime(c, closing_end);
  double t = 0;
  std::vector<int> found(p.contacts.size());
  while (t < closing_end * (1 - 1e-14)) {
    const int flag = ERKStepEvolve(c, closing_end, v.y, &t, ARK_NORMAL);
    if (flag != ARK_ROOT_RETURN) {
      r.finished = flag >= 0;
      break;
    }
    ERKStepGetRootInfo(c, found.data());
    p.take_roots(t, found);
  }
  ERKStepGetNumSteps(c, &r.steps);
  ERKStepFree(&c);
  r.cpu_ms = cpu_ms() - begin;
  return r;
}

ClosingRun once(const std::string& method, const sim::RigidParts& parts, double tolerance) {
  Peer p(parts);
  ClosingRun r;
  if (method == "CVODE Adams") r = cvode(p, tolerance, true, false);
  if (method == "CVODE Adams, restarted") r = cvode(p, tolerance, true, true);
  if (method == "CVODE BDF") r = cvode(p, tolerance, false, false);
  if (method == "CVODE BDF, restarted") r = cvode(p, tolerance, false, true);
  if (method == "ARKODE Dormand-Prince 5") r = arkode(p, tolerance, ARKODE_DORMAND_PRINCE_7_4_5);
  if (method == "ARKODE Fehlberg 8") r = arkode(p, tolerance, ARKODE_FEHLBERG_13_7_8);
  r.method = method;
  r.tolerance = tolerance;
  r.evaluations = p.evaluations;
  r.events = p.events;
  std::stable_sort(r.events.begin(), r.events.end(),
                   [](const sim::RigidEvent& a, const sim::RigidEvent& b) { return a.time < b.time; });
  return r;
}

}  // namespace

bool have_sundials() {
  return true;
}
std::vector<std::string> sundials_methods() {
  return {"CVODE Adams",          "CVODE Adams, restarted",  "CVODE BDF",
          "CVODE BDF, restarted", "ARKODE Dormand-Prince 5", "ARKODE Fehlberg 8"};
}
ClosingRun sundials_run(const std::string& method, const sim::RigidParts& parts, double tolerance,
                        int repeats) {
  ClosingRun best = once(method, parts, tolerance);
  for (int i = 1; i < repeats; ++i)
    best.cpu_ms = std::min(best.cpu_ms, once(method, parts, tolerance).cpu_ms);
  return best;
}

}  // namespace powbench::bench
