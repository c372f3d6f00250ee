#include "bench/fields/own_peer.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "bench/fields/peer_run.h"
#include "sim/magnetics/plane/import_mesh.h"

namespace powbench::bench {
namespace {

constexpr double mm = 1e-3;

/// What the groups of the outlines are.
const std::map<std::string, sim::DrawnPart>& parts_by_name() {
  using Role = sim::DrawnRole;
  static const std::map<std::string, sim::DrawnPart> parts{
      {"core", {"core", Role::fixed, 0}},
      {"cup", {"cup", Role::fixed, 0}},
      {"armature", {"armature", Role::armature, 0}},
      {"disc", {"disc", Role::armature, 0}},
      {"coil", {"coil", Role::coil, -1, 1500}},
      {"coil_in", {"coil_in", Role::coil, -1, 1500}},
      {"coil_out", {"coil_out", Role::coil, -1, -1500}},
      {"ring_in", {"ring_in", Role::air}},
      {"ring_out", {"ring_out", Role::air}},
      {"layer", {"layer", Role::stretch}},
      {"air", {"air", Role::stretch}},
  };
  return parts;
}

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::shared_ptr<sim::DrawnMagnet> drawn(const std::string& path, const std::string& outline) {
  const auto msh = sim::read_msh(text_of(path));
  auto d = std::make_shared<sim::DrawnMagnet>();
  std::map<int, int> region;
  std::vector<int> zero;
  for (const auto& g : msh.groups) {
    if (g.dimension == 1) zero.push_back(g.tag);
    if (g.dimension != 2) continue;
    region[g.tag] = static_cast<int>(d->parts.size());
    d->parts.push_back(parts_by_name().at(g.name));
    // with a layer the air around it goes with the armature or stands still
    if (g.name == "air" && outline == "e-core") d->parts.back().role = sim::DrawnRole::air;
  }
  d->mesh = sim::import_plane_mesh(msh, mm, region, zero);
  d->name = outline;
  d->axisymmetric = outline == "pot";
  if (d->axisymmetric)
    for (std::size_t v = 0; v < d->mesh.x.size(); ++v)
      if (d->mesh.x[v] < 1e-9) d->mesh.x[v] = 0, d->mesh.zero[v] = 1;
  d->copies = outline == "e-core" ? 2 : 1;
  d->depth = 20e-3;
  d->steels = {sim::builtin_steel("reference")};
  d->drawn_gap = sim::measured_gap(*d);
  return d;
}

/// "(group == 1) || (group == 4)": regions count from 1 in the peers.
std::string regions(const sim::DrawnMagnet& d, const std::vector<sim::DrawnRole>& roles) {
  std::string out;
  for (std::size_t k = 0; k < d.parts.size(); ++k)
    if (std::ranges::find(roles, d.parts[k].role) != roles.end())
      out += (out.empty() ? "" : " || ") + ("(group == " + std::to_string(k + 1) + ")");
  return out;
}

/// Lengths in mm, u in T mm; around an axis r A in T mm2.
std::string freefem_script(const sim::DrawnMagnet& d, double current) {
  using Role = sim::DrawnRole;
  const bool round = d.axisymmetric;
  std::ostringstream out, load, link;
  out.precision(14);
  load.precision(14);
  link.precision(14);
  for (std::size_t k = 0; k < d.parts.size(); ++k) {
    if (d.parts[k].role != Role::coil) continue;
    const double density = d.parts[k].turns / (sim::region_area(d.mesh, static_cast<int>(k)) / (mm * mm));
    load << " + int2d(Grid, " << k + 1 << ", qft = qf5pT)(1e3 * " << density * current << " * g)";
    link << " + " << density << " * int2d(Grid, " << k + 1 << ")(u)";
  }
  out << "mesh Grid = readmesh(\"own.msh\");\n"
         "fespace Quadratic(Grid, P2); fespace Linear(Grid, P1); fespace Constant(Grid, P0);\n"
         "Quadratic u = 0; Constant group = region; Constant steel = "
      << regions(d, {Role::fixed, Role::armature}) << ";\nConstant moving = " << regions(d, {Role::armature})
      << ";\nConstant free = " << regions(d, {Role::air, Role::stretch})
      << ";\nreal invmu = 1 / (4e-7 * pi), bk = " << law_end << ", hk = " << law_end_h
      << ";\nfunc round = " << (round ? "max(x, 1e-9)" : "1.")
      << ";\nfunc square = (dx(u)^2 + dy(u)^2) / round^2;\n"
         "func rel = (steel < 0.5) ? invmu : ((square < bk * bk) ? 100 + 10 * exp(1.8 * min(square, bk * "
         "bk))\n"
         "  : (hk + (sqrt(square) - bk) * invmu) / sqrt(max(square, 1e-12)));\n"
         "func extra = (steel < 0.5) ? 0 : ((square < bk * bk) ? 36 * exp(1.8 * min(square, bk * bk))\n"
         "  : (invmu - rel) / max(square, 1e-12));\n"
         "varf left(f, g) = int2d(Grid, qft = qf5pT)(rel / round * (dx(f) * dx(g) + dy(f) * dy(g))\n"
         "  + extra / round^3 * (dx(u) * dx(f) + dy(u) * dy(f)) * (dx(u) * dx(g) + dy(u) * dy(g))) + on(10, "
         "f = 0);\n"
         "varf right(f, g) = int2d(Grid, qft = qf5pT)(-rel / round * (dx(u) * dx(g) + dy(u) * dy(g)))"
      << load.str()
      << " + on(10, f = 0);\n"
         "real first = 0, rest; int n;\n"
         "for (n = 0; n < 40; n++) {\n"
         "  real[int] rhs = right(0, Quadratic, tgv = -1);\n"
         "  rest = rhs.l2; if (n == 0) first = rest; if (rest < 1e-9 * first) break;\n"
         "  matrix Newton = left(Quadratic, Quadratic, tgv = -1); set(Newton, solver = sparsesolver);\n"
         "  real[int] step = Newton^-1 * rhs; u[] += step;\n"
         "}\n"
         // the weight: 1 on the armature, 0 on all other bodies, harmonic in air
         "Linear w, v;\n"
         "solve weight(w, v) = int2d(Grid)((free > 0.5 ? 1. : 0.) * (dx(w) * dx(v) + dy(w) * dy(v)))\n"
         "  + int2d(Grid)((free > 0.5 ? 0. : 1e9) * w * v) - int2d(Grid)((moving > 0.5 ? 1e9 : 0.) * v);\n"
      << "func bx = " << (round ? "-dy(u) / round" : "dy(u)")
      << "; func by = " << (round ? "dx(u) / round" : "-dx(u)") << ";\nfunc thick = "
      << (round ? "2 * pi * round * 1e-6" : std::to_string(d.depth * d.copies) + " * 1e-3")
      << ";\nreal pull = int2d(Grid, qft = qf5pT)((free > 0.5 ? 1. : 0.) * thick * invmu * (0.5 * (by^2 - "
         "bx^2) * dy(w)\n"
         "  + bx * by * dx(w)));\n"
         "real linkage = "
      << (round ? 2 * 3.14159265358979 * 1e-6 : d.depth * d.copies * 1e-3) << " * (0" << link.str()
      << ");\nofstream file(\"own.txt\"); file.precision(12);\n"
         "file << linkage << \" \" << pull << \" \" << Quadratic.ndof << endl;\n";
  return out.str();
}

/// In m, regions of the mesh as gmsh numbers them.
std::string getdp_script(const sim::DrawnMagnet& d, const std::vector<int>& tags, int rim, double current) {
  using Role = sim::DrawnRole;
  std::ostringstream steel, free, coil, whole, density, linkage;
  for (auto* s : {&density, &linkage}) s->precision(14);
  const auto add = [](std::ostringstream& list, int tag) { list << (list.tellp() > 0 ? ", " : "") << tag; };
  for (std::size_t k = 0; k < d.parts.size(); ++k) {
    const bool iron = d.parts[k].role == Role::fixed || d.parts[k].role == Role::armature;
    add(iron ? steel : free, tags[k]);
    add(whole, tags[k]);
    if (d.parts[k].role != Role::coil) continue;
    add(coil, tags[k]);
    const double turns = d.parts[k].turns / sim::region_area(d.mesh, static_cast<int>(k));
    density << "  turns[Region[" << tags[k] << "]] = " << turns << ";\n";
  }
  std::ostringstream out;
  out.precision(14);
  out << "Group { Steel = Region[{" << steel.str() << "}]; Free = Region[{" << free.str()
      << "}]; Winding = Region[{" << coil.str() << "}]; Whole = Region[{" << whole.str()
      << "}]; Rim = Region[" << rim << "]; }\nFunction {\n"
      << "  invmu = 1 / (4e-7 * Pi); Bk = " << law_end << "; Hk = " << law_end_h
      << ";\n  above[] = (Hk + (Norm[$1] - Bk) * invmu) / Norm[$1];\n  rel[Free] = invmu;\n"
         "  rel[Steel] = (Norm[$1] < Bk) ? 100 + 10 * Exp[1.8 * SquNorm[$1]] : above[$1];\n"
         "  slope[Steel] = (Norm[$1] < Bk) ? 18 * Exp[1.8 * SquNorm[$1]] : (invmu - above[$1]) / (2 * "
         "SquNorm[$1]);\n"
         "  tangent[Steel] = TensorDiag[1, 1, 1] * rel[$1] + 2 * slope[$1] * SquDyadicProduct[$1];\n"
      << density.str() << "  density[Winding] = Vector[0, 0, 1] * turns[] * " << current
      << ";\n}\nConstraint { { Name Zero; Case { { Region Rim; Value 0; } } } }\n"
         "Jacobian { { Name J; Case { { Region All; Jacobian Vol; } } } }\n"
         "Integration { { Name G; Case { { Type Gauss; Case { { GeoElement Triangle; NumberOfPoints 6; } } } "
         "} } }\n"
         "FunctionSpace { { Name Potential; Type Form1P; BasisFunction {\n"
         "  { Name w; NameOfCoef c; Function BF_PerpendicularEdge; Support Whole; Entity NodesOf[All]; }\n"
         "  { Name q; NameOfCoef e; Function BF_PerpendicularEdge_2E; Support Whole; Entity EdgesOf[All]; } "
         "}\n"
         "  Constraint { { NameOfCoef c; EntityType NodesOf; NameOfConstraint Zero; }\n"
         "    { NameOfCoef e; EntityType EdgesOf; NameOfConstraint Zero; } } } }\n"
         "Formulation { { Name Statics; Type FemEquation; Quantity { { Name v; Type Local; NameOfSpace "
         "Potential; } }\n"
         "  Equation {\n"
         "    Galerkin { [ rel[] * Dof{d v}, {d v} ]; In Free; Jacobian J; Integration G; }\n"
         "    Galerkin { [ tangent[{d v}] * Dof{d v}, {d v} ]; In Steel; Jacobian J; Integration G; }\n"
         "    Galerkin { [ (rel[{d v}] * {d v}) - (tangent[{d v}] * {d v}), {d v} ]; In Steel; Jacobian J; "
         "Integration G; }\n"
         "    Galerkin { [ -density[], {v} ]; In Winding; Jacobian J; Integration G; } } } }\n"
         "Resolution { { Name Run; System { { Name M; NameOfFormulation Statics; } } Operation {\n"
         "  InitSolution[M]; Generate[M]; GetResidual[M, $first]; Evaluate[$rest = $first, $n = 0];\n"
         "  While[ $rest > 1e-8 * $first && $n < 40 ] {\n"
         "    Solve[M]; Generate[M]; GetResidual[M, $rest]; Evaluate[$n = $n + 1]; }\n"
         "  SaveSolution[M]; } } }\n"
         "PostProcessing { { Name Post; NameOfFormulation Statics; Quantity { { Name linkage; Value { "
         "Integral {\n"
         "  [ "
      << d.depth * d.copies
      << " * turns[] * CompZ[{v}] ]; In Winding; Jacobian J; Integration G; } } } } } }\n"
         "PostOperation { { Name Out; NameOfPostProcessing Post; Operation {\n"
         "  Print[ linkage[Winding], OnGlobal, Format Table, File \"own_getdp.txt\" ]; } } }\n";
  return out.str();
}

}  // namespace

OwnPeer::OwnPeer(std::string folder, std::string outlines)
    : folder_(std::move(folder)), outlines_(std::move(outlines)) {
  std::filesystem::create_directories(folder_);
}

std::shared_ptr<const sim::DrawnMagnet> OwnPeer::read(const std::string& outline, double residual_gap,
                                                      double travel) const {
  auto d = drawn(folder_ + "/" + outline + ".msh", outline);
  d->residual_gap = residual_gap;
  d->travel = travel;
  d->motion = sim::drawn_motion(*d);
  return d;
}

std::shared_ptr<const sim::DrawnMagnet> OwnPeer::drawing(const std::string& outline,
                                                         const std::string& lengths, double gap, double size,
                                                         double residual_gap, double travel) {
  if (!have_program("gmsh")) return nullptr;
  std::ostringstream command;
  command << "cd " << folder_ << " && gmsh -v 0 -2 -format msh41 " << lengths << " -setnumber gap "
          << gap / mm << " -setnumber size " << size << " '" << outlines_ << "/" << outline << ".geo' -o "
          << outline << ".msh > gmsh.log 2>&1";
  if (!cpu_of(command.str())) return nullptr;
  return read(outline, residual_gap, travel);
}

std::optional<OwnPeerResult> OwnPeer::solve(const std::string& outline, const std::string& lengths,
                                            double gap, double size, double current) {
  if (!have_program("FreeFem++")) return std::nullopt;
  std::ostringstream command;
  command.precision(12);
  command << "cd " << folder_ << " && gmsh -v 0 -2 -format msh22 " << lengths << " -setnumber gap "
          << gap / mm << " -setnumber size " << size << " '" << outlines_ << "/" << outline
          << ".geo' -o peer.msh > gmsh.log 2>&1";
  if (!cpu_of(command.str())) return std::nullopt;
  const auto d = drawn(folder_ + "/peer.msh", outline);
  auto scaled = d->mesh;
  for (auto* axis : {&scaled.x, &scaled.y})
    for (double& value : *axis) value /= mm;
  for (int& r : scaled.region) ++r;
  write_freefem_mesh(folder_ + "/own.msh", scaled);
  write_file(folder_ + "/own.edp", freefem_script(*d, current));
  std::filesystem::remove(folder_ + "/own.txt");
  if (!cpu_of("cd " + folder_ + " && FreeFem++ -nw -v 0 own.edp > freefem.log 2>&1")) return std::nullopt;
  OwnPeerResult r;
  std::ifstream(folder_ + "/own.txt") >> r.flux >> r.pull >> r.unknowns;
  if (!(r.unknowns > 0)) return std::nullopt;
  if (d->axisymmetric || !have_program("getdp")) return r;
  std::vector<int> tags;
  int rim = 0;
  for (const auto& g : sim::read_msh(text_of(folder_ + "/peer.msh")).groups)
    (g.dimension == 2 ? tags.emplace_back() : rim) = g.tag;
  std::string metres = command.str();
  metres.replace(metres.find("peer.msh"), 8, "own_m.msh -setnumber Mesh.ScalingFactor 0.001");
  if (!cpu_of(metres)) return r;
  write_file(folder_ + "/own.pro", getdp_script(*d, tags, rim, current));
  std::filesystem::remove(folder_ + "/own_getdp.txt");
  if (!cpu_of("cd " + folder_ + " && getdp own.pro -msh own_m.msh -solve Run -pos Out -v 0 > getdp.log 2>&1"))
    return r;
  std::ifstream table(folder_ + "/own_getdp.txt");
  for (std::string word; table >> word;) r.getdp_flux = std::atof(word.c_str());
  return r;
}

}  // namespace powbench::bench
