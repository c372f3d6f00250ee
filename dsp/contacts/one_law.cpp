#include "dsp/contacts/one_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dsp/contacts/edge_laws.h"

namespace powbench::dsp {

namespace {

using Votes = std::array<double, edge_laws>;  // logarithms, the largest 0

constexpr double counts = 0.5;  // of the evidence of one edge
constexpr double most = 4;      // one edge speaks against a law by e^-4 at most
constexpr double other = 0.02;  // probability that an edge has a law of its own

Votes votes_of(const EdgeAnswer& e) {
  Votes v{};
  if (!e.known || !e.followed) return v;
  for (std::size_t l = 0; l < v.size(); ++l)
    v[l] = counts * std::log(std::max(e.law[l].weight, 1e-30) / law_prior(l));
  const double top = *std::max_element(v.begin(), v.end());
  for (double& x : v) x = std::max(x - top, -most);
  return v;
}

/// Weights of the laws times what `votes` say.
void weigh(EdgeAnswer& e, const Votes& votes) {
  const double top = *std::max_element(votes.begin(), votes.end());
  struct Moments {
    double weight = 0, sum = 0, squares = 0;
    void add(double w, const EdgeLaw& law) {
      weight += w, sum += w * law.mean, squares += w * (law.sigma * law.sigma + law.mean * law.mean);
    }
    double mean() const { return sum / weight; }
    double variance() const { return squares / weight - mean() * mean(); }
  } alone, together;
  for (std::size_t l = 0; l < edge_laws; ++l) {
    EdgeLaw& law = e.law[l];
    alone.add(law.weight, law);
    law.weight *= other + (1 - other) * std::exp(votes[l] - top);
    together.add(law.weight, law);
  }
  if (!(together.weight > 0)) return;
  const double shift = together.mean();
  e.time.value += shift;
  e.time.u = std::sqrt(std::max(e.time.u * e.time.u + together.variance() - alone.variance(), 0.0));
  for (EdgeLaw& law : e.law) law.weight /= together.weight, law.mean -= shift;
}

}  // namespace

void agree_on_law(std::span<EdgeAnswer* const> edges) {
  std::vector<Votes> votes;
  Votes all{};
  for (const EdgeAnswer* e : edges) {
    votes.push_back(votes_of(*e));
    for (std::size_t l = 0; l < all.size(); ++l) all[l] += votes.back()[l];
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!edges[i]->known) continue;
    Votes others = all;
    for (std::size_t l = 0; l < all.size(); ++l) others[l] -= votes[i][l];
    weigh(*edges[i], others);
  }
}

}  // namespace powbench::dsp
