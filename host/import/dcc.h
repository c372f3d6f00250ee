#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

/// Digital calibration certificates (PTB's DCC, XML with D-SI units), versions 2 and 3.

namespace powbench::host {

struct CertifiedQuantity {
  std::string name;  ///< as the certificate names it, in any one language; may be empty
  double value = std::numeric_limits<double>::quiet_NaN();  ///< in `unit`
  std::string unit;                                         ///< D-SI, such as `\newton\per\volt`
  double expanded =
      std::numeric_limits<double>::quiet_NaN();  ///< expanded uncertainty, in `unit`; NaN: not stated
  double coverage = std::numeric_limits<double>::quiet_NaN();  ///< its coverage factor k
};

struct Certificate {
  std::string id;         ///< uniqueIdentifier
  std::string performed;  ///< last day of the calibration, YYYY-MM-DD
  std::vector<CertifiedQuantity> quantities;
};

/// Throws BadInput, one sentence: no XML, no certificate, no identifier.
Certificate parse_dcc(std::string_view xml, const std::string& file);

struct CertifiedGain {
  double gain = std::numeric_limits<double>::quiet_NaN();      ///< SI unit of the channel per volt
  double expanded = std::numeric_limits<double>::quiet_NaN();  ///< of the gain, same unit
  double coverage = std::numeric_limits<double>::quiet_NaN();
};
/// The one quantity that is `unit` (N, m, A) per volt or volts per `unit`, with decimal prefixes. Throws BadInput
/// where there is none, or more than one: then none can be chosen.
CertifiedGain gain_of(const Certificate&, std::string_view unit, const std::string& file);

}  // namespace powbench::host
