#include "sim/specimen/specimen_fields.h"

#include <array>
#include <type_traits>

#include "sim/magnetics/magnet_shape_fields.h"

namespace powbench::sim {
namespace {

// Columns: section | member | key | SI per unit of the key | lowest | highest | meaning
#define POWBENCH_SPECIMEN(X)                                                                                 \
  X(coil, turns, "turns", 1, 1, 1e5, "N, turns of the coil")                                                 \
  X(coil, resistance, "resistance_ohm", 1, 1e-3, 1e6, "R, coil resistance at 20 degC")                       \
  X(coil, leakage, "leakage_H", 1, 0, 1e3, "L_leak, leakage inductance")                                     \
  X(coil, temperature_coefficient, "temperature_coefficient_per_K", 1, -0.01, 0.02,                          \
    "alpha of the resistance")                                                                               \
  X(magnet, pole_area, "pole_area_mm2", 1e-6, 1, 1e5,                                                        \
    "A_c, centre pole; both outer poles together the same")                                                  \
  X(magnet, iron_length, "iron_length_mm", 1e-3, 1, 2000, "l_fe, length of the iron path")                   \
  X(magnet, residual_gap, "residual_gap_um", 1e-6, 0.1, 1000, "d_min, air gap per pole when closed")         \
  X(magnet, fringing, "fringing", 1, 0, 10, "c, A_eff = A_c (1 + c gap / sqrt A_c)")                         \
  X(magnet, shaded_share, "shaded_share", 1, 0, 0.95,                                                        \
    "a_2, share of the outer poles inside the shading ring")                                                 \
  X(magnet, ring_resistance, "ring_resistance_ohm", 1, 1e-12, 1e12, "R_sh, shading ring, one turn")          \
  X(magnet, bh_linear, "bh_linear_A_per_m_per_T", 1, 0.1, 1e6, "a of H = a B + b B^n")                       \
  X(magnet, bh_power, "bh_power_A_per_m", 1, 0, 1e6, "b of H = a B + b B^n, at 1 T")                         \
  X(magnet, bh_exponent, "bh_exponent", 1, 1, 40, "n of H = a B + b B^n")                                    \
  X(magnet, coercive_field, "coercive_field_A_per_m", 1, 0, 1e4, "H_c of the iron; 0: no remanence")         \
  X(magnet, coercive_span, "coercive_span_T", 1, 1e-4, 2, "B_c, in which the coercive field turns over")     \
  X(magnet, remanence, "remanence", 1, -1, 1, "left by the last switch-off, of the largest there is")        \
  X(core, mass, "mass_g", 1e-3, 5, 2e4, "M, armature and holder")                                            \
  X(core, travel, "travel_mm", 1e-3, 0.1, 50, "contact gap plus overtravel")                                 \
  X(core, return_preload, "return_preload_N", 1, 0, 1e4, "F_r0, return spring, open")                        \
  X(core, return_rate, "return_rate_N_per_m", 1, 0, 1e7, "k_r, return spring")                               \
  X(core, friction, "friction_N", 1, 0, 1e3, "F_f, Coulomb friction of the holder")                          \
  X(core, stop_stiffness, "stop_stiffness_N_per_m", 1, 1e3, 1e12, "k_core, pole faces pressed together")     \
  X(core, stop_restitution, "stop_restitution", 1, 1e-3, 1, "e_core, rebound of a drop test of the stop")    \
  X(core, stop_exponent, "stop_exponent", 1, 1, 2,                                                           \
    "n: 1 spring and damper; 1.5 Hertz, 2: Hunt and Crossley's damping")                                     \
  X(core, stop_depth, "stop_depth_um", 1e-6, 0.1, 1000,                                                      \
    "d_0, with n above 1: depth at which F = k_core d_0")                                                    \
  X(core, stop_speed, "stop_speed_m_per_s", 1, 0.01, 20, "with n above 1: speed of the drop test of e_core") \
  X(core, tilt_inertia, "tilt_inertia_g_mm2", 1e-9, 0, 1e9,                                                  \
    "I, core and holder against tilt; 0: guided without play")                                               \
  X(core, tilt_hertz, "tilt_mode_Hz", 1, 1, 1e5, "f_t, mode of the tilt")                                    \
  X(core, tilt_damping, "tilt_damping", 1, 0, 2, "z_t, damping ratio of that mode")                          \
  X(core, pole_arm, "pole_arm_mm", 1e-3, 0.5, 500, "pole faces and stops from the tilt axis")                \
  X(bridges, poles, "poles", 1, 1, 8, "n, equal double-break bridges")                                       \
  X(bridges, gap, "gap_mm", 1e-3, 0.05, 50, "x_c, travel to first touch")                                    \
  X(bridges, mass, "mass_g", 1e-3, 0.01, 2000, "m_c, one bridge")                                            \
  X(bridges, preload, "preload_N", 1, 0, 2000, "F_c0, overtravel spring of one bridge, open")                \
  X(bridges, rate, "rate_N_per_m", 1, 1, 1e7, "k_c, overtravel spring of one bridge")                        \
  X(bridges, contact_stiffness, "contact_stiffness_N_per_m", 1, 1e2, 1e12,                                   \
    "k_con, both breaks of one bridge")                                                                      \
  X(bridges, contact_restitution, "contact_restitution", 1, 1e-3, 1,                                         \
    "e_con, rebound of a drop test of the contacts")                                                         \
  X(bridges, contact_exponent, "contact_exponent", 1, 1, 2,                                                  \
    "n: 1 spring and damper; 1.5 Hertz, 2: Hunt and Crossley's damping")                                     \
  X(bridges, contact_depth, "contact_depth_um", 1e-6, 0.1, 1000,                                             \
    "d_0, with n above 1: depth at which F = k_con d_0")                                                     \
  X(bridges, contact_speed, "contact_speed_m_per_s", 1, 0.01, 20,                                            \
    "with n above 1: speed of the drop test of e_con")                                                       \
  X(bridges, seat_stiffness, "seat_stiffness_N_per_m", 1, 1e2, 1e12,                                         \
    "bridge against its seat in the holder")                                                                 \
  X(bridges, seat_damping, "seat_damping", 1, 0, 2, "z_stop, damping ratio of the seat")                     \
  X(bridges, half_length, "half_length_mm", 1e-3, 0.5, 500, "bridge centre to break")                        \
  X(bridges, seat_half_length, "seat_half_length_mm", 1e-3, 0.05, 500,                                       \
    "bridge centre to each edge of its seat")                                                                \
  X(bridges, inertia, "inertia_g_mm2", 1e-9, 0.1, 1e7, "J, one bridge about its tilt axis")                  \
  X(bridges, tilt_gap, "tilt_gap_mm", 1e-3, -5, 5, "break B opens this much wider than break A")             \
  X(bridges, pitch, "pitch_mm", 1e-3, 0, 200, "from pole to pole along the lever of the core's tilt")        \
  X(bridges, gap_spread, "gap_spread_mm", 1e-3, -5, 5,                                                       \
    "each pole opens this much wider than the one before")                                                   \
  X(base, mass, "mass_g", 1e-3, 1, 1e6, "M_h, static core and fixed contacts")                               \
  X(base, hertz, "mode_Hz", 1, 0.1, 1e5, "f_h, mode of the base on its mounting")                            \
  X(base, damping, "damping", 1, 0, 2, "z_h, damping ratio of that mode")                                    \
  X(base, core_mass, "core_mass_g", 1e-3, 0, 1e6,                                                            \
    "M_s, static core on buffer springs; 0 = part of the base")                                              \
  X(base, core_hertz, "core_mode_Hz", 1, 0.1, 1e5, "f_s, mode of the static core on its buffer")             \
  X(base, core_damping, "core_damping", 1, 0, 2, "z_s, damping ratio of that mode")                          \
  X(base, flex_modes, "flex_modes", 1, 0, 3, "bending modes of the housing, a free beam along the poles")    \
  X(base, flex_hertz, "flex_mode_Hz", 1, 1, 1e5, "f_1; the higher ones at 2.757 and 5.404 times that")       \
  X(base, flex_mass, "flex_mass_g", 1e-3, 1, 1e6, "modal mass of each of them")                              \
  X(base, flex_damping, "flex_damping", 1, 0, 2, "damping ratio of each of them")

constexpr std::array table{
#define POWBENCH_X(part, member, key, unit, low, high, meaning)                                         \
  SpecimenField{#part,                                                                                  \
                key,                                                                                    \
                unit,                                                                                   \
                low,                                                                                    \
                high,                                                                                   \
                std::is_integral_v<decltype(Specimen{}.part.member)>,                                   \
                [](const Specimen& s) { return static_cast<double>(s.part.member); },                   \
                [](Specimen& s, double v) { s.part.member = static_cast<decltype(s.part.member)>(v); }, \
                meaning},
    POWBENCH_SPECIMEN(POWBENCH_X)
#define POWBENCH_SHAPE_X(...) POWBENCH_X(shape, __VA_ARGS__)
        POWBENCH_MAGNET_SHAPE(POWBENCH_SHAPE_X)
#undef POWBENCH_SHAPE_X
#undef POWBENCH_X
};

}  // namespace

std::span<const SpecimenField> specimen_fields() {
  return table;
}

}  // namespace powbench::sim
