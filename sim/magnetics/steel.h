#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// Soft magnetic steel without hysteresis, as one odd, strictly increasing curve H(B), C1, piecewise cubic:
///
///   0 < dH/dB <= 1/mu0 everywhere,   H = H_s + (B - B_s)/mu0 above saturation B_s (4 T and beyond).
///
/// H(B) and not the reluctivity over B^2 is interpolated: then the stored energy w(B) = int_0^B H dB is convex and
/// Newton's matrix is positive definite for every field. T, A/m, J/m3.

namespace powbench::sim {

/// One row of a measured curve.
struct BhRow {
  double b = 0;  ///< T
  double h = 0;  ///< A/m
};

/// A point of the curve, for b >= 0.
struct SteelPoint {
  double h = 0;       ///< A/m
  double dh_db = 0;   ///< m/H
  double energy = 0;  ///< J/m3
};

class Steel {
 public:
  /// Monotone cubic through the rows (the origin is added where it is missing). Above the last row
  /// B = B_e + mu0 x + k x / (1 + x / h0) with x = H - H_e, the law of Froehlich and Kennelly at the rate of the last
  /// rows, until the slope is 1/mu0. Throws std::invalid_argument that names the row: fewer than 3 rows, B or H not
  /// increasing, a slope above 1/mu0, or a slope that falls by more than 40 % after it has risen (noise).
  static Steel table(std::string name, std::vector<BhRow> rows);

  /// A smooth law h(b) with derivative dh_db(b), up to the field where the derivative reaches 1/mu0; straight above.
  static Steel law(std::string name, const std::function<double(double)>& h,
                   const std::function<double(double)>& dh_db);

  /// H = linear B + power B^exponent, the law of `Magnet`. Coefficients >= 0, linear > 0, exponent > 1.
  static Steel power_law(double linear, double power, double exponent);

  /// H = B / (mu0 relative_permeability), relative_permeability >= 1.
  static Steel linear(double relative_permeability);

  /// A stack of laminations with this share of iron in (0, 1], seen along the sheets: the mean flux density at equal H,
  /// B = share B_iron(H) + (1 - share) mu0 H.
  Steel stacked(double share) const;

  double h(double b) const;
  double dh_db(double b) const;
  double energy(double b) const;  ///< w(B), J/m3

  /// The same for b >= 0, all at once: the inner loop of the finite elements.
  SteelPoint at(double b) const;

  const std::string& name() const { return name_; }
  double data_end() const { return data_end_; }             ///< T: above it the curve is extrapolated
  double straight_from() const { return knots_.back().b; }  ///< T: above it the slope is 1/mu0
  double peak_permeability() const;                         ///< largest B / (mu0 H)

  /// The curve as numbers: equal steels have equal knots. For hashing and plotting.
  struct Knot {
    double b, h, slope, energy;
  };
  const std::vector<Knot>& knots() const { return knots_; }

 private:
  Steel(std::string name, std::vector<Knot> knots, double data_end, double last_slope);

  /// One cubic: H = h + t (slope + t (c2 + t c3)) with t = B - b, up to B = end.
  struct Piece {
    double b, end, h, slope, c2, c3, energy, third_c2, quarter_c3;
  };

  std::string name_;
  std::vector<Knot> knots_;    ///< from b = 0; energies are those of the cubics
  std::vector<Piece> pieces_;  ///< between the knots
  std::vector<int> bin_;       ///< first knot interval of each bin of B
  double bins_per_tesla_ = 0;
  double data_end_ = 0;
  double last_slope_ = 0;
};

/// A built-in steel; `builtin_steel_source` says of each where its numbers come from. Throws std::invalid_argument
/// that lists the names for another one.
Steel builtin_steel(std::string_view name);

std::vector<std::string> builtin_steel_names();

/// What was measured and by whom, or the law; one line for people.
std::string builtin_steel_source(std::string_view name);

}  // namespace powbench::sim
