#include "bench/fields/peers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "bench/fields/peer_run.h"

namespace powbench::bench {
namespace {

constexpr double mm = 1e-3, depth = 15e-3;
constexpr double coil_section = 7e-3 * 18e-3;

/// The half model. The parts touch the axis, so the air is the box cut by the fragments of the parts.
std::string geometry(double gap_mm, double s) {
  std::ostringstream out;
  out.precision(12);
  const double pole = 0.35 * s, window = 0.6 * s, outer = 1.6 * s, box = 9 * s;
  const double d = gap_mm;
  int point = 1, curve = 1;
  out << "SetFactory(\"OpenCASCADE\");\n";
  polygon(out, point, curve, 1,
          {{0, -29, outer},
           {22, -29, outer},
           {22, 0, pole},
           {15, 0, pole},
           {15, -22, window},
           {6, -22, window},
           {6, -0.1, pole},
           {0, -0.1, pole}});
  polygon(out, point, curve, 2,
          {{0, d, pole},
           {6, d, pole},
           {6, d + 6, window},
           {15, d + 6, window},
           {15, d, pole},
           {22, d, pole},
           {22, d + 13, outer},
           {0, d + 13, outer}});
  polygon(out, point, curve, 3, {{7, -21, outer}, {14, -21, outer}, {14, -3, outer}, {7, -3, outer}});
  polygon(out, point, curve, 4, {{0, -110, box}, {120, -110, box}, {120, 100, box}, {0, 100, box}});
  for (int k = 1; k <= 4; ++k) out << "Plane Surface(" << k << ") = {" << k << "};\n";
  out << "all() = BooleanFragments{ Surface{4}; Delete; }{ Surface{1, 2, 3}; Delete; };\n"
      << "iron() = Surface In BoundingBox{-1, -29.1, -1, 22.1, 0.01, 1};\n"
      << "Physical Surface(1) = {1};\nPhysical Surface(2) = {2};\nPhysical Surface(3) = {3};\n"
      << "air() = all();\nair() -= {1, 2, 3};\nPhysical Surface(4) = {air()};\n"
      << "rim() = Curve In BoundingBox{-0.01, -111, -1, 0.01, 101, 1};\n"
      << "rim() += Curve In BoundingBox{-1, -110.01, -1, 121, -109.99, 1};\n"
      << "rim() += Curve In BoundingBox{-1, 99.99, -1, 121, 100.01, 1};\n"
      << "rim() += Curve In BoundingBox{119.99, -111, -1, 120.01, 101, 1};\n"
      << "Physical Curve(10) = {rim()};\n";
  return out.str();
}

std::string getdp_input() {
  std::ostringstream out;
  out << "DefineConstant[ AT = 1000, Most = 40 ];\n"
         "Group {\n"
         "  Steel = Region[{1, 2}]; Winding = Region[3]; Free = Region[{3, 4}]; Whole = Region[{1, 2, 3, "
         "4}]; Rim = Region[10];\n"
         "}\n"
         "Function {\n"
         "  invmu = 1 / (4e-7 * Pi); Bk = "
      << law_end << "; Hk = " << law_end_h
      << ";\n"
         "  above[] = (Hk + (Norm[$1] - Bk) * invmu) / Norm[$1];\n"
         "  rel[Free] = invmu;\n"
         "  rel[Steel] = (Norm[$1] < Bk) ? 100 + 10 * Exp[1.8 * SquNorm[$1]] : above[$1];\n"
         "  slope[Steel] = (Norm[$1] < Bk) ? 18 * Exp[1.8 * SquNorm[$1]] : (invmu - above[$1]) / (2 * "
         "SquNorm[$1]);\n"
         "  tangent[Steel] = TensorDiag[1, 1, 1] * rel[$1] + 2 * slope[$1] * SquDyadicProduct[$1];\n"
         "  density[Winding] = Vector[0, 0, AT / "
      << coil_section
      << "];\n"
         "}\n"
         "Constraint { { Name Zero; Case { { Region Rim; Value 0; } } } }\n"
         "Jacobian { { Name J; Case { { Region All; Jacobian Vol; } } } }\n"
         "Integration { { Name G; Case { { Type Gauss; Case { { GeoElement Triangle; NumberOfPoints 1; } } } "
         "} } }\n"
         "FunctionSpace { { Name Potential; Type Form1P;\n"
         "  BasisFunction { { Name w; NameOfCoef c; Function BF_PerpendicularEdge; Support Whole; Entity "
         "NodesOf[All]; } }\n"
         "  Constraint { { NameOfCoef c; EntityType NodesOf; NameOfConstraint Zero; } } } }\n"
         "Formulation { { Name Statics; Type FemEquation; Quantity { { Name v; Type Local; NameOfSpace "
         "Potential; } }\n"
         "  Equation {\n"
         "    Galerkin { [ rel[] * Dof{d v}, {d v} ]; In Free; Jacobian J; Integration G; }\n"
         "    Galerkin { [ tangent[{d v}] * Dof{d v}, {d v} ]; In Steel; Jacobian J; Integration G; }\n"
         "    Galerkin { [ (rel[{d v}] * {d v}) - (tangent[{d v}] * {d v}), {d v} ]; In Steel; Jacobian J; "
         "Integration G; }\n"
         "    Galerkin { [ -density[], {v} ]; In Winding; Jacobian J; Integration G; }\n"
         "  } } }\n"
         "Resolution { { Name Run; System { { Name M; NameOfFormulation Statics; } }\n"
         "  Operation {\n"
         "    InitSolution[M]; Generate[M]; GetResidual[M, $first]; Evaluate[$rest = $first, $n = 0];\n"
         "    While[ $rest > 1e-8 * $first && $n < Most ] {\n"
         "      Solve[M]; Generate[M]; GetResidual[M, $rest]; Evaluate[$n = $n + 1];\n"
         "      Print[{$n, $rest}, Format \"STEP %g %g\"];\n"
         "    }\n"
         "    SaveSolution[M];\n"
         "  } } }\n"
         "PostProcessing { { Name Post; NameOfFormulation Statics; Quantity {\n"
         "  { Name linkage; Value { Integral { [ 2 * "
      << depth << " / " << coil_section
      << " * CompZ[{v}] ]; In Winding; Jacobian J; Integration G; } } } } } }\n"
         "PostOperation { { Name Out; NameOfPostProcessing Post; Operation {\n"
         "  Print[ linkage[Winding], OnGlobal, Format Table, File \"linkage.txt\" ]; } } }\n";
  return out.str();
}

std::string freefem_input(double ampere_turns, int most) {
  std::ostringstream out;
  out << "mesh Grid = readmesh(\"freefem.msh\");\n"
         "fespace Linear(Grid, P1); fespace Constant(Grid, P0);\n"
         "Linear u = 0, du, test; Constant group = region;\n"
         "Constant steel = (group == 1) || (group == 2);\n"
         "real invmu = 1 / (4e-7 * pi), bk = "
      << law_end << ", hk = " << law_end_h << ", density = " << ampere_turns
      << " / 126.;\n"
         "Constant rel, extra, square;\n"  // lengths in mm, u in T mm
         "varf left(f, g) = int2d(Grid, qft = qf1pT)(rel * (dx(f) * dx(g) + dy(f) * dy(g))\n"
         "  + extra * (dx(u) * dx(f) + dy(u) * dy(f)) * (dx(u) * dx(g) + dy(u) * dy(g))) + on(10, f = 0);\n"
         "varf right(f, g) = int2d(Grid, qft = qf1pT)(-rel * (dx(u) * dx(g) + dy(u) * dy(g)))\n"
         "  + int2d(Grid, 3, qft = qf1pT)(1e3 * density * g) + on(10, f = 0);\n"
         "real first = 0, rest; int n;\n"
         "for (n = 0; n < "
      << most
      << "; n++) {\n"
         "  square = dx(u)^2 + dy(u)^2;\n"
         "  rel = (steel < 0.5) ? invmu : ((square < bk * bk) ? 100 + 10 * exp(1.8 * min(square, bk * bk))\n"
         "    : (hk + (sqrt(square) - bk) * invmu) / sqrt(max(square, 1e-9)));\n"
         "  extra = (steel < 0.5) ? 0 : ((square < bk * bk) ? 36 * exp(1.8 * min(square, bk * bk))\n"
         "    : (invmu - rel) / max(square, 1e-9));\n"
         "  real[int] rhs = right(0, Linear, tgv = -1);\n"
         "  rest = rhs.l2; if (n == 0) first = rest; if (rest < 1e-8 * first) break;\n"
         "  matrix Newton = left(Linear, Linear, tgv = -1); set(Newton, solver = sparsesolver);\n"
         "  real[int] step = Newton^-1 * rhs; u[] += step;\n"
         "}\n"
         "real linkage = int2d(Grid, 3)(2 * 0.015 / 126. * 1e-3 * u);\n"
         "ofstream file(\"linkage_ff.txt\"); file.precision(12); file << n << \" \" << linkage << endl;\n";
  return out.str();
}

}  // namespace

Peers::Peers(std::string folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
}

std::optional<sim::Mesh> Peers::mesh(double gap, double size) {
  if (!have_program("gmsh")) return std::nullopt;
  write_file(folder_ + "/half.geo", geometry(gap / mm, size));
  const std::string common = "cd " + folder_ + " && gmsh -v 0 -2 -format msh22 half.geo -o ";
  if (!cpu_of(common + "mm.msh > gmsh.log 2>&1")) return std::nullopt;
  auto m = read_msh2(folder_ + "/mm.msh", PeerRegion::rim);
  write_freefem_mesh(folder_ + "/freefem.msh", m);
  for (auto* axis : {&m.x, &m.y})
    for (double& value : *axis) value *= mm;
  // the same mesh in metres for GetDP
  if (!cpu_of(common + "m.msh -setnumber Mesh.ScalingFactor 0.001 > gmsh.log 2>&1")) return std::nullopt;
  return m;
}

std::optional<PeerResult> Peers::getdp(double ampere_turns) {
  if (!have_program("getdp")) return std::nullopt;
  write_file(folder_ + "/half.pro", getdp_input());
  const auto run = [&](int most) {
    std::ostringstream command;
    command << "cd " << folder_ << " && getdp half.pro -msh m.msh -solve Run -pos Out -setnumber AT "
            << ampere_turns << " -setnumber Most " << most << " > getdp.log 2>&1";
    return cpu_of(command.str());
  };
  const auto count = [&] {
    std::ifstream log(folder_ + "/getdp.log");
    int steps = 0;
    for (std::string line; std::getline(log, line);) steps += line.find("STEP") != std::string::npos;
    return steps;
  };
  const auto all = run(40);
  if (!all) return std::nullopt;
  PeerResult r;
  r.iterations = count();
  std::ifstream table(folder_ + "/linkage.txt");
  for (std::string word; table >> word;) r.flux = std::atof(word.c_str());
  const auto two = run(2);
  if (!two || r.iterations < 3) return std::nullopt;
  r.cpu_iteration = (*all - *two) / (r.iterations - 2);
  return r;
}

std::optional<PeerResult> Peers::freefem(double ampere_turns) {
  if (!have_program("FreeFem++")) return std::nullopt;
  const auto run = [&](int most) {
    write_file(folder_ + "/half.edp", freefem_input(ampere_turns, most));
    return cpu_of("cd " + folder_ + " && FreeFem++ -nw -v 0 half.edp > freefem.log 2>&1");
  };
  const auto all = run(40);
  if (!all) return std::nullopt;
  PeerResult r;
  std::ifstream(folder_ + "/linkage_ff.txt") >> r.iterations >> r.flux;
  const auto two = run(2);
  if (!two || r.iterations < 3) return std::nullopt;
  r.cpu_iteration = (*all - *two) / (r.iterations - 2);
  return r;
}

}  // namespace powbench::bench
