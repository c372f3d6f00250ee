#pragma once

#include "core/events.h"

namespace powbench::host {

/// Quantities and contact trains as a table for people, to stdout.
void print_events(const Events&);

}  // namespace powbench::host
