#include "sim/solid/explicit_solid.h"

#include <algorithm>

#include "sim/solid/flush_denormals.h"
#include "sim/team.h"

namespace powbench::sim {
namespace {

NodeShares shares_by_mass(const std::vector<double>& masses, int begin, int end) {
  NodeShares all;
  double mass = 0;
  for (int n = begin; n < end; ++n) {
    all.nodes.push_back(n);
    all.shares.push_back(masses[static_cast<std::size_t>(n)]);
    mass += all.shares.back();
  }
  for (double& s : all.shares) s /= mass;
  return all;
}

}  // namespace

ExplicitSolid::ExplicitSolid(const SolidMesh& mesh, const std::vector<SolidMaterial>& materials,
                             const SolidOptions& options)
    : cells_(mesh, materials, options.float_forces),
      options_(options),
      team_(options.workers > 1 ? std::make_unique<Team>(options.workers) : nullptr),
      u_(4 * mesh.nodes.size(), 0.0),
      v_(4 * mesh.nodes.size(), 0.0),
      inverse_mass_(4 * mesh.nodes.size(), 0.0),
      extra_(mesh.nodes.size()),
      damped_(mesh.nodes.size()),
      found_bad_(static_cast<std::size_t>(cells_.count()), -1) {
  if (!(options.safety > 0 && options.safety <= 1))
    throw std::invalid_argument("safety = " + std::to_string(options.safety) + ", must be in (0, 1]");
  if (!(options.energy_bound > 0))
    throw std::invalid_argument("energy_bound = " + std::to_string(options.energy_bound) + ", must be > 0");
  if (options.scale_masses_to != 0) inertia_ = AddedInertia(mesh, materials, options.scale_masses_to);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) inverse_mass_[4 * n + i] = 1 / cells_.masses()[n];
  for (int p = 0; p < static_cast<int>(mesh.parts.size()); ++p)
    whole_.push_back(shares_by_mass(cells_.masses(), cells_.nodes_begin(p), cells_.nodes_end(p)));
}

ExplicitSolid::~ExplicitSolid() = default;

void ExplicitSolid::fix(int node, bool x, bool y, bool z) {
  double* p = inverse_mass_.data() + 4 * static_cast<std::size_t>(node);
  if (x) p[0] = 0;
  if (y) p[1] = 0;
  if (z) p[2] = 0;
}

void ExplicitSolid::set_node_velocity(int node, const Vec3& v) {
  for (int i = 0; i < 3; ++i) v_[4 * static_cast<std::size_t>(node) + static_cast<std::size_t>(i)] = v[i];
}

void ExplicitSolid::set_node_displacement(int node, const Vec3& u) {
  for (int i = 0; i < 3; ++i) u_[4 * static_cast<std::size_t>(node) + static_cast<std::size_t>(i)] = u[i];
}

void ExplicitSolid::set_velocity(int part, const Vec3& v) {
  for (int n = cells_.nodes_begin(part); n < cells_.nodes_end(part); ++n) set_node_velocity(n, v);
}

int ExplicitSolid::add_load(const SolidLoad& load) {
  loads_.push_back(load);
  return static_cast<int>(loads_.size()) - 1;
}

void ExplicitSolid::add_spring(const SolidSpring& spring) {
  springs_.push_back(spring);
}

void ExplicitSolid::add_plane(int part, const Vec3& point, const Vec3& normal, double factor) {
  const SolidSurface s = surface_of(cells_.mesh(), part, cells_.material(part));
  SolidPlane plane{point, unit(normal), {}, {}, {}};
  std::map<int, double> stiffness;
  for (const Facet& f : s.facets) {
    std::array<Vec3, 4> p{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(f.corners()); ++k)
      p[k] = cells_.mesh().nodes[static_cast<std::size_t>(f.nodes[k])];
    const Vec3 area = 0.5 * facet_normal(p, f.corners());
    const double towards = -dot(area, plane.normal);
    if (towards <= 0.05 * norm(area)) continue;
    for (std::size_t k = 0; k < static_cast<std::size_t>(f.corners()); ++k)
      stiffness[f.nodes[k]] += factor * f.stiffness * towards / f.corners();
  }
  for (const auto& [node, k] : stiffness) {
    plane.nodes.push_back(node);
    plane.stiffness.push_back(k);
  }
  planes_.push_back(plane);
}

void ExplicitSolid::set_contact(const ContactOptions& options) {
  contact_ = std::make_unique<SolidContact>(cells_, inverse_mass_, options);
}

NodeShares ExplicitSolid::whole_part(int part) const {
  return whole_.at(static_cast<std::size_t>(part));
}

Vec3 ExplicitSolid::mean_velocity(int part) const {
  return mean(whole_.at(static_cast<std::size_t>(part)), v_.data());
}

