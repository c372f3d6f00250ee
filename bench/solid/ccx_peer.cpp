#include "bench/solid/ccx_peer.h"

#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

namespace powbench::bench {
namespace {

double children_cpu() {
  rusage r{};
  getrusage(RUSAGE_CHILDREN, &r);
  return static_cast<double>(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

bool ccx_is_here() {
  return std::system("command -v ccx > /dev/null 2>&1") == 0;
}

CcxRun run_ccx(const std::string& input) {
  CcxRun run;
  const auto folder =
      std::filesystem::temp_directory_path() / ("powbench_ccx_" + std::to_string(std::rand()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "job.inp") << input;
  const double before = children_cpu();
  const std::string command =
      "cd '" + folder.string() + "' && OMP_NUM_THREADS=1 timeout 900 ccx job > job.log 2>&1";
  run.ran = std::system(command.c_str()) == 0;
  run.cpu = children_cpu() - before;
  const std::string log = text_of(folder / "job.log"), key = "SELECTED time increment:";
  if (const auto at = log.find(key); at != std::string::npos)
    run.selected = std::atof(log.c_str() + at + key.size());
  run.dat = text_of(folder / "job.dat");
  std::filesystem::remove_all(folder);
  return run;
}

std::string ccx_bar(const std::string& contact, double end) {
  constexpr int nx = 10, ny = 10, nz = 50;
  std::ostringstream f;
  const bool tied = contact == "tied";
  const auto id = [](int i, int j, int k) { return 1 + i + (nx + 1) * (j + (ny + 1) * k); };
  f << "*NODE,NSET=NALL\n";
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        f << id(i, j, k) << ',' << i << ',' << j << ',' << k + (tied ? 0 : 0.01) << '\n';
  f << "*ELEMENT,TYPE=C3D8R,ELSET=BAR\n";
  int e = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        f << ++e << ',' << id(i, j, k) << ',' << id(i + 1, j, k) << ',' << id(i + 1, j + 1, k) << ','
          << id(i, j + 1, k) << ',' << id(i, j, k + 1) << ',' << id(i + 1, j, k + 1) << ','
          << id(i + 1, j + 1, k + 1) << ',' << id(i, j + 1, k + 1) << '\n';
  f << "*MATERIAL,NAME=S\n*ELASTIC\n2e5,0.3\n*DENSITY\n7.85e-9\n*SOLID "
       "SECTION,ELSET=BAR,MATERIAL=S\n*NSET,NSET=FOOT\n";
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) f << id(i, j, 0) << ",\n";
  const int last = id(nx, ny, nz);
  f << "*NSET,NSET=BARN,GENERATE\n1," << last << '\n';
  if (!tied) {
    f << "*NODE,NSET=WALL\n";
    const int corner[8][3] = {{-5, -5, -5}, {15, -5, -5}, {15, 15, -5}, {-5, 15, -5},
                              {-5, -5, 0},  {15, -5, 0},  {15, 15, 0},  {-5, 15, 0}};
    for (int q = 0; q < 8; ++q)
      f << last + 1 + q << ',' << corner[q][0] << ',' << corner[q][1] << ',' << corner[q][2] << '\n';
    f << "*ELEMENT,TYPE=C3D8,ELSET=WEL\n" << e + 1;
    for (int q = 0; q < 8; ++q) f << ',' << last + 1 + q;
    f << "\n*SOLID SECTION,ELSET=WEL,MATERIAL=S\n*SURFACE,NAME=MS,TYPE=ELEMENT\n" << e + 1 << ",S2\n";
    if (contact == "n2s")
      f << "*SURFACE,NAME=SL,TYPE=NODE\nFOOT\n";
    else
      f << "*ELSET,ELSET=EB,GENERATE\n1," << nx * ny << "\n*SURFACE,NAME=SL,TYPE=ELEMENT\nEB,S1\n";
    f << "*SURFACE INTERACTION,NAME=I\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR\n2.7e5\n*CONTACT "
         "PAIR,INTERACTION=I,TYPE="
      << (contact == "n2s" ? "NODE TO SURFACE" : "SURFACE TO SURFACE") << "\nSL,MS\n*BOUNDARY\nWALL,1,3\n";
  } else {
    f << "*BOUNDARY\nFOOT,3,3\n";
  }
  f << "*INITIAL CONDITIONS,TYPE=VELOCITY\nBARN,3,-1000.\n*STEP,INC=1000000\n*DYNAMIC,EXPLICIT\n1e-8," << end
    << "\n*NODE PRINT,NSET=FOOT,FREQUENCY=1000000\nU\n*END STEP\n";
  return f.str();
}

sim::SolidMesh with_middles(const sim::SolidMesh& mesh, double radius,
                            std::vector<std::array<int, 20>>& cells) {
  constexpr int edges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  sim::SolidMesh out = mesh;
  std::map<std::pair<int, int>, int> known;
  for (const auto& cell : mesh.cells) {
    std::array<int, 20> all{};
    for (std::size_t k = 0; k < 8; ++k) all[k] = cell.nodes[k];
    for (std::size_t e = 0; e < 12; ++e) {
      const int from = cell.nodes[static_cast<std::size_t>(edges[e][0])],
                to = cell.nodes[static_cast<std::size_t>(edges[e][1])];
      const auto [at, fresh] = known.try_emplace(std::minmax(from, to), static_cast<int>(out.nodes.size()));
      all[8 + e] = at->second;
      if (!fresh) continue;
      const sim::Vec3 &a = mesh.nodes[static_cast<std::size_t>(from)],
                      &b = mesh.nodes[static_cast<std::size_t>(to)];
      sim::Vec3 middle = 0.5 * (a + b);
      const double near = 1e-6 * radius, r = std::hypot(middle.x, middle.y);
      if (std::hypot(a.x, a.y) > radius - near && std::hypot(b.x, b.y) > radius - near)
        middle.x *= radius / r, middle.y *= radius / r;  // the skin is round
      out.nodes.push_back(middle);
    }
    cells.push_back(all);
  }
  return out;
}

std::string ccx_taylor(const sim::SolidMesh& mesh, const std::vector<std::array<int, 20>>& cells, double dt) {
  std::ostringstream f;
  f.precision(9);
  f << "*NODE,NSET=ALL\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    f << n + 1 << ',' << 1e3 * mesh.nodes[n].x << ',' << 1e3 * mesh.nodes[n].y << ',' << 1e3 * mesh.nodes[n].z
      << '\n';
  f << "*ELEMENT,TYPE=C3D20R,ELSET=E\n";
  for (std::size_t e = 0; e < cells.size(); ++e) {
    f << e + 1;
    for (std::size_t k = 0; k < 20; ++k) f << (k == 15 ? ",\n" : ",") << cells[e][k] + 1;
    f << '\n';
  }
  const auto set = [&](const char* name, double sim::Vec3::*axis) {
    f << "*NSET,NSET=" << name << '\n';
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if (std::fabs(mesh.nodes[n].*axis) < 1e-9) f << n + 1 << ",\n";
  };
  set("X0", &sim::Vec3::x);
  set("Y0", &sim::Vec3::y);
  set("FOOT", &sim::Vec3::z);
  f << "*MATERIAL,NAME=CU\n*ELASTIC\n110000,.3\n*DENSITY\n8.97e-9\n*PLASTIC\n400,0\n900,5\n*SOLID "
       "SECTION,ELSET=E,MATERIAL=CU\n*BOUNDARY\nX0,1\nY0,2\nFOOT,3\n*INITIAL "
       "CONDITIONS,TYPE=VELOCITY\nALL,3,-227000\n"
       "*STEP,NLGEOM,INC=1000000\n*DYNAMIC,ALPHA=-0.05\n"
    << dt << ",80e-6,1e-11," << dt
    << "\n*NODE PRINT,NSET=ALL,FREQUENCY=1000000\nU\n*EL PRINT,ELSET=E,FREQUENCY=1000000\nPEEQ\n*END "
       "STEP\n";
  return f.str();
}

CcxTaylor read_taylor(const sim::SolidMesh& mesh, const CcxRun& run) {
  CcxTaylor r;
  r.cpu = run.cpu;
  std::istringstream in(run.dat);
  std::string line;
  bool moved = false;
  double low = 1e300, high = -1e300;
  std::size_t seen = 0;
  while (std::getline(in, line)) {
    if (line.find("displacements") != std::string::npos) {  // the last increment counts
      moved = true;
      low = 1e300, high = -1e300, r.radius = r.plastic_strain = 0, seen = 0;
    }
    if (line.find("plastic") != std::string::npos) moved = false;
    std::istringstream numbers(line);
    double a = 0, b = 0, c = 0, d = 0;
    if (moved && numbers >> a >> b >> c >> d) {
      const sim::Vec3 p = mesh.nodes.at(static_cast<std::size_t>(a) - 1) + 1e-3 * sim::Vec3{b, c, d};
      low = std::min(low, p.z);
      high = std::max(high, p.z);
      r.radius = std::max(r.radius, std::hypot(p.x, p.y));
      ++seen;
    } else if (!moved && numbers >> a >> b >> c) {
      r.plastic_strain = std::max(r.plastic_strain, c);
    }
  }
  r.length = high - low;
  r.ran = run.ran && seen == mesh.nodes.size() && r.length < 0.1 && r.radius < 0.1;
  return r;
}

}  // namespace powbench::bench
