#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/gather/scene.h"

namespace powbench::host {

/// The campaign that `scene` is fired into, on the rig that calls itself `rig`: with `resume` the newest one of this
/// plan and specimen if there is one, else a new one. The rig's calibration goes into its test record. `say` gets one
/// sentence about what a person should know. Throws RigError when the campaign to go on with was begun on another
/// rig.
std::int64_t begin_campaign(Store&, const Scene&, const std::string& rig_uri, const rigs::RigInfo& rig,
                            bool resume, const std::function<void(const std::string&)>& say);

}  // namespace powbench::host