Vec3 ExplicitSolid::mean_displacement(int part) const {
  return mean(whole_.at(static_cast<std::size_t>(part)), u_.data());
}

void ExplicitSolid::begin() {
  limit_ = critical_step();
  dt_ = options_.dt > 0 ? options_.dt : options_.safety * limit_;
  if (dt_ > limit_)
    throw std::invalid_argument("dt = " + std::to_string(dt_ * 1e9) + " ns, must be in (0, " +
                                std::to_string(limit_ * 1e9) +
                                "] ns, the critical step of this mesh and its contacts");
  dt_before_ = dt_;
  begun_ = true;
  if (!inertia_.empty()) {
    aim_inertia(0);
    inertia_.start(v_.data());
  }
  // half a step back with the forces at t = 0, so that the first velocity belongs half a step before it
  dt_before_ = 0;
  compute_forces();
  compute_loads();
  advance_nodes(-0.5 * dt_, 0);
  extra_.clear();
  damped_.clear();
  dt_before_ = dt_;
}

void ExplicitSolid::set_step(double dt) {
  if (!begun_) throw std::invalid_argument("set_step: before the first step the options say the step");
  if (!(dt > 0)) throw std::invalid_argument("dt = " + std::to_string(dt) + " s, must be > 0");
  if (deforms() && dt > limit_)
    throw std::invalid_argument("dt = " + std::to_string(dt * 1e9) + " ns, must be in (0, " +
                                std::to_string(limit_ * 1e9) + "] ns while a part deforms");
  dt_ = dt;
}

bool ExplicitSolid::deforms() const {
  return rigid_.size() < cells_.mesh().parts.size();
}

void ExplicitSolid::each_worker(const std::function<void(int)>& job) {
  if (!deforms()) return;  // no cell to compute: waking threads would cost more than the step
  if (team_)
    team_->run(job);
  else
    job(0);
}

void ExplicitSolid::compute_forces() {
  const int workers = options_.workers > 1 ? options_.workers : 1, count = cells_.count();
  each_worker([&](int w) {
    const int from = count * w / workers, to = count * (w + 1) / workers;
    for (int b = from; b < to; ++b)
      if (rigid_.count(cells_.part_of(b)) == 0)
        found_bad_[static_cast<std::size_t>(b)] = cells_.compute(b, u_.data(), v_.data(), dt_before_);
  });
  for (const int cell : found_bad_)
    if (cell >= 0)
      stop("cell " + std::to_string(cell) + " has turned inside out at t = " + std::to_string(time_ * 1e6) +
               " us",
           cell);
}

void ExplicitSolid::compute_loads() {
  load_store_ = apply_loads({}, springs_, planes_, view(), extra_, damped_, &plane_force_);
  if (contact_) contact_->apply(view(), dt_before_, extra_, damped_);
}

void ExplicitSolid::advance_nodes(double dt, double drift) {
  for (const auto& load : loads_)
    for (std::size_t k = 0; k < load.on.nodes.size(); ++k)
      extra_.add(load.on.nodes[k], load.on.shares[k] * load.force);
  const auto parts = static_cast<int>(cells_.mesh().parts.size());
  for (const int n :
       extra_.touched()) {  // a kick before the step, made larger by what damping will take off it
    const auto place = 4 * static_cast<std::size_t>(n);
    const int part = part_of_node(n);
    if (rigid_.count(part) > 0) continue;
    const double scale = dt / (1 - 0.5 * damping_of(part) * dt);
    for (std::size_t i = 0; i < 3; ++i)
      v_[place + i] += scale * inverse_mass_[place + i] * extra_[n][static_cast<int>(i)];
  }
  const int workers = options_.workers > 1 ? options_.workers : 1;
  const CellKernel& kernel = cells_.kernel();
  each_worker([&](int w) {
    const FlushDenormals in_here;
    for (int part = 0; part < parts; ++part) {
      if (rigid_.count(part) > 0) continue;
      const int begin = cells_.nodes_begin(part), size = cells_.nodes_end(part) - begin;
      const auto run = [&](auto range, const auto* f, auto advance) {
        range.first = begin + static_cast<int>(static_cast<long>(size) * w / workers);
        range.last = begin + static_cast<int>(static_cast<long>(size) * (w + 1) / workers);
        range.slot_begin = cells_.slot_begin();
        range.slots = cells_.slots();
        range.f = f;
        range.inverse_mass = inverse_mass_.data();
        range.v = v_.data();
        range.u = u_.data();
        range.dt = dt;
        range.drift = drift;
        range.damping = 0.5 * damping_of(part) * dt;
        advance(range);
      };
      if (cells_.in_float())
        run(NodeRange<float>{}, cells_.float_forces(), kernel.advance_float);
      else
        run(NodeRange<double>{}, cells_.forces(), kernel.advance);
    }
  });
  for (auto& [part, body] : rigid_)
    sim::advance(body, extra_, cells_.mesh().nodes, dt, drift, u_.data(), v_.data());
  if (!inertia_.empty()) add_inertia(dt, drift);
}

