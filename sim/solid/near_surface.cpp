#include "sim/solid/near_surface.h"

#include <algorithm>

namespace powbench::sim {
namespace {

bool overlap(const Box& a, const Box& b) {
  for (int i = 0; i < 3; ++i)
    if (a.lo[i] > b.hi[i] || b.lo[i] > a.hi[i]) return false;
  return true;
}

std::vector<int> numbers_of(const std::vector<char>& taken) {
  std::vector<int> all;
  for (std::size_t k = 0; k < taken.size(); ++k)
    if (taken[k]) all.push_back(static_cast<int>(k));
  return all;
}

}  // namespace

double largest_between(const MovedBox& a, const MovedBox& b) {
  double square = 0;
  for (int i = 0; i < 3; ++i) {
    const double apart = std::max({0.0, a.hi[i] - b.lo[i], b.hi[i] - a.lo[i]});
    square += apart * apart;
  }
  constexpr double rounding = 1e-9;
  return (1 + rounding) * std::sqrt(square);
}

NearSurface::NearSurface(const SolidSurface& skin)
    : skin_(&skin),
      kernel_(&best_contact_kernel()),
      node_taken_(skin.nodes.size(), 0),
      face_taken_(skin.facets.size(), 0),
      edge_taken_(skin.edges.size(), 0) {}

Box NearSurface::box(const NodeView& view) const {
  Box all;
  for (const int n : skin_->nodes) all.include(view.place(n));
  return all;
}

double NearSurface::largest_margin(const NodeView& view, bool edges) const {
  double largest = 0;
  for (const Facet& f : skin_->facets)
    largest = std::max(largest, face_margin(facet_normal(powbench::sim::corners_now(view, f), f.corners())));
  if (edges)
    for (const SharpEdge& e : skin_->edges)
      largest = std::max(largest, 0.5 * norm(view.place(e.to) - view.place(e.from)));
  return largest;
}

void NearSurface::forget(const NodeView& view) {
  std::fill(node_taken_.begin(), node_taken_.end(), 0);
  std::fill(face_taken_.begin(), face_taken_.end(), 0);
  std::fill(edge_taken_.begin(), edge_taken_.end(), 0);
  before_.resize(4 * skin_->nodes.size());
  for (std::size_t k = 0; k < skin_->nodes.size(); ++k)
    std::copy_n(view.u + 4 * static_cast<std::size_t>(skin_->nodes[k]), 4,
                before_.begin() + 4 * static_cast<long>(k));
}

void NearSurface::reach_into(const Box& box, const NodeView& view) {
  for (std::size_t k = 0; k < node_taken_.size(); ++k) {
    Box here;
    here.include(view.place(skin_->nodes[k]));
    if (overlap(here, box)) node_taken_[k] = 1;
  }
  for (std::size_t f = 0; f < face_taken_.size(); ++f) {
    const Facet& facet = skin_->facets[f];
    Box here;
    for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k)
      here.include(view.place(facet.nodes[k]));
    if (!overlap(here, box)) continue;
    face_taken_[f] = 1;
    for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k)
      node_taken_[static_cast<std::size_t>(skin_->place_of(facet.nodes[k]))] = 1;
  }
  for (std::size_t e = 0; e < edge_taken_.size(); ++e) {
    const SharpEdge& edge = skin_->edges[e];
    Box here;
    here.include(view.place(edge.from));
    here.include(view.place(edge.to));
    if (!overlap(here, box)) continue;
    edge_taken_[e] = 1;
    for (const int n : {edge.from, edge.to}) node_taken_[static_cast<std::size_t>(skin_->place_of(n))] = 1;
  }
}

void NearSurface::settle(const NodeView& view) {
  near_nodes_ = numbers_of(node_taken_);
  near_faces_ = numbers_of(face_taken_);
  near_edges_ = numbers_of(edge_taken_);
  std::vector<int> number(skin_->nodes.size(), -1);
  mesh_nodes_.clear();
  reference_.assign(4 * near_nodes_.size(), 0.0);
  for (std::size_t k = 0; k < near_nodes_.size(); ++k) {
    const auto place = static_cast<std::size_t>(near_nodes_[k]);
    number[place] = static_cast<int>(k);
    mesh_nodes_.push_back(skin_->nodes[place]);
    const Vec3& r = (*view.reference)[static_cast<std::size_t>(skin_->nodes[place])];
    for (int i = 0; i < 3; ++i)
      reference_[4 * k + static_cast<std::size_t>(i)] = r[static_cast<std::size_t>(i)];
  }
  corners_.clear();
  four_sided_ = true;
  for (const int f : near_faces_) {
    const Facet& facet = skin_->facets[static_cast<std::size_t>(f)];
    for (std::size_t k = 0; k < 4; ++k) {
      const int node = facet.nodes[static_cast<int>(k) < facet.corners() ? k : 0];
      corners_.push_back(4 * number[static_cast<std::size_t>(skin_->place_of(node))]);
    }
    four_sided_ = four_sided_ && facet.corners() == 4;
  }
  places_.assign(4 * near_nodes_.size(), 0.0);
  follow(view);
}

void NearSurface::follow(const NodeView& view) {
  step_ = kernel_->place(reference_.data(), view.u, mesh_nodes_.data(), static_cast<int>(mesh_nodes_.size()),
                         places_.data());
}

MovedBox NearSurface::since_reach(const NodeView& view) const {
  return kernel_->moved(view.u, skin_->nodes.data(), static_cast<int>(skin_->nodes.size()), before_.data());
}

void NearSurface::note_search() {
  at_search_ = places_;
}

MovedBox NearSurface::since_search() const {
  MovedBox box;
  for (std::size_t k = 0; k < places_.size(); k += 4)
    for (std::size_t i = 0; i < 3; ++i) {
      const double moved = places_[k + i] - at_search_[k + i];
      box.lo[i] = std::min(box.lo[i], moved);
      box.hi[i] = std::max(box.hi[i], moved);
    }
  return box;
}

std::array<Vec3, 4> NearSurface::corners_now(std::size_t near_face) const {
  std::array<Vec3, 4> p{};
  const Facet& facet = skin_->facets[static_cast<std::size_t>(near_faces_[near_face])];
  for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k)
    p[k] = place(static_cast<std::size_t>(corners_[4 * near_face + k] / 4));
  return p;
}

}  // namespace powbench::sim
