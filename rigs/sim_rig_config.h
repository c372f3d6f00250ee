#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/channel_set.h"
#include "core/channels.h"
#include "core/units.h"
#include "rigs/fault_line.h"
#include "sim/supply/supply_modes.h"

/// Everything a rig file can say about the simulated rig. Plain values in SI; defaults are a plausible bench.

namespace powbench::rigs {

/// One structural mode of the frame: rings after the core impact and couples into the force channels and the
/// base.
struct RingMode {
  double hertz = 0.0;    ///< natural frequency
  double damping = 0.0;  ///< damping ratio
  double gain_a = 0.0;   ///< N at film A per N of static core-stop force
  double gain_b = 0.0;   ///< N at film B per N of static core-stop force
};

/// What a calibration has to find: how the inputs differ from their nominal scales.
struct FrontEndConfig {
  std::array<double, channel_count> gain{};  ///< relative error: more counts than the scale says
  std::array<double, channel_count> zero{};  ///< counts at zero
};

/// The virtual sensor chain: what the plant does -> what the converter gives.
struct SensorConfig {
  ChannelSet channels =
      all_channels;  ///< converted at all; of the others nothing is computed, their counts stay 0

  // force: PVDF film -> charge amplifier -> converter
  double charge_sensitivity = 21e-12;  ///< C/N, effective d33 of the glued film
  double film_area = 25e-6;            ///< m2
  double force_full_scale = 250.0;     ///< N at +-5 V: beyond it the channel saturates
  double corner_hertz = 0.5;           ///< Hz: low corner of the charge amplifier (droop)
  double bandwidth_hertz = 30e3;       ///< Hz: two-pole Butterworth low-pass of the amplifier
  double force_noise = 0.03;           ///< N rms per sample
  double force_hum = 0.05;        ///< N rms of mains-frequency pick-up; a third of it at the third harmonic
  double force_crosstalk = 0.02;  ///< share of each film's force that the other one shows
  double coil_pickup = 0.05;      ///< N per 325 V of coil voltage, through stray capacitance
  std::array<RingMode, 3> ring{
      {{1700.0, 0.012, 3.0e-4, 2.2e-4}, {3100.0, 0.015, 4.0e-4, -3.5e-4}, {6800.0, 0.020, 1.2e-4, 1.6e-4}}};
  bool film_a_inverted = false;  ///< film A glued upside down

  // travel: laser triangulation
  double laser_rate = 49e3;      ///< Hz: the laser's own measuring rate; held between its samples
  double laser_delay = 82e-6;    ///< s: transport delay, a calibrated setting
  double laser_noise = 0.7e-6;   ///< m rms
  double laser_scale = 0.25e-6;  ///< m per count

  // electrical channels
  double current_full_scale = 2.0;        ///< A
  double current_noise = 0.3e-3;          ///< A rms
  double voltage_full_scale = 600.0;      ///< V
  double voltage_noise = 0.15;            ///< V rms
  double contact_open_voltage = 6.0;      ///< V across the open pole (10 mA through the closed one)
  double contact_full_scale = 10.0;       ///< V
  double contact_noise = 5e-3;            ///< V rms
  double accelerometer_full_scale = 2e5;  ///< m/s2 at +-10 V on the auxiliary input
  double accelerometer_noise = 20.0;      ///< m/s2 rms
};

/// How the device on the rig differs from its specimen file: fixed for the device, in percent or metres.
struct DeviceConfig {
  double coil_resistance = 0.0;  ///< relative
  double return_rate = 0.0;      ///< relative
  double friction = 0.0;         ///< relative
  double gap = 0.0;              ///< m, added to the contact gap
  double tilt_gap = 0.0;         ///< m, break B opens this much wider than break A
  double supply = 0.0;           ///< relative error of the source's calibration
};

/// Shot-to-shot scatter: standard deviations of normal draws, seeded by the shot.
struct ScatterConfig {
  double supply = 0.0;            ///< relative
  double coil_temperature = 0.0;  ///< K
  double friction = 0.0;          ///< relative
  double gap = 0.0;               ///< m
};

/// Faults on request, so that error paths can be tested. All off by default.
struct FaultConfig {
  std::int32_t lost_samples = 0;  ///< conversions lost once, 5 ms after switch-on
  bool relay_welded = false;      ///< the safety relay does not open any more once it was closed
  bool relay_open = false;        ///< the safety relay does not close
  bool coil_open = false;         ///< coil circuit interrupted: no current flows
  bool laser_dropout = false;     ///< laser reads its last value for 2 ms around the core impact
  double mains_dip = 1.0;         ///< factor on the supply from the moment the rig is armed
  BadLine line;                   ///< between the rig and its clients
};

struct SimRigConfig {
  std::string name = "simulated contactor bench";
  std::string serial = "SIM-0001";
  double sample_rate = 100e3;          ///< Hz, all channels
  double record_length = 0.140;        ///< s, pre-trigger included
  double pretrigger = 0.040;           ///< s
  double integrator_tolerance = 1e-6;  ///< of the plant
  SensorConfig sensors;
  DeviceConfig device;
  ScatterConfig scatter;
  FrontEndConfig front_end;
  FaultConfig faults;
  sim::Supply
      supply;  ///< source impedance, harmonics, dips, switch; volts, hertz and phase come with the shot
};

}  // namespace powbench::rigs
