#pragma once

#include <functional>
#include <span>
#include <stdexcept>
#include <string>

#include "host/run/campaign.h"
#include "host/store/points.h"
#include "rigs/sim_rig_config.h"
#include "rigs/simulated_record.h"
#include "sim/specimen/specimen.h"

/// Simulates a campaign under the conditions that its closings really had.

namespace powbench::host {

/// How one closing becomes a record; the plant of the simulated rig unless a scene says otherwise.
using RecordMaker =
    std::function<rigs::SimulatedClosing(const sim::Specimen&, const Conditions&, const rigs::SimRigConfig&)>;

/// The conditions of the closings at one angle: means over the measured ones where those are known, else as asked.
/// Standard uncertainties of the means; 0: as asked, nothing was measured.
struct ClosingInputs {
  Conditions conditions;
  double u_angle = 0;    ///< rad
  double u_volts = 0;    ///< V, scale of the channel included
  double u_hertz = 0;    ///< Hz
  double u_ambient = 0;  ///< K, of the coil's temperature
};

/// `measured`: events of the closings commanded to `asked`. `options` brings the uncertainty of the voltage's scale
/// and of the coil's temperature.
ClosingInputs inputs_of(const Conditions& asked, std::span<const Events> measured, const RunOptions& options);

/// Of a simulation that was made as asked: `conditions` are those, and what the closings really had differently is
/// part of u, as an error that is not corrected: u^2 = u_mean^2 + (mean - asked)^2.
ClosingInputs inputs_as_asked(const Conditions& asked, std::span<const Events> measured,
                              const RunOptions& options);

/// A closing and the number of its shot in the plan's order.
struct NumberedClosing {
  int number = 0;
  Events events;
};

/// Closings that are simulated each by itself, at the conditions that it reached; of a longer campaign none is.
inline constexpr std::size_t most_alone = 500;

/// Ends a computation whose result nobody waits for any more.
struct NotNeeded : std::runtime_error {
  NotNeeded() : std::runtime_error("no longer needed") {}
};

/// Standard uncertainty (SI) of each quantity, by symbol, from those of the inputs: u^2 = sum ((q+ - q0)^2 + (q- -
/// q0)^2) / 2 over the inputs, each moved by its u (or by what a sample shows, scaled), of the plant through the
/// rig's sensors: (dq/dx u_x)^2 where q is a straight line, and a bounce more or less close by counts. NaN: a
/// quantity that does not exist at all three. Likewise each smooth curve (travel, coil current) as means over 0.1 ms
/// up to 60 ms. `alone`: closings of which it is told too what their own conditions add; a simulation more for each.
/// `over`: asked before each simulation; true ends it with NotNeeded.
InputSpread input_uncertainty(const ClosingInputs&, const sim::Specimen&, const rigs::SimRigConfig&,
                              const RunOptions&, std::span<const NumberedClosing> alone = {},
                              const std::function<bool()>& over = {});

/// Stores a simulated closing with its record and events; the number of its shot.
std::int64_t keep_simulated(Store&, StoredShot, const Record&, const Events&, const RunOptions&);

/// How a campaign is simulated.
struct Simulation {
  std::string
      made_with;  ///< everything but the conditions that a record depends on, as text: model, specimen, sensors
  RecordMaker make = rigs::simulate_record;
  bool nominal = false;  ///< as the plan asks, whatever the closings really had
  int threads = 1;
  Points* points = nullptr;  ///< of the angles, those that are known are not simulated; nullptr: none
};

/// What became of the angles of a plan.
struct SimulatedCount {
  std::size_t stored = 0;   ///< simulated now
  std::size_t renewed = 0;  ///< of these: in the place of a simulation whose inputs have changed since
  std::size_t kept = 0;     ///< stored before from the same inputs
  /// States of the magnet that the simulations made now looked at, where they had fields of their own; of these outside
  /// of what the fields were made from.
  std::int64_t field_states = 0, field_beyond = 0;
  std::size_t beyond_fields = 0;  ///< simulations, also kept ones, with more than `few_beyond` of such states
};

/// Share of the states outside of what the fields were made from, above which no time is one to rely on.
inline constexpr double few_beyond = 0.01;

/// One closing for each angle of the plan, stored with record and events. Where the campaign has measured closings
/// and not `nominal`: under their conditions, with its uncertainty. Each is stored as soon as those of the angles
/// before it are. Its reason tells its conditions and the hash of all that went in; one with another hash is
/// simulated anew, and stays as an earlier attempt. An angle that fails is thrown at the end, the others are stored.
/// Where the points are a part (Points::part) they are all that is written: the store is read for what was measured,
/// and a campaign that is not there has no measured closings.
SimulatedCount simulate_campaign(Store&, std::int64_t campaign, std::span<const PlannedShot>,
                                 const sim::Specimen&, const rigs::SimRigConfig&, const RunOptions&,
                                 Progress&, const Simulation& = {});

}  // namespace powbench::host
