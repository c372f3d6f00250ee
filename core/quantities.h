#pragma once

#include <array>
#include <string_view>

#include "core/events.h"

/// The quantities that plans limit, comparisons list and papers publish, once. Symbols follow the published tables.

namespace powbench {

/// The contact train that times are quoted from: contact-voltage where the channel exists (the standards' way to define
/// a closed pole), else force A, else force B.
inline const ContactTrain& timing_train(const Events& e) {
  if (e.contact_voltage.present) return e.contact_voltage;
  return e.pvdf_a.present ? e.pvdf_a : e.pvdf_b;
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
               return t.contacts.empty() ? Measured{} : t.contacts.front().touch;
             }},
    Quantity{"t_ct_bon", "s", "contact bounce time: first touch to last touch",
             [](const Events& e) { return timing_train(e).bounce_time; }},
    Quantity{"t_ct2", "s", "contact settled: last touch",
             [](const Events& e) { return timing_train(e).settled; }},
    Quantity{"t_xt1", "s", "core seat: first arrival of the moving core",
             [](const Events& e) { return e.core.seat; }},
    Quantity{"t_xt_bon", "s", "core bounce time: first to last arrival",
             [](const Events& e) { return e.core.bounce_time; }},
    Quantity{"t_xt2", "s", "core settled: last arrival", [](const Events& e) { return e.core.settled; }},
    Quantity{"v_core", "m/s", "core velocity at the seat",
             [](const Events& e) { return e.core.impact_velocity; }},
    Quantity{"F_peak", "N", "largest contact force on either film",
             [](const Events& e) {
               Measured peak;
               for (const auto* train : {&e.pvdf_a, &e.pvdf_b})
                 for (const auto& c : train->contacts)
                   if (!peak.known() || c.peak.value > peak.value) peak = c.peak;
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
