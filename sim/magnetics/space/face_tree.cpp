#include "sim/magnetics/space/face_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace powbench::sim {
namespace {

double length(const Vec3& v) {
  return std::sqrt(dot(v, v));
}

double to_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double square = dot(along, along);
  const double t = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
  return length(p - a - t * along);
}

double outside(const Vec3& low, const Vec3& high, const Vec3& p) {
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double away = std::max({low[k] - p[k], p[k] - high[k], 0.0});
    square += away * away;
  }
  return std::sqrt(square);
}

}  // namespace

double distance(const Face3& f, const Vec3& p) {
  const Vec3 normal = cross(f[1] - f[0], f[2] - f[0]);
  const double area = length(normal);
  bool above = area > 0;  // the foot of the perpendicular lies within
  for (std::size_t k = 0; k < 3 && above; ++k) {
    const Vec3 edge = f[(k + 1) % 3] - f[k];
    above = dot(cross(edge, p - f[k]), normal) >= 0;
  }
  if (above) return std::fabs(dot(p - f[0], normal)) / area;
  return std::min({to_segment(f[0], f[1], p), to_segment(f[1], f[2], p), to_segment(f[2], f[0], p)});
}

FaceTree::FaceTree(std::vector<Face3> faces) : faces_(std::move(faces)) {
  if (!faces_.empty()) build(0, static_cast<int>(faces_.size()));
}

int FaceTree::build(int first, int last) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  Box box{{infinite, infinite, infinite}, {-infinite, -infinite, -infinite}, first, last - first, -1};
  for (int f = first; f < last; ++f)
    for (const Vec3& v : faces_[static_cast<std::size_t>(f)])
      for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], v[k]);
        box.high[k] = std::max(box.high[k], v[k]);
      }
  const int number = static_cast<int>(boxes_.size());
  boxes_.push_back(box);
  constexpr int most = 4;
  if (last - first <= most) return number;
  std::size_t widest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (box.high[k] - box.low[k] > box.high[widest] - box.low[widest]) widest = k;
  const int middle = (first + last) / 2;
  std::nth_element(faces_.begin() + first, faces_.begin() + middle, faces_.begin() + last,
                   [&](const Face3& a, const Face3& b) {
                     return a[0][widest] + a[1][widest] + a[2][widest] <
                            b[0][widest] + b[1][widest] + b[2][widest];
                   });
  build(first, middle);
  const int right = build(middle, last);
  boxes_[static_cast<std::size_t>(number)].right = right;
  return number;
}

double FaceTree::nearest(const Vec3& p) const {
  double least = std::numeric_limits<double>::infinity();
  if (!boxes_.empty()) search(0, p, least);
  return least;
}

void FaceTree::search(int number, const Vec3& p, double& least) const {
  const Box& box = boxes_[static_cast<std::size_t>(number)];
  if (outside(box.low, box.high, p) >= least) return;
  if (box.right < 0) {
    for (int f = box.first; f < box.first + box.count; ++f)
      least = std::min(least, distance(faces_[static_cast<std::size_t>(f)], p));
    return;
  }
  const auto away = [&](int child) {
    const Box& b = boxes_[static_cast<std::size_t>(child)];
    return outside(b.low, b.high, p);
  };
  int near = number + 1, far = box.right;
  if (away(far) < away(near)) std::swap(near, far);
  search(near, p, least);
  search(far, p, least);
}

}  // namespace powbench::sim
