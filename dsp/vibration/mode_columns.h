#pragma once

#include <complex>
#include <cstddef>

/// Columns that every fit of vibration and of a settling force is made of, eight rows at a time; the same on every
/// instruction set (dsp/signal/wide.h).

namespace powbench::dsp {

/// c[i] + i d[i] = gain exp(s (tau + i dt)), i < n; tau and dt in s, s in 1/s. By a recurrence that begins afresh every
/// 128 rows: relative error below 1e-13.
void mode_columns(std::complex<double> s, std::complex<double> gain, double tau, double dt, std::size_t n,
                  double* c, double* d);

/// Rows of a least-squares system that share a block of columns, n of them each.
struct BlockRows {
  std::size_t n;
  const double* t;       ///< s
  const double* weight;  ///< 1 / standard deviation
  double* model;         ///< the block's share is added here
};

/// A mode x c + y d with c, d = mode_columns: adds it to the model, turns c and d into the weighted columns by x and y
/// and fills those by angular frequency and decay. `reference`: s, where tau is 0.
void mode_block(const BlockRows&, double reference, double x, double y, double* c, double* d,
                double* by_frequency, double* by_decay);

inline constexpr std::size_t rise_terms = 6;  ///< polynomial of the settled force

/// The settling force (1 - fall) sum linear[k] T_k(2 tau / span - 1), tau = t - touch > 0, fall = exp(-tau / rise):
/// adds it to the model and, unless `columns` is null, fills the weighted columns by touch, ln rise and linear, each
/// `stride` after the one before.
void rise_block(const BlockRows&, double touch, double rise, double dt, double span, const double* linear,
                double* columns, std::size_t stride);

}  // namespace powbench::dsp
