#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/export/gltf.h"
#include "host/export/vtu.h"
#include "sim/solid/contactor_mesh.h"
#include "sim/solid/explicit_solid.h"

/// A closing with deforming parts for other people's eyes. An object of this is the `watch` of `sim::solid_closing`.

namespace powbench::host {

/// The bodies now: displacement [m] and velocity [m/s] at the points, von Mises stress [Pa] and part at the cells.
VtuGrid state_grid(const sim::ExplicitSolid&, const sim::ContactorMesh&);

class ClosingFilm {
 public:
  enum class Format {
    vtu,  ///< closing_0.vtu, closing_1.vtu, ... and closing.pvd with their times: motion and stress
    gltf  ///< closing.gltf: the parts' mean motion, a hundred times slower than it was
  };
  using Write = std::function<void(const std::string& name, const std::string& content)>;

  /// Files go to `write` as they are ready. In flight a state is kept every `flight_interval`, s, and as often as the
  /// closing shows one while parts deform; the state that a run stopped in is always the last one.
  ClosingFilm(Format, Write write, double flight_interval = 2e-4);

  void operator()(const sim::ExplicitSolid&, const sim::ContactorMesh&);
  void finish();  ///< what can only be written at the end

  std::size_t states() const { return times_.size(); }

 private:
  GltfBody body(int part) const;
  void forget_last();

  Format format_;
  Write write_;
  double interval_, next_ = 0;
  sim::ContactorMesh contactor_;
  std::vector<double> times_;
  std::map<int, std::vector<std::array<float, 3>>> shifts_;
  std::vector<PvdStep> steps_;
};

}  // namespace powbench::host
