#include "bench/fields/peer_run.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <utility>

namespace powbench::bench {

bool have_program(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

std::optional<double> cpu_of(const std::string& command) {
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    setenv("OMP_NUM_THREADS", "1", 1);
    execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  rusage use{};
  if (wait4(child, &status, 0, &use) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return std::nullopt;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
}

void polygon(std::ostream& out, int& point, int& curve, int loop, const std::vector<Corner>& corners) {
  const int first = point, first_curve = curve;
  for (const auto& c : corners)
    out << "Point(" << point++ << ") = {" << c.x << ", " << c.y << ", 0, " << c.size << "};\n";
  const int count = static_cast<int>(corners.size());
  for (int k = 0; k < count; ++k)
    out << "Line(" << curve++ << ") = {" << first + k << ", " << first + (k + 1) % count << "};\n";
  out << "Curve Loop(" << loop << ") = {" << first_curve << ":" << curve - 1 << "};\n";
}

void write_freefem_mesh(const std::string& path, const sim::Mesh& m) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : m.triangle)
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<std::pair<int, int>> rim;
  for (const auto& [ends, count] : edges)
    if (count == 1 && m.zero[static_cast<std::size_t>(ends.first)] &&
        m.zero[static_cast<std::size_t>(ends.second)])
      rim.push_back(ends);
  std::ofstream out(path);
  out.precision(17);
  out << m.x.size() << ' ' << m.triangle.size() << ' ' << rim.size() << '\n';
  for (std::size_t k = 0; k < m.x.size(); ++k) out << m.x[k] << ' ' << m.y[k] << " 0\n";
  for (std::size_t k = 0; k < m.triangle.size(); ++k)
    out << m.triangle[k][0] + 1 << ' ' << m.triangle[k][1] + 1 << ' ' << m.triangle[k][2] + 1 << ' '
        << m.region[k] << '\n';
  for (const auto& [a, b] : rim) out << a + 1 << ' ' << b + 1 << " 10\n";
}

}  // namespace powbench::bench
