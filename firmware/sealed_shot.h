#pragma once

#include <span>

#include "firmware/controller.h"
#include "firmware/iiod/model.h"
#include "firmware/source_device.h"

/// What a shot was, as one text with a checksum: `key=value` separated by blanks, closed by ` seal=` and the CRC-32
/// of all before that, eight hexadecimal digits. Numbers are integers, the unit stands in the key. Texts have every
/// character but letters, digits and ._:+- as % and two hexadecimal digits.
///
///   powbench_shot=1 stage=armed boot= shot= model= serial= firmware= calibration= angle_centideg= hold_ms= touch_us=
///   tolerance_mdeg=
///   [supply_mv= mains_mhz= ambient_mdegc= seed=]      on rigs with a programmable source
///   sample_rate= samples=
///   and with stage=complete
///   fire_sample= fire_offset_ns= gaps=FIRST:COUNT,... overruns= marks= record_crc=
///   and for each channel in scan order
///   ID=SCALE:OFFSET:DELAY:CORNER:AREA   1e-12 IIO unit per count, counts, ns, uHz, 1e-12 m2 (0: not a force)

namespace powbench::firmware {

/// Context attributes of the rig: where boot id, model, serial number and version come from. One place for all of them.
std::string_view identity_value(std::span<const iiod::ContextAttribute>, std::string_view name);

/// "none" when no shot is armed, under way or recorded. -EOVERFLOW when the text does not fit.
int write_sealed_shot(const Controller&, const SetPoints* source,
                      std::span<const iiod::ContextAttribute> identity, Text& out);

/// From the gate edge to the first sample behind it, ns.
std::int64_t fire_offset_ns(const Controller&);

}  // namespace powbench::firmware