int ExplicitSolid::part_of_node(int node) const {
  int part = 0;
  while (node >= cells_.nodes_end(part)) ++part;
  return part;
}

/// Where the nodes are when they have moved on for a while, s, as fast as now.
void ExplicitSolid::aim_inertia(double ahead) {
  inertia_.aim(cells_.mesh().nodes, u_.data(), v_.data(), ahead,
               [&](int part) { return rigid_.count(part) > 0; });
}

/// After nodes have moved by their masses alone.
void ExplicitSolid::add_inertia(double dt, double drift) {
  aim_inertia(0.5 * (drift > 0 ? drift : 2 * dt) - drift);
  std::vector<double> diagonal;
  for (const int n : inertia_.nodes()) {
    const int part = part_of_node(n);
    for (std::size_t i = 0; i < 3; ++i) {
      const double inverse = inverse_mass_[4 * static_cast<std::size_t>(n) + i];
      const bool moves = inverse > 0 && rigid_.count(part) == 0;
      diagonal.push_back(moves ? (1 + 0.5 * damping_of(part) * dt) / inverse : 0);
    }
  }
  inertia_.correct(diagonal, drift, u_.data(), v_.data());
}

/// The critical step goes with the time a wave needs through the flattest plastic cell.
void ExplicitSolid::follow_cells() {
  constexpr long every = 20;
  if (options_.dt > 0 || steps_ % every != 0) return;
  const double now = cells_.plastic_transit(u_.data(), inertia_.gains());
  if (now <= 0) return;
  if (transit_ == 0) transit_ = now;
  dt_ = std::min(dt_, options_.safety * limit_ * std::min(1.0, now / transit_));
}

void ExplicitSolid::step() {
  if (!begun_) begin();
  follow_cells();
  compute_forces();
  compute_loads();
  book_work(0.5 * dt_before_);
  const bool due = asked_ || (options_.ledger_every > 0 && steps_ % options_.ledger_every == 0);
  const double mean_dt = 0.5 * (dt_ + dt_before_);
  std::vector<double> before;
  bool damped = false;
  for (std::size_t p = 0; p < cells_.mesh().parts.size(); ++p)
    damped = damped || damping_of(static_cast<int>(p)) > 0;
  if (due || damped) before = v_;
  std::map<int, RigidPart> turning;
  if (due) turning = rigid_;
  advance_nodes(mean_dt, dt_);
  book_work(0.5 * dt_);
  if (damped)
    for (int p = 0; p < static_cast<int>(cells_.mesh().parts.size()); ++p)
      for (int n = cells_.nodes_begin(p); damping_of(p) > 0 && n < cells_.nodes_end(p); ++n)
        for (std::size_t i = 0; i < 3; ++i) {
          const auto at = 4 * static_cast<std::size_t>(n) + i;
          const double middle = 0.5 * (before[at] + v_[at]);
          if (inverse_mass_[at] > 0)
            booked_damping_ += damping_of(p) * mean_dt / inverse_mass_[at] * middle * middle;
        }
  if (due) {
    energies_.kinetic = 0;
    for (const auto& [part, body] : rigid_) energies_.kinetic += body.kinetic_between(turning.at(part));
    if (!inertia_.empty()) energies_.kinetic += inertia_.kinetic(before.data(), v_.data());
    balance(before);
  }
  extra_.clear();
  damped_.clear();
  dt_before_ = dt_;
  time_ += dt_;
  ++steps_;
}

void ExplicitSolid::run_until(double time) {
  while (time_ < time) step();
}

void ExplicitSolid::stop(const std::string& why, int cell) {
  stopped_ = true;
  throw SolidStop(why, cell, time_);
}

void ExplicitSolid::set_rigid(int part, bool rigid) {
  if (rigid == is_rigid(part)) return;
  if (!rigid) {
    rigid_.erase(part);
    return;
  }
  const int first = cells_.nodes_begin(part), last = cells_.nodes_end(part);
  bool held = false;
  double before = 0;
  for (int n = first; n < last; ++n) {
    held = held || inverse_mass_[4 * static_cast<std::size_t>(n)] == 0;
    before += 0.5 * cells_.masses()[static_cast<std::size_t>(n)] * dot(velocity(n), velocity(n));
  }
  RigidPart body = freeze(first, last, held, view(), cells_.masses());
  if (!inertia_.empty()) {
    before += inertia_.kinetic_of(first, last, v_.data());
    inertia_.rest(first, last);
  }
  booked_frozen_ += before - body.kinetic();
  rigid_.emplace(part, std::move(body));
}

}  // namespace powbench::sim
