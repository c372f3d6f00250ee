#pragma once

#include <cstddef>

#include "sim/solid/cell_lanes.h"
#include "sim/solid/contact_kernel.h"

/// Nodes in lanes, four or eight at a time. For the kernel sources only.

namespace powbench::sim {
namespace {

template <class V>
struct Vec3s {
  V x, y, z;
};

template <class V>
POWBENCH_INLINE Vec3s<V> operator+(const Vec3s<V>& a, const Vec3s<V>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class V>
POWBENCH_INLINE Vec3s<V> operator-(const Vec3s<V>& a, const Vec3s<V>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class V>
POWBENCH_INLINE Vec3s<V> operator*(const V& s, const Vec3s<V>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class V>
POWBENCH_INLINE V dot(const Vec3s<V>& a, const Vec3s<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
POWBENCH_INLINE Vec3s<V> cross(const Vec3s<V>& a, const Vec3s<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Mask, class V>
POWBENCH_INLINE Vec3s<V> choose(const Mask& m, const Vec3s<V>& a, const Vec3s<V>& b) {
  return {m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z};
}
template <class V>
POWBENCH_INLINE V root(const V& a) {
  V r;
  for (std::size_t l = 0; l < sizeof(V) / sizeof(double); ++l) r[l] = __builtin_sqrt(a[l]);
  return r;
}
template <class V>
POWBENCH_INLINE V larger(const V& a, const V& b) {
  return a > b ? a : b;
}
template <class V>
POWBENCH_INLINE V smaller(const V& a, const V& b) {
  return a < b ? a : b;
}
POWBENCH_INLINE D4 four(const double* p) {
  return *reinterpret_cast<const D4u*>(p);
}
POWBENCH_INLINE void store(double* p, const D4& a) {
  *reinterpret_cast<D4u*>(p) = a;
}
POWBENCH_INLINE void store(double* p, const D8& a) {
  *reinterpret_cast<D8u*>(p) = a;
}

/// x, y, z of 4 nodes.
POWBENCH_INLINE void gather(const double* p, const int* n, D4& x, D4& y, D4& z) {
  const D4 a = four(p + n[0]), b = four(p + n[1]), c = four(p + n[2]), d = four(p + n[3]);
  const D4 ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const D4 cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  x = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
  y = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
  z = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
}

/// `project` for four-sided faces: the sector of the fan that the node is in, and the nearest point of its triangle.
/// Lanes `first` and on of a block.
template <class V>
POWBENCH_INLINE void see_lanes(const SeeTask& task, const int* point, const int* face, int first,
                               SeenFaces& out) {
  constexpr double border = -1e-9;
  constexpr int width = sizeof(V) / sizeof(double);
  Vec3s<V> at, p[4];
  gather(task.points, point + first, at.x, at.y, at.z);
  for (int k = 0; k < 4; ++k) {
    int corner[width];
    for (int l = 0; l < width; ++l) corner[l] = task.corners[4 * face[first + l] + k];
    gather(task.places, corner, p[k].x, p[k].y, p[k].z);
  }
  const V zero{}, one = zero + 1.0, quarter = zero + 0.25;
  const Vec3s<V> middle = quarter * (p[0] + p[1] + p[2] + p[3]);
  const Vec3s<V> side = cross(at - middle, cross(p[2] - p[0], p[3] - p[1]));
  V turn[4];
  for (int k = 0; k < 4; ++k) turn[k] = dot(p[k] - middle, side);
  Vec3s<V> b = p[0], c = p[1];
  V sector = zero;
  for (int k = 3; k >= 0; --k) {
    const auto here = (turn[k] >= zero) & (turn[(k + 1) % 4] < zero);
    b = choose(here, p[k], b);
    c = choose(here, p[(k + 1) % 4], c);
    sector = here ? zero + static_cast<double>(k) : sector;
  }
  const Vec3s<V> to_b = b - middle, to_c = c - middle, r = at - middle;
  const Vec3s<V> n = cross(to_b, to_c);
  const V square = dot(n, n);
  const Vec3s<V> normal = (one / root(square)) * n;
  V w1 = dot(cross(r, to_c), n) / square, w2 = dot(cross(to_b, r), n) / square;
  V w0 = one - w1 - w2;
  const V gap = dot(r, normal);
  const auto outside = ~(w0 >= zero + border);
  V distance = larger(gap, -gap), aside = zero;
  bool any = false;
  for (int l = 0; l < width; ++l) any |= outside[l] != 0;
  if (any) {
    const Vec3s<V> along = c - b, from = at - b;
    V t = dot(from, along) / dot(along, along);
    t = t < zero ? zero : t;
    t = one < t ? one : t;
    const Vec3s<V> off = from - t * along;
    const V best = dot(off, off), left = best - gap * gap;
    distance = outside ? root(best) : distance;
    aside = outside ? root(larger(left, zero)) : aside;
    w0 = outside ? zero : w0;
    w1 = outside ? one - t : w1;
    w2 = outside ? t : w2;
  }
  const V deep = distance - task.limit, front = larger(larger(deep, gap), aside - task.ledge);
  store(out.way + first, larger(gap >= zero ? front : deep, zero));
  store(out.distance + first, distance);
  store(out.gap + first, gap);
  store(out.aside + first, aside);
  store(out.normal[0] + first, normal.x);
  store(out.normal[1] + first, normal.y);
  store(out.normal[2] + first, normal.z);
  store(out.inner + first, w0);
  const V share = quarter * w0;
  for (int k = 0; k < 4; ++k) {
    const auto is_b = sector == zero + static_cast<double>(k);
    const auto is_c = sector == zero + static_cast<double>((k + 3) % 4);
    store(out.weights[k] + first, is_b ? share + w1 : is_c ? share + w2 : share);
  }
}

template <class V>
void see_faces(const SeeTask& task) {
  constexpr int width = sizeof(V) / sizeof(double);
  for (int block = 0; block < task.blocks; ++block)
    for (int first = 0; first < contact_lanes; first += width)
      see_lanes<V>(task, task.point + contact_lanes * block, task.face + contact_lanes * block, first,
                   task.out[block]);
}

POWBENCH_INLINE void take(const double* p, D4& a) {
  a = *reinterpret_cast<const D4u*>(p);
}
POWBENCH_INLINE void take(const double* p, D8& a) {
  a = *reinterpret_cast<const D8u*>(p);
}
template <class V>
POWBENCH_INLINE V lanes_of(const double* p) {
  V a;
  take(p, a);
  return a;
}
template <class V>
POWBENCH_INLINE Vec3s<V> lanes_of(const double (&p)[3][contact_lanes], int first) {
  return {lanes_of<V>(p[0] + first), lanes_of<V>(p[1] + first), lanes_of<V>(p[2] + first)};
}
template <class V>
POWBENCH_INLINE void store(double (&p)[3][contact_lanes], int first, const Vec3s<V>& a) {
  store(p[0] + first, a.x);
  store(p[1] + first, a.y);
  store(p[2] + first, a.z);
}

template <class V>
void slip_nodes(const PressTask& task) {
  constexpr int width = sizeof(V) / sizeof(double);
  const V zero{}, dt = zero + task.dt;
  for (int block = 0; block < task.blocks; ++block)
    for (int first = 0; first < contact_lanes; first += width) {
      PressedNodes& p = task.nodes[block];
      Vec3s<V> relative, of;
      gather(task.v, p.node + first, relative.x, relative.y, relative.z);
      for (int k = 0; k < 4; ++k) {
        gather(task.v, p.corner[k] + first, of.x, of.y, of.z);
        relative = relative - lanes_of<V>(p.weights[k] + first) * of;
      }
      const auto normal = lanes_of<V>(p.normal, first), before = lanes_of<V>(p.before, first);
      const V approach = dot(relative, normal);
      const Vec3s<V> speed = relative - approach * normal;
      const Vec3s<V> trial =
          before - dot(before, normal) * normal - (lanes_of<V>(p.stiff + first) * dt) * speed;
      store(p.approach + first, approach);
      store(p.speed, first, speed);
      store(p.trial, first, trial);
      store(p.square + first, dot(trial, trial));
    }
}

/// Lost is what the bodies lost in this step less what the tangential spring gained.
template <class V>
void rub_nodes(const PressTask& task) {
  constexpr int width = sizeof(V) / sizeof(double);
  const V zero{}, half = zero + 0.5, back = zero + -0.5 * task.dt;
  for (int block = 0; block < task.blocks; ++block)
    for (int first = 0; first < contact_lanes; first += width) {
      PressedNodes& p = task.nodes[block];
      const auto before = lanes_of<V>(p.before, first), trial = lanes_of<V>(p.trial, first);
      const V stiff = lanes_of<V>(p.stiff + first), now = dot(trial, trial);
      const V work = back * dot(before + trial, lanes_of<V>(p.speed, first));
      const V gained = half * (now - dot(before, before)) / stiff;
      store(p.lost + first, work - gained);
      store(p.stored + first, half * now / stiff);
      store(p.force, first, lanes_of<V>(p.normal_force + first) * lanes_of<V>(p.normal, first) + trial);
    }
}

/// Boxes of four rows of numbers, so that none waits for the one before.
struct FourBoxes {
  D4 lo[4], hi[4];

  POWBENCH_INLINE FourBoxes() {
    for (int i = 0; i < 4; ++i) {
      lo[i] = D4{} + 1e300;
      hi[i] = D4{} - 1e300;
    }
  }
  POWBENCH_INLINE void include(int i, const D4& a) {
    lo[i] = smaller(a, lo[i]);
    hi[i] = larger(a, hi[i]);
  }
  POWBENCH_INLINE MovedBox all() const {
    MovedBox box;
    store(box.lo, smaller(smaller(lo[0], lo[1]), smaller(lo[2], lo[3])));
    store(box.hi, larger(larger(hi[0], hi[1]), larger(hi[2], hi[3])));
    return box;
  }
};

MovedBox place_nodes(const double* reference, const double* u, const int* node, int count, double* x) {
  FourBoxes boxes;
  const auto one = [&](int k, int i) __attribute__((always_inline)) {
    const D4 now = four(reference + 4 * k) + four(u + 4 * static_cast<long>(node[k]));
    boxes.include(i, now - four(x + 4 * k));
    store(x + 4 * k, now);
  };
  int k = 0;
  for (; k + 4 <= count; k += 4)
    for (int i = 0; i < 4; ++i) one(k + i, i);
  for (; k < count; ++k) one(k, 0);
  return boxes.all();
}

MovedBox moved_nodes(const double* u, const int* node, int count, const double* before) {
  FourBoxes boxes;
  const auto one = [&](int k, int i) __attribute__((always_inline)) {
    boxes.include(i, four(u + 4 * static_cast<long>(node[k])) - four(before + 4 * k));
  };
  int k = 0;
  for (; k + 4 <= count; k += 4)
    for (int i = 0; i < 4; ++i) one(k + i, i);
  for (; k < count; ++k) one(k, 0);
  return boxes.all();
}

}  // namespace

#define POWBENCH_CONTACT_KERNEL(function, title, V)                                  \
  const ContactKernel& function() {                                                  \
    static constexpr ContactKernel kernel{title,        see_faces<V>, slip_nodes<V>, \
                                          rub_nodes<V>, place_nodes,  moved_nodes};  \
    return kernel;                                                                   \
  }

}  // namespace powbench::sim
