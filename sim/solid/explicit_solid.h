#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/solid/added_inertia.h"
#include "sim/solid/cell_batches.h"
#include "sim/solid/rigid_part.h"
#include "sim/solid/solid_contact.h"
#include "sim/solid/solid_loads.h"

/// Solid bodies in motion by the central difference: places at whole steps, velocities between them,
///
///   v(n+1/2) = v(n-1/2) + dt M^-1 f(u_n, v(n-1/2)),   u(n+1) = u_n + dt v(n+1/2),
///
/// with lumped masses. The kinetic energy of step n is v(n-1/2) . M v(n+1/2) / 2, with which the energy of a linear
/// system is constant to round-off at any stable step. Results do not depend on the number of threads.

namespace powbench::sim {

class Team;

/// Where the energy is, J.
struct SolidEnergies {
  double kinetic = 0, strain = 0, plastic = 0, hourglass = 0;
  double contact = 0;   ///< stored in penalty springs, normal and tangential, and in springs and planes
  double friction = 0;  ///< dissipated by sliding
  double contact_damping = 0;  ///< dissipated by the damping of contacts and planes
  double damping = 0;          ///< dissipated by mass-proportional damping
  double frozen = 0;           ///< kinetic energy of deformation given up when parts were frozen
  double external = 0;         ///< work of the loads
  double start = 0;            ///< of everything stored at t = 0

  double stored() const { return kinetic + strain + hourglass + contact; }
  double lost() const { return plastic + friction + contact_damping + damping + frozen; }
  /// Stored and lost less supplied: zero in exact arithmetic.
  double residual() const { return stored() + lost() - external - start; }
};

/// The run cannot go on; carries what is needed to look at the last state.
struct SolidStop : std::runtime_error {
  SolidStop(const std::string& why, int cell_, double time_)
      : std::runtime_error(why), cell(cell_), time(time_) {}
  int cell;     ///< that turned inside out, or -1
  double time;  ///< s
};

struct SolidOptions {
  double dt = 0;  ///< s; 0: `safety` times the critical step, less as plastic cells are flattened
  double safety = 0.9;
  int workers = 1;
  bool float_forces = false;   ///< elastic bricks and hexahedra in single precision; places stay in double
  int ledger_every = 200;      ///< steps between energy balances; 0: never
  double energy_bound = 0.01;  ///< largest |residual| over the largest energy seen, else SolidStop; > 0
  /// s; > 0: cells whose own step is smaller get inertia against deformation until it is this (added_inertia.h); at
  /// most the median own step of the cells.
  double scale_masses_to = 0;
};

/// Everything a run needs to go on as if it had not stopped.
struct SolidState {
  double time = 0, dt = 0, dt_before = 0;
  long step = 0;
  std::vector<double> u, v, cells, contact, inertia, booked;
  std::map<int, RigidPart> rigid;
};

class ExplicitSolid {
 public:
  /// Throws std::invalid_argument for bad meshes, materials or options.
  ExplicitSolid(const SolidMesh&, const std::vector<SolidMaterial>&, const SolidOptions& = {});
  ~ExplicitSolid();

  // Before the first step.
  void fix(int node, bool x, bool y, bool z);
  void set_velocity(int part, const Vec3&);
  void set_node_velocity(int node, const Vec3&);
  void set_node_displacement(int node, const Vec3&);
  int add_load(const SolidLoad&);
  void add_spring(const SolidSpring&);
  /// A plane for all nodes of a part; stiffness per area of the nodes' share of the surface facing it, `factor` in
  /// units of wave modulus / cell height.
  void add_plane(int part, const Vec3& point, const Vec3& normal, double factor = 1);
  void add_plane(const SolidPlane& plane) { planes_.push_back(plane); }
  void set_contact(const ContactOptions&);
  /// All nodes of a part, with shares as their masses.
  NodeShares whole_part(int part) const;

  /// Largest stable step: 2 / (highest frequency of cells, planes and contacts that could close), s.
  double critical_step() const;

  // While running.
  void set_force(int load, const Vec3& force) { loads_[static_cast<std::size_t>(load)].force = force; }
  void step();
  void run_until(double time);  ///< last step ends at or after `time`
  void set_rigid(int part, bool rigid);
  void set_step(double dt);  ///< a new step from here; throws std::invalid_argument above the limit
  bool is_rigid(int part) const { return rigid_.count(part) > 0; }

  bool stopped() const {
    return stopped_;
  }  ///< a SolidStop has been thrown: the state is the one it speaks of
  double time() const { return time_; }
  double dt() const { return dt_; }
  double step_limit() const { return limit_; }  ///< s, critical step; 0 before the first step
  long steps() const { return steps_; }
  Vec3 displacement(int node) const { return view().displacement(node); }
  Vec3 velocity(int node) const { return view().velocity(node); }
  double plane_force() const { return plane_force_; }  ///< N, of the latest step
  const SolidContact* contact() const { return contact_.get(); }
  const CellBatches& cells() const { return cells_; }
  const AddedInertia& added_inertia() const { return inertia_; }  ///< empty unless it was asked for
  const std::vector<double>& displacements() const { return u_; }
  Vec3 mean_velocity(int part) const;
  Vec3 mean_displacement(int part) const;
  /// The latest balance; taken every `ledger_every` steps, and in the step after ask_energies().
  const SolidEnergies& energies() const { return energies_; }
  void ask_energies() { asked_ = true; }

  SolidState save() const;
  void restore(const SolidState&);

 private:
  NodeView view() const { return {&cells_.mesh().nodes, u_.data(), v_.data()}; }
  void begin();
  void compute_forces();
  void compute_loads();
  void advance_nodes(double dt, double drift);
  int part_of_node(int node) const;
  void aim_inertia(double ahead);
  void add_inertia(double dt, double drift);
  bool deforms() const;  // at least one part
  void each_worker(const std::function<void(int)>&);
  void book_work(double half_dt);
  double damping_work(double half_dt) const;
  void balance(const std::vector<double>& v_before);
  void follow_cells();
  [[noreturn]] void stop(const std::string& why, int cell);
  double damping_of(int part) const { return cells_.material(part).damping; }

  CellBatches cells_;
  SolidOptions options_;
  AddedInertia inertia_;
  std::unique_ptr<Team> team_;
  std::unique_ptr<SolidContact> contact_;
  std::vector<double> u_, v_, inverse_mass_;
  std::vector<NodeShares> whole_;  // all nodes of each part
  std::vector<SolidLoad> loads_;
  std::vector<SolidSpring> springs_;
  std::vector<SolidPlane> planes_;
  NodeForces extra_, damped_;  // of contacts, springs, planes; those of them that only dissipate
  std::map<int, RigidPart> rigid_;
  std::vector<int> found_bad_;
  double time_ = 0, dt_ = 0, dt_before_ = 0, plane_force_ = 0, load_store_ = 0;
  double booked_external_ = 0, booked_damping_ = 0, booked_contact_ = 0, booked_frozen_ = 0, largest_ = 0,
         limit_ = 0, transit_ = 0;
  long steps_ = 0;
  bool begun_ = false, asked_ = false, stopped_ = false;
  SolidEnergies energies_;
};

/// Largest stable step of a mesh without contact, s: Lanczos iteration on its small displacements. Where inertia is
/// added it must have been aimed.
double cell_critical_step(const SolidMesh&, const std::vector<SolidMaterial>&,
                          const std::vector<double>& inverse_mass, const std::vector<double>& added_stiffness,
                          const AddedInertia& = {});

}  // namespace powbench::sim
