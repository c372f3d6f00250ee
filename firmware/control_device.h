#pragma once

#include "firmware/iiod/model.h"

/// Tables of the device `contactor-ctl`; `self` of its functions is BenchDevices.

namespace powbench::firmware {

extern const std::span<const iiod::Channel> control_channels;
extern const std::span<const iiod::Attribute> control_attributes;

/// Spends the token; the trigger's attribute does it too.
int write_fire(void* self, std::uint32_t, std::string_view value);
int read_zero(const void*, std::uint32_t, Text& out);

}  // namespace powbench::firmware
