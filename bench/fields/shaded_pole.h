#pragma once

#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/magnet_field.h"

/// The closed magnet at the mains with linear steel: by how much the flux inside the shading ring lags, and what pull
/// is left at the worst moment. Once by phasors, with the ring as a massive conductor in which eddies may flow, and
/// in time with the ring as one turn of a circuit.

namespace powbench::bench {

struct ShadedPole {
  double lag = 0;         ///< deg, of the flux inside the ring behind the rest, phi_s behind psi / N - phi_s
  double least_pull = 0;  ///< N
  double mean_pull = 0;   ///< N
};

/// The case: the specimen's shape, mu_r 2000, a copper ring whose ends conduct perfectly, 230 V, 50 Hz, 250 ohm.
struct ShadedCase {
  sim::MagnetDesign design;
  double hertz = 50, volts = 230 * 1.4142135623730951, resistance = 250;
  double copper = 5.8e7;  ///< S/m
  sim::FieldOptions options;
  ShadedCase();
};

/// Resistance of both rings in series, ohm: their sections in the mesh over the length of the stack.
double ring_resistance(const ShadedCase&);

/// (K + j w M) a = c I + sigma g: coil in a circuit, both sides of the ring at one voltage a metre without net current.
ShadedPole by_phasors(const ShadedCase&);

/// At rest, `periods` long, its step a whole fraction of the period.
sim::TransientSetup shaded_setup(const ShadedCase&, double step, int periods);

/// From the last period of a transient of a coil of so many turns.
ShadedPole by_time(double hertz, double turns, const sim::TransientSetup&, const sim::TransientResult&);

}  // namespace powbench::bench
