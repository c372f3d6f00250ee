#include "bench/fields/two_leg_peer.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench/fields/peer_run.h"
#include "sim/magnetics/plane/newton.h"

namespace powbench::bench {
namespace {

enum : int { fixed_iron = 1, moving_iron, coil, air, coil_back, leg, rim = 10 };
constexpr double mm = 1e-3;

std::string geometry(const sim::MagnetShape& s, double g, double size) {
  std::ostringstream out;
  out.precision(12);
  const double pole = 0.25 * size, inner = 0.6 * size, outer = 1.5 * size, box = 12 * size;
  const double x1 = s.centre_width / 2 / mm, x2 = x1 + s.window_width / mm, x3 = x2 + s.outer_width / mm;
  const double floor = -s.fixed_window / mm, bottom = floor - s.yoke / mm, ceiling = g + s.moving_window / mm,
               top = ceiling + s.yoke / mm;
  const double left = x1 + (s.window_width - s.coil_width) / 2 / mm, right = left + s.coil_width / mm,
               low = floor + s.coil_offset / mm, high = low + s.coil_height / mm, reach = 5.5 * x3;
  int point = 1, curve = 1;
  const auto box_of = [&](int loop, double a, double b, double c, double d, double cell) {
    polygon(out, point, curve, loop, {{a, b, cell}, {c, b, cell}, {c, d, cell}, {a, d, cell}});
  };
  out << "SetFactory(\"OpenCASCADE\");\n";
  polygon(out, point, curve, 1,
          {{-x1, bottom, outer},
           {x3, bottom, outer},
           {x3, 0, pole},
           {x2, 0, pole},
           {x2, floor, inner},
           {x1, floor, inner},
           {x1, 0, pole},
           {-x1, 0, pole}});
  polygon(out, point, curve, 2,
          {{-x1, g, pole},
           {x1, g, pole},
           {x1, ceiling, inner},
           {x2, ceiling, inner},
           {x2, g, pole},
           {x3, g, pole},
           {x3, top, outer},
           {-x1, top, outer}});
  box_of(3, left, low, right, high, outer);
  box_of(4, -reach, bottom - reach, reach, top + reach, box);
  box_of(5, -right, low, -left, high, outer);
  const bool closed = s.closed_leg != 0;
  if (closed) box_of(6, x2, 0, x3, g, pole);
  const std::string parts = closed ? "1, 2, 3, 5, 6" : "1, 2, 3, 5";
  for (int k = 1; k <= (closed ? 6 : 5); ++k) out << "Plane Surface(" << k << ") = {" << k << "};\n";
  out << "all() = BooleanFragments{ Surface{4}; Delete; }{ Surface{" << parts << "}; Delete; };\n";
  for (const int k : {1, 2, 3, 5}) out << "Physical Surface(" << k << ") = {" << k << "};\n";
  if (closed) out << "Physical Surface(6) = {6};\n";
  out << "air() = all();\nair() -= {" << parts << "};\nPhysical Surface(4) = {air()};\n";
  const auto side = [&](double a, double b, double c, double d) {
    out << "rim() += Curve In BoundingBox{" << a - 0.01 << ", " << b - 0.01 << ", -1, " << c + 0.01 << ", "
        << d + 0.01 << ", 1};\n";
  };
  out << "rim() = {};\n";
  for (const double y : {bottom - reach, top + reach}) side(-reach, y, reach, y);
  for (const double x : {-reach, reach}) side(x, bottom - reach, x, top + reach);
  out << "Physical Curve(10) = {rim()};\n";
  return out.str();
}

/// u in T mm, lengths in mm.
std::string script(const sim::MagnetDesign& d, double gap, double current) {
  const double section = d.shape.coil_width * d.shape.coil_height / (mm * mm);
  std::ostringstream out;
  out.precision(14);
  out << "mesh Grid = readmesh(\"legs.msh\");\n"
         "fespace Quadratic(Grid, P2); fespace Linear(Grid, P1); fespace Constant(Grid, P0);\n"
         "Quadratic u = 0; Constant group = region;\n"
         "Constant steel = (group == 1) || (group == 2) || (group == 6);\n"
         "real invmu = 1 / (4e-7 * pi), bk = "
      << law_end << ", hk = " << law_end_h << ", density = " << current * d.turns / section
      << ";\n"
         "func square = dx(u)^2 + dy(u)^2;\n"
         "func rel = (steel < 0.5) ? invmu : ((square < bk * bk) ? 100 + 10 * exp(1.8 * min(square, bk * "
         "bk))\n"
         "  : (hk + (sqrt(square) - bk) * invmu) / sqrt(max(square, 1e-12)));\n"
         "func extra = (steel < 0.5) ? 0 : ((square < bk * bk) ? 36 * exp(1.8 * min(square, bk * bk))\n"
         "  : (invmu - rel) / max(square, 1e-12));\n"
         "varf left(f, g) = int2d(Grid, qft = qf5pT)(rel * (dx(f) * dx(g) + dy(f) * dy(g))\n"
         "  + extra * (dx(u) * dx(f) + dy(u) * dy(f)) * (dx(u) * dx(g) + dy(u) * dy(g))) + on(10, f = 0);\n"
         "varf right(f, g) = int2d(Grid, qft = qf5pT)(-rel * (dx(u) * dx(g) + dy(u) * dy(g)))\n"
         "  + int2d(Grid, 3, qft = qf5pT)(1e3 * density * g) - int2d(Grid, 5, qft = qf5pT)(1e3 * density * "
         "g)\n"
         "  + on(10, f = 0);\n"
         "real first = 0, rest; int n;\n"
         "for (n = 0; n < 40; n++) {\n"
         "  real[int] rhs = right(0, Quadratic, tgv = -1);\n"
         "  rest = rhs.l2; if (n == 0) first = rest; if (rest < 1e-9 * first) break;\n"
         "  matrix Newton = left(Quadratic, Quadratic, tgv = -1); set(Newton, solver = sparsesolver);\n"
         "  real[int] step = Newton^-1 * rhs; u[] += step;\n"
         "}\n"
         "real linkage = 1e-3 * "
      << d.turns * d.shape.stack / section
      << " * (int2d(Grid, 3)(u) - int2d(Grid, 5)(u));\n"
         "Linear w = min(1., max(0., y / "
      << gap / mm
      << "));\n"
         "func energy = (steel < 0.5) ? 0.5 * invmu * square : 50 * square + (exp(1.8 * min(square, bk * "
         "bk)) - 1) "
         "* 10 / 3.6;\n"
         "real pull = 1e-3 * "
      << d.shape.stack
      << " * int2d(Grid, qft = qf5pT)((energy - rel * dy(u)^2) * dy(w) - rel * dx(u) * dy(u) * dx(w));\n"
         "ofstream file(\"legs.txt\"); file.precision(12);\n"
         "file << n << \" \" << linkage << \" \" << pull << \" \" << Quadratic.ndof << endl;\n";
  return out.str();
}

/// The own elements on the peer's mesh.
double flux_on(sim::Mesh mesh, const sim::MagnetDesign& d, double current) {
  for (auto* axis : {&mesh.x, &mesh.y})
    for (double& value : *axis) value *= mm;
  sim::FieldSetup f;
  f.depth = d.shape.stack;
  f.steels = {d.steel};
  f.steel_of_region.assign(leg + 1, -1);
  for (const int iron : {fixed_iron, moving_iron, leg}) f.steel_of_region[static_cast<std::size_t>(iron)] = 0;
  f.windings = {{{{coil, d.turns}, {coil_back, -d.turns}}}};
  const sim::FieldProblem problem(std::move(mesh), f);
  sim::Newton newton(problem);
  std::vector<double> a(static_cast<std::size_t>(problem.size()) + 1, 0), currents;
  newton.solve({{false, current, 0}}, a, currents);
  double flux = 0;
  for (std::size_t k = 0; k < a.size(); ++k) flux += a[k] * problem.winding(0)[k];
  return flux;
}

}  // namespace

std::optional<TwoLegPeer> two_legs_by_freefem(const std::string& folder, const sim::MagnetDesign& design,
                                              double gap, double current, double size) {
  if (!have_program("gmsh") || !have_program("FreeFem++")) return std::nullopt;
  std::filesystem::create_directories(folder);
  write_file(folder + "/legs.geo", geometry(design.shape, gap / mm, size));
  write_file(folder + "/legs.edp", script(design, gap, current));
  if (!cpu_of("cd " + folder + " && gmsh -v 0 -2 -format msh22 legs.geo -o s.msh > gmsh.log 2>&1"))
    return std::nullopt;
  auto mesh = read_msh2(folder + "/s.msh", rim);
  write_freefem_mesh(folder + "/legs.msh", mesh);
  std::filesystem::remove(folder + "/legs.txt");
  if (!cpu_of("cd " + folder + " && FreeFem++ -nw -v 0 legs.edp > freefem.log 2>&1")) return std::nullopt;
  TwoLegPeer r;
  std::ifstream(folder + "/legs.txt") >> r.iterations >> r.flux >> r.pull >> r.unknowns;
  if (!(r.unknowns > 0)) return std::nullopt;
  r.same_mesh_flux = flux_on(std::move(mesh), design, current);
  return r;
}

}  // namespace powbench::bench
