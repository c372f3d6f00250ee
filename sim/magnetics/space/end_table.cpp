#include "sim/magnetics/space/end_table.h"

#include <algorithm>
#include <array>
#include <vector>

namespace powbench::sim {
namespace {

/// The four cubics of Hermite at t in 0 .. 1 over a cell of this width, and their slopes: value at the lower end, slope
/// there, value at the upper end, slope there.
struct Cubics {
  std::array<double, 4> value, slope;
  Cubics(double t, double width)
      : value{1 - t * t * (3 - 2 * t), width * t * (1 - t) * (1 - t), t * t * (3 - 2 * t),
              width * t * t * (t - 1)},
        slope{-6 * t * (1 - t) / width, (1 - t) * (1 - 3 * t), 6 * t * (1 - t) / width, t * (3 * t - 2)} {}
};

std::size_t cell_of(const std::vector<double>& nodes, double x) {
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
  return static_cast<std::size_t>(above - nodes.begin()) - 1;
}

/// Cubics of an axis at x, and the node below; of a missing axis one, constant.
struct Along {
  std::size_t node = 0, count = 4;
  Cubics c{0, 1};

  Along(const std::vector<double>& nodes, double x) {
    if (nodes.empty()) {
      count = 1;
      c.value[0] = 1;
      return;
    }
    node = cell_of(nodes, x);
    const double width = nodes[node + 1] - nodes[node];
    c = Cubics((x - nodes[node]) / width, width);
  }
};

/// What a table keeps at a node, at any point inside: W and its derivatives. Not TablePotential: a difference of
/// energies is not convex.
std::vector<double> inside(const PotentialTable& t, double psi, double ring, double gap) {
  const Along a(t.psi, psi), b(t.ring, ring), c(t.gap, gap);
  const std::size_t rings = std::max<std::size_t>(1, t.ring.size());
  const std::size_t by_ring = 2, by_gap = t.values() / 2;  // places of the derivatives
  std::vector<double> out(t.values(), 0);
  for (std::size_t k = 0; k < c.count; ++k)
    for (std::size_t j = 0; j < b.count; ++j)
      for (std::size_t i = 0; i < a.count; ++i) {
        const std::size_t node = a.node + i / 2 + t.psi.size() * (b.node + j / 2 + rings * (c.node + k / 2));
        const double f = t.nodes[node * t.values() + i % 2 + by_ring * (j % 2) + by_gap * (k % 2)];
        for (std::size_t d = 0; d < out.size(); ++d)
          out[d] += f * (d % 2 ? a.c.slope : a.c.value)[i] *
                    (b.count > 1 && d & by_ring ? b.c.slope : b.c.value)[j] *
                    (d >= by_gap ? c.c.slope : c.c.value)[k];
      }
  return out;
}

}  // namespace

PotentialTable build_table_with_ends(const MagnetDesign& given, const TableOptions& options,
                                     const EndTableOptions& ends, Team& team, TableReport* report) {
  TableOptions fine = options;
  fine.ring = with_ring(given, options);
  MagnetDesign design = given;
  design.end_leakage = design.ring_leakage = 0;
  constexpr double little = 0.05;  // A: unsaturated
  const auto heads = end_corrections(design, ends.sizes, little, {ends.leakage_gap}).front();
  design.end_leakage = heads.leakage;
  design.ring_leakage = fine.ring ? std::max(0.0, heads.ring_leakage) : 0;
  PotentialTable table = build_table(design, fine, team, report);

  TableOptions coarse = fine;
  coarse.psi_nodes = ends.psi_nodes;
  coarse.ring_nodes = ends.ring_nodes;
  coarse.gap_nodes = ends.gap_nodes;
  space::CoreMeshSizes flat = ends.sizes;
  flat.ends = false;
  const auto half = [&](int from) {
    return [&ends, from](int done, int all) {
      if (ends.progress) ends.progress(from * all + done, 2 * all);
    };
  };
  PotentialTable bracket = space::build_table(design, ends.sizes, coarse, nullptr, half(0));
  const PotentialTable plane = space::build_table(design, flat, coarse, nullptr, half(1));
  for (std::size_t n = 0; n < bracket.nodes.size(); ++n) bracket.nodes[n] -= plane.nodes[n];

  const std::vector<double> no_ring{0};
  std::size_t n = 0;
  for (const double gap : table.gap)
    for (const double ring : fine.ring ? table.ring : no_ring)
      for (const double psi : table.psi)
        for (const double more : inside(bracket, psi, ring, gap)) table.nodes[n++] += more;
  table.air = space::air_of_core(design, ends.sizes, table.gap, fine.ring);
  estimate_errors(table);
  table.design_hash = end_table_hash(given, options, ends);
  table.description += ", with ends";
  return table;
}

std::uint64_t end_table_hash(const MagnetDesign& design, const TableOptions& options,
                             const EndTableOptions& ends) {
  TableOptions fine = options;
  fine.ring = with_ring(design, options);
  std::uint64_t hash = table_hash(design, fine);
  const auto& s = ends.sizes;
  for (const double value :
       {s.corner, s.other, s.largest, s.far, s.growth, static_cast<double>(s.layers),
        static_cast<double>(ends.psi_nodes), static_cast<double>(ends.gap_nodes), ends.leakage_gap})
    hash = mixed_hash(hash, value);
  return fine.ring ? mixed_hash(hash, static_cast<double>(ends.ring_nodes)) : hash;
}

}  // namespace powbench::sim
