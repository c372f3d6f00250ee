#pragma once

#include <vector>

#include "sim/vec.h"

/// Forces on few of many nodes: those of contacts, springs and loads.

namespace powbench::sim {

class NodeForces {
 public:
  explicit NodeForces(std::size_t nodes) : force_(nodes), marked_(nodes, 0) {}

  void add(int node, const Vec3& f) {
    const auto n = static_cast<std::size_t>(node);
    if (!marked_[n]) {
      marked_[n] = 1;
      touched_.push_back(node);
    }
    force_[n] += f;
  }

  const std::vector<int>& touched() const { return touched_; }
  const Vec3& operator[](int node) const { return force_[static_cast<std::size_t>(node)]; }

  void clear() {
    for (const int n : touched_) {
      force_[static_cast<std::size_t>(n)] = {};
      marked_[static_cast<std::size_t>(n)] = 0;
    }
    touched_.clear();
  }

 private:
  std::vector<Vec3> force_;
  std::vector<char> marked_;
  std::vector<int> touched_;
};

/// Where the nodes are and how fast, 4 numbers a node.
struct NodeView {
  const std::vector<Vec3>* reference = nullptr;  ///< m
  const double* u = nullptr;                     ///< m
  const double* v = nullptr;                     ///< m/s, half a step ago

  Vec3 displacement(int n) const { return take(u, n); }
  Vec3 place(int n) const { return (*reference)[static_cast<std::size_t>(n)] + take(u, n); }
  Vec3 velocity(int n) const { return take(v, n); }

 private:
  static Vec3 take(const double* a, int n) {
    const double* p = a + 4 * static_cast<std::size_t>(n);
    return {p[0], p[1], p[2]};
  }
};

}  // namespace powbench::sim
