#include "bench/fields/solenoid_peer.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench/fields/peer_run.h"

namespace powbench::bench {
namespace {

enum : int { fixed_iron = 1, plunger, coil, air, rim = 10 };

/// Lengths in mm.
struct Drawing {
  double rp, bore, stop, top, bottom, flange_top, ci, co, clear, in, out, gap, end, reach;
  sim::PlungerFace face;
  double depth, tip, pin, hole;  ///< of the face, see SolenoidShape
};

Drawing drawing(const sim::SolenoidDesign& d, double gap) {
  const auto& s = d.shape;
  constexpr double mm = 1e3;
  const double top = (s.window - s.stop_length) * mm;
  return {s.plunger_radius * mm,
          s.bore_radius * mm,
          -s.stop_length * mm,
          top,
          -(s.stop_length + s.plate) * mm,
          top + s.flange * mm,
          s.coil_inner * mm,
          s.coil_outer * mm,
          s.coil_clearance * mm,
          s.case_inner * mm,
          s.case_outer * mm,
          gap * mm,
          (gap + s.plunger_length) * mm,
          4 * s.plunger_length * mm,
          s.face,
          s.face_depth() * mm,
          s.tip_radius * mm,
          s.step_radius * mm,
          (s.step_radius + s.step_clearance) * mm};
}

/// The face from the rim to the axis, at height `at` of the rim; `inner`: the radius of a step.
std::vector<Corner> face(const Drawing& d, double at, double inner, double pole) {
  std::vector<Corner> corners{{d.rp, at, pole}};
  if (d.face == sim::PlungerFace::stepped) {
    corners.push_back({inner, at, pole});
    corners.push_back({inner, at - d.depth, pole});
  } else if (d.face == sim::PlungerFace::conical && d.tip > 0) {
    corners.push_back({d.tip, at - d.depth, pole});
  }
  corners.push_back({0, at - d.depth, 4 * pole});
  return corners;
}

std::string geometry(const Drawing& d, double size) {
  std::ostringstream out;
  out.precision(12);
  const double pole = 0.12 * size, inner = 0.8 * size, outer = 1.5 * size, box = 12 * size;
  int point = 1, curve = 1;
  out << "SetFactory(\"OpenCASCADE\");\n";
  std::vector<Corner> fixed{{0, d.bottom, outer},         {d.out, d.bottom, outer},
                            {d.out, d.flange_top, outer}, {d.bore, d.flange_top, pole},
                            {d.bore, d.top, pole},        {d.in, d.top, inner},
                            {d.in, d.stop, inner},        {d.rp, d.stop, inner}};
  for (const Corner& c : face(d, 0, d.hole, pole)) fixed.push_back(c);
  polygon(out, point, curve, 1, fixed);
  std::vector<Corner> plunger{{0, d.end, inner}, {d.rp, d.end, inner}};
  for (const Corner& c : face(d, d.gap, d.pin, pole)) plunger.push_back(c);
  polygon(out, point, curve, 2, plunger);
  polygon(out, point, curve, 3,
          {{d.ci, d.stop + d.clear, inner},
           {d.co, d.stop + d.clear, inner},
           {d.co, d.top - d.clear, inner},
           {d.ci, d.top - d.clear, inner}});
  polygon(out, point, curve, 4,
          {{0, -d.reach, box}, {6 * d.out, -d.reach, box}, {6 * d.out, d.reach, box}, {0, d.reach, box}});
  for (int k = 1; k <= 4; ++k) out << "Plane Surface(" << k << ") = {" << k << "};\n";
  out << "all() = BooleanFragments{ Surface{4}; Delete; }{ Surface{1, 2, 3}; Delete; };\n"
      << "Physical Surface(1) = {1};\nPhysical Surface(2) = {2};\nPhysical Surface(3) = {3};\n"
      << "air() = all();\nair() -= {1, 2, 3};\nPhysical Surface(4) = {air()};\n"
      << "rim() = Curve In BoundingBox{-0.01, " << -d.reach - 1 << ", -1, 0.01, " << d.reach + 1 << ", 1};\n";
  for (const double side : {-d.reach, d.reach})
    out << "rim() += Curve In BoundingBox{-1, " << side - 0.01 << ", -1, " << 6 * d.out + 1 << ", "
        << side + 0.01 << ", 1};\n";
  out << "rim() += Curve In BoundingBox{" << 6 * d.out - 0.01 << ", " << -d.reach - 1 << ", -1, "
      << 6 * d.out + 0.01 << ", " << d.reach + 1 << ", 1};\nPhysical Curve(10) = {rim()};\n";
  return out.str();
}

/// r A in T mm2, lengths in mm: the stiffness in A/mm and J in A/mm2 differ by the 1e3 of the load.
std::string script(const Drawing& d, double ampere_turns, double turns) {
  std::ostringstream out;
  out.precision(14);
  out << "mesh Grid = readmesh(\"solenoid.msh\");\n"
         "fespace Quadratic(Grid, P2); fespace Linear(Grid, P1); fespace Constant(Grid, P0);\n"
         "Quadratic u = 0; Constant group = region; Constant steel = (group == 1) || (group == 2);\n"
         "real invmu = 1 / (4e-7 * pi), bk = "
      << law_end << ", hk = " << law_end_h << ", section = " << (d.co - d.ci) * (d.top - d.stop - 2 * d.clear)
      << ";\nreal density = " << ampere_turns
      << " / section;\n"
         "func square = (dx(u)^2 + dy(u)^2) / x^2;\n"
         "func rel = (steel < 0.5) ? invmu : ((square < bk * bk) ? 100 + 10 * exp(1.8 * min(square, bk * "
         "bk))\n"
         "  : (hk + (sqrt(square) - bk) * invmu) / sqrt(max(square, 1e-12)));\n"
         "func extra = (steel < 0.5) ? 0 : ((square < bk * bk) ? 36 * exp(1.8 * min(square, bk * bk))\n"
         "  : (invmu - rel) / max(square, 1e-12));\n"
         "varf left(f, g) = int2d(Grid, qft = qf5pT)(rel / x * (dx(f) * dx(g) + dy(f) * dy(g))\n"
         "  + extra / x^3 * (dx(u) * dx(f) + dy(u) * dy(f)) * (dx(u) * dx(g) + dy(u) * dy(g))) + on(10, f = "
         "0);\n"
         "varf right(f, g) = int2d(Grid, qft = qf5pT)(-rel / x * (dx(u) * dx(g) + dy(u) * dy(g)))\n"
         "  + int2d(Grid, 3, qft = qf5pT)(1e3 * density * g) + on(10, f = 0);\n"
         "real first = 0, rest; int n;\n"
         "for (n = 0; n < 40; n++) {\n"
         "  real[int] rhs = right(0, Quadratic, tgv = -1);\n"
         "  rest = rhs.l2; if (n == 0) first = rest; if (rest < 1e-8 * first) break;\n"
         "  matrix Newton = left(Quadratic, Quadratic, tgv = -1); set(Newton, solver = sparsesolver);\n"
         "  real[int] step = Newton^-1 * rhs; u[] += step;\n"
         "}\n"
         "real linkage = 1e-6 * 2 * pi * "
      << turns << " / section * int2d(Grid, 3)(u);\n"
      << "Linear w = 0, v;\n";
  if (d.face == sim::PlungerFace::flat)
    out << "w = min(1., max(0., (" << d.bore << " - x) / " << d.bore - d.rp << ")) * min(1., max(0., y / "
        << d.gap << ")) * min(1., max(0., 1 - (y - " << d.end << ") / 10.));\n";
  else  // any weight that is 1 on the plunger and 0 on what stands still: a harmonic one
    out << "solve Weight(w, v) = int2d(Grid)(dx(w) * dx(v) + dy(w) * dy(v))\n"
           "  + int2d(Grid)(1e9 * ((group == 1) + (group == 2) + (group == 3)) * w * v)\n"
           "  - int2d(Grid)(1e9 * (group == 2) * v);\n";
  out << "func br = -dy(u) / x; func bz = dx(u) / x;\n"
         "real pull = 1e-6 * 2 * pi * invmu * int2d(Grid, 4, qft = qf5pT)(x * (0.5 * (bz^2 - br^2) * dy(w)\n"
         "  + br * bz * dx(w)));\n"
         "ofstream file(\"solenoid.txt\"); file.precision(12);\n"
         "file << n << \" \" << linkage << \" \" << pull << \" \" << Quadratic.ndof << endl;\n";
  return out.str();
}

}  // namespace

std::optional<SolenoidPeer> solenoid_by_freefem(const std::string& folder, const sim::SolenoidDesign& design,
                                                double gap, double current, double size) {
  if (!have_program("gmsh") || !have_program("FreeFem++")) return std::nullopt;
  std::filesystem::create_directories(folder);
  const Drawing d = drawing(design, gap);
  write_file(folder + "/solenoid.geo", geometry(d, size));
  write_file(folder + "/solenoid.edp", script(d, current * design.turns, design.turns));
  if (!cpu_of("cd " + folder + " && gmsh -v 0 -2 -format msh22 solenoid.geo -o s.msh > gmsh.log 2>&1"))
    return std::nullopt;
  write_freefem_mesh(folder + "/solenoid.msh", read_msh2(folder + "/s.msh", rim));
  std::filesystem::remove(folder + "/solenoid.txt");
  const auto cpu = cpu_of("cd " + folder + " && FreeFem++ -nw -v 0 solenoid.edp > freefem.log 2>&1");
  if (!cpu) return std::nullopt;
  SolenoidPeer r;
  r.cpu = *cpu;
  std::ifstream(folder + "/solenoid.txt") >> r.iterations >> r.flux >> r.pull >> r.unknowns;
  if (!(r.unknowns > 0)) return std::nullopt;
  return r;
}

}  // namespace powbench::bench
