#pragma once

#include <string>
#include <string_view>

#include "core/conditions.h"
#include "core/events.h"
#include "core/origin.h"
#include "dsp/options.h"
#include "host/cli/verbs.h"
#include "host/gather/event_filter.h"
#include "host/gather/shown.h"

namespace powbench::host {

/// With so many decimals, and no sign on a zero; a dash where it is not known.
std::string digits_of(double value, int decimals);

/// The seed of a shot; null of an import: nobody drew one.
template <class Json>
Json seed_of(Origin origin, const Conditions& c) {
  return origin == Origin::import ? Json(nullptr) : Json(c.seed);
}

/// Why there is no bounce time; "" where there is one.
std::string no_bounce_reason(const Events&);

/// Quantities and contact trains as a table for people, to stdout. `u_of`: what U is of, behind "U (k = 2)"; the
/// quantities as the stored shot shows them, where there is one.
void print_events(const Events&, std::string_view u_of = "", const Shown* = nullptr);

/// Sets --filter, --phase and --band. Throws BadInput that names the option and what is allowed.
void set_filter_options(dsp::ExtractOptions&, const EventsArgs&);

/// Writes --picture, where it is wanted; `origin` stands on it.
void write_strip(const Record&, const FilteredEvents&, const EventsArgs&, const std::string& origin);

/// What the filter does, where there is one, and what is known of the vibration, to stdout.
void print_bands(const Record&, const FilteredEvents&);

}  // namespace powbench::host
