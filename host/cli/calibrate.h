#pragma once

#include <array>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

#include "rigs/calibration_rows.h"
#include "rigs/iio_link.h"

/// The walk through a calibration: what is asked, what is read, what follows, and what is stored.

namespace powbench::host {

/// Mean of the counts and their scatter.
struct MeanCounts {
  double mean = 0.0, deviation = 0.0;
};

/// Two known quantities x (SI) at one input and the counts n that it showed:
/// scale = (x2 - x1) / (n2 - n1), zero = n1 - x1 / scale. Throws BadInput when the counts lie too close together.
struct Line {
  double si_per_count = 0.0, zero = 0.0;
};
Line line_through(double x1, const MeanCounts& n1, double x2, const MeanCounts& n2);

/// The rig's own words on its channels, as rows of a calibration.
rigs::Calibrations rows_of(rigs::IioLink&);

/// A question to the person; nothing: no more answers.
using Ask = std::function<std::optional<std::string>(const std::string& question)>;

struct Walk {
  rigs::Calibrations rows;
  double switch_delay = 0.0;  ///< s
  std::string report;         ///< TOML: every channel's points, counts, gain before and after
  std::array<bool, channel_count> measured{};  ///< channels that were answered; the others are kept
};

/// Asks for two points of each electrical input and of the laser, for the films' sensitivities and for the switch's
/// delay; an empty answer keeps what is there. `token`: of the lease that is held. Where the rig has a programmable
/// source it is told to apply the quantity, else the person is.
Walk walk(rigs::IioLink&, const std::string& token, const Ask&);

/// Writes the rows and the certificate to the rig and waits until it says that they are stored. `day` as 20301231.
/// Throws RigError with the rig's sentence.
void store(rigs::IioLink&, const std::string& token, const Walk&, const std::string& id, std::uint32_t date,
           std::uint32_t expires);

}  // namespace powbench::host
