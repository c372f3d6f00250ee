#pragma once

#include <optional>

#include "host/gather/gather.h"

namespace powbench::host {

/// A stored shot judged by the plan that is stored, so that a store of an earlier program says what is known today.
/// Without events, or without a measurement: as it was stored.
Judgement judged_anew(const StoredShot&, const std::optional<Events>&, const RunOptions&);

/// The campaign in one word, as its report has it, without reading a record.
Outcome campaign_verdict(const Store&, const CampaignInfo&);

}  // namespace powbench::host
