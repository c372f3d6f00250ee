#pragma once

#include "firmware/calibration.h"

/// What a host sees of a rig's calibration: the firmware's own rows, their checksum, and what it takes for a day and
/// a name.

namespace powbench::rigs {

using firmware::Calibrations;
using firmware::ChannelCalibration;
using firmware::is_day;
using firmware::rows_crc32;
using firmware::usable_certificate;

}  // namespace powbench::rigs
