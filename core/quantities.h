#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/events.h"

/// The quantities that plans limit, comparisons list and papers publish, once. Symbols follow the published tables.

namespace powbench {

/// The contact train that times are quoted from: contact-voltage where the channel exists (the standards' way to define
/// a closed pole), else both forces together, else the only force.
inline const ContactTrain& timing_train(const Events& e) {
  if (e.contact_voltage.present) return e.contact_voltage;
  if (e.pole.by_force.present) return e.pole.by_force;
  return e.pvdf_a.present ? e.pvdf_a : e.pvdf_b;
}

/// s: from time 0 of the record, the gate edge, to the step of the coil voltage; 0 where the record does not tell one
/// from the other (20 us, three u).
inline Measured switch_delay(const Events& e) {
  constexpr double told_apart = 20e-6;
  const Measured& step = e.coil.switch_on;
  const double size = step.value < 0 ? -step.value : step.value;
  return step.known() && size > told_apart && size > 3 * step.u ? step : Measured{0, 0};
}

/// An instant of the record, counted from the step of the coil voltage.
inline Measured after_switch_on(const Events& e, Measured at) {
  const Measured delay = switch_delay(e);
  if (delay.value == 0) return at;
  return {at.value - delay.value, std::hypot(at.u, delay.u)};
}

struct Quantity {
  std::string_view symbol;
  std::string_view unit;  ///< SI
  std::string_view meaning;
  Measured (*of)(const Events&);
};

inline constexpr std::array quantity_table{
    Quantity{"t_ct1", "s", "first contact touch after switch-on",
             [](const Events& e) {
               const auto& t = timing_train(e);
               return t.contacts.empty() ? Measured{} : after_switch_on(e, t.contacts.front().touch);
             }},
    Quantity{"t_ct_bon", "s", "contact bounce time: first touch to last touch",
             [](const Events& e) { return timing_train(e).bounce_time; }},
    Quantity{"t_ct2", "s", "contact settled: last touch",
             [](const Events& e) { return after_switch_on(e, timing_train(e).settled); }},
    Quantity{"t_xt1", "s", "core seat: first arrival of the moving core",
             [](const Events& e) { return after_switch_on(e, e.core.seat); }},
    Quantity{"t_ot", "s", "overtravel time: first contact touch to core seat",
             [](const Events& e) {
               const auto& t = timing_train(e);
               if (t.contacts.empty() || !e.core.seat.known()) return Measured{};
               const Measured& touch = t.contacts.front().touch;
               return Measured{e.core.seat.value - touch.value, std::hypot(e.core.seat.u, touch.u)};
             }},
    Quantity{"t_xt_bon", "s", "core bounce time: first to last arrival",
             [](const Events& e) { return e.core.bounce_time; }},
    Quantity{"t_xt2", "s", "core settled: last arrival",
             [](const Events& e) { return after_switch_on(e, e.core.settled); }},
    Quantity{"v_core", "m/s", "core velocity at the seat",
             [](const Events& e) { return e.core.impact_velocity; }},
    Quantity{"F_peak", "N", "largest contact force on either film, up to 0.3 ms after the last touch",
             [](const Events& e) {
               Measured peak;
               for (const auto* train : {&e.pvdf_a, &e.pvdf_b})
                 for (const auto& c : train->contacts) {
                   if ((c.flags & flag_clipped) != 0) return Measured{};  // as much as that, or more
                   if (!peak.known() || c.peak.value > peak.value) peak = c.peak;
                 }
               return peak;
             }},
    Quantity{"i_peak", "A", "largest coil current", [](const Events& e) { return e.coil.peak_current; }},
};

/// Entry with this symbol, or nullptr.
inline const Quantity* find_quantity(std::string_view symbol) {
  for (const auto& q : quantity_table)
    if (q.symbol == symbol) return &q;
  return nullptr;
}

}  // namespace powbench
