#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dsp/contacts/joint_fit.h"

/// The joint fit as numbers: rows, and the derivative of the model with respect to each parameter. No solver here.

namespace powbench::dsp {

/// Samples averaged to rows of `JointInput::row`.
struct JointRows {
  std::vector<double> t, y;       ///< (n) middle of the row, s; mean, N
  std::vector<double> weight;     ///< (n) 1 / standard deviation; 0 = not used
  std::size_t block = 1;          ///< samples per row
  double sample = 0.0, dt = 0.0;  ///< s per sample and per row
  std::size_t size() const { return t.size(); }
  std::size_t at(double time) const;  ///< first row whose middle is at or after `time`
};

/// Columns that share their rows: one contact, the settled contact, or the whole ring.
struct JointBlock {
  enum class Kind : std::uint8_t { pulse, rise, tail, ring, pedestal };
  Kind kind{};
  std::size_t which = 0;              ///< index of the pulse
  std::size_t first = 0, last = 0;    ///< rows first .. last - 1
  std::size_t column = 0, count = 0;  ///< columns of the whole system
};

struct JointSystem {
  std::vector<JointBlock> blocks;
  std::size_t columns = 0;
  std::vector<double>
      jacobian;  ///< (n, columns) column-major, weighted; a column means something on its block's rows
  std::vector<double> residual;  ///< (n) weighted: (model - y) weight
  std::vector<double> prior;     ///< (columns) 1 / sigma^2 of the weak knowledge of a parameter
  std::vector<double> pull;      ///< (columns) its gradient
  double cost = 0.0;             ///< sum of squares, priors included
};

JointRows joint_rows(const JointInput&, const JointModel&);

/// Sets the weights: samples outside contacts and within modelled ones count, each contact with its own misfit.
void weigh_rows(const JointInput&, const JointModel&, JointRows&);

/// Model, residual and (with `derivatives`) Jacobian. Linear amplitudes of the tail are parameters like any other.
void evaluate(const JointInput&, const JointModel&, const JointRows&, JointSystem&, bool derivatives);

/// Moves the model by a step of its parameters, each within its range.
JointModel moved(const JointModel&, const JointSystem&, const double* step, const ExtractOptions&);

/// Sum of squares of the weighted residual over the samples of one contact, and their number.
struct JointMisfit {
  double chi2 = 0.0, rows = 0.0;
};
JointMisfit misfit(const JointRows&, const JointSystem&, double t1, double t2);

/// The ring on rows i1 .. i2 - 1 as if it had always rung.
std::vector<double> ring_rows(const Ring&, const JointRows&, std::size_t i1, std::size_t i2);

/// Number of linear amplitudes of the settled force.
std::size_t settled_terms(const JointInput&, bool modelled);

inline constexpr double joint_head = 0.5e-3;  ///< s of closed time that decides whether the rise is modelled

}  // namespace powbench::dsp
