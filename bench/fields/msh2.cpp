#include <fstream>
#include <stdexcept>
#include <unordered_map>

#include "bench/fields/peer_run.h"

namespace powbench::bench {

sim::Mesh read_msh2(const std::string& path, int rim) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  sim::Mesh m;
  std::unordered_map<long, int> vertex;
  constexpr int line = 1, triangle = 2;
  std::string word;
  while (in >> word) {
    if (word == "$Nodes") {
      std::size_t count = 0;
      in >> count;
      for (std::size_t k = 0; k < count; ++k) {
        long id = 0;
        double x = 0, y = 0, z = 0;
        in >> id >> x >> y >> z;
        vertex[id] = static_cast<int>(m.x.size());
        m.x.push_back(x);
        m.y.push_back(y);
        m.zero.push_back(0);
      }
    } else if (word == "$Elements") {
      std::size_t count = 0;
      in >> count;
      for (std::size_t k = 0; k < count; ++k) {
        long id = 0, node[3] = {};
        int type = 0, tags = 0, group = 0, other = 0;
        in >> id >> type >> tags >> group;
        for (int t = 1; t < tags; ++t) in >> other;
        const int nodes = type == line ? 2 : type == triangle ? 3 : 1;
        for (int n = 0; n < nodes; ++n) in >> node[n];
        if (type == line && group == rim)
          for (int n = 0; n < 2; ++n) m.zero[static_cast<std::size_t>(vertex[node[n]])] = 1;
        if (type != triangle) continue;
        m.triangle.push_back({vertex[node[0]], vertex[node[1]], vertex[node[2]]});
        m.region.push_back(group);
      }
    }
  }
  sim::check_mesh(m);
  return m;
}

}  // namespace powbench::bench
