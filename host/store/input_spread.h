#pragma once

#include <map>
#include <string>
#include <vector>

namespace powbench::host {

/// Standard uncertainty of a simulated curve, SI: value i holds from t0 + i dt to t0 + (i + 1) dt after switch-on.
/// NaN: not known there.
struct CurveSpread {
  std::string channel;  ///< name of the channel table
  double t0 = 0;        ///< s
  double dt = 0;        ///< s, > 0
  std::vector<float> u;
};

/// What the uncertainties of its inputs leave open in a simulated closing.
struct InputSpread {
  std::map<std::string, double> u;  ///< standard uncertainty of each quantity, SI, by symbol; NaN: not known
  std::vector<CurveSpread> curves = {};  ///< of the smooth channels
  /// What the conditions that a closing reached itself add to each quantity of the simulation of its angle, SI, by
  /// the number of the closing, then symbol; NaN: the quantity does not exist in either. Empty: not simulated.
  std::map<int, std::map<std::string, double>> moved = {};
  bool empty() const { return u.empty(); }
};

}  // namespace powbench::host
