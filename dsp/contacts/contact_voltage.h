#pragma once

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

namespace powbench::dsp {

/// Train of the measured pole from its contact-voltage (open: the open-circuit voltage; closed: 0). The open
/// level is the median before switch-on; a crossing of `open_share` of it is interpolated linearly and known
/// to dt / sqrt(12). Openings of at least `min_open_voltage` count. A pole that is closed from the start has
/// an unknown first touch.
ContactTrain contact_voltage_train(const Record&, const ExtractOptions&);

/// V: that level of a record, beyond which to either side the pole counts as open; NaN without a sense voltage.
double contact_level(const Record&, const ExtractOptions&);

/// Sets flag_contradiction on the train of the pole and on the films when force and contact-voltage disagree
/// on open or closed for longer than `tolerance` plus three standard uncertainties: the pole is closed only
/// when both breaks are.
bool cross_check(ContactTrain& voltage, ContactTrain& a, ContactTrain& b, double t_end);

}  // namespace powbench::dsp
