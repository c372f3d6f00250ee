#pragma once

#include <string>

#include "host/store/store.h"

namespace powbench::host {

/// What a campaign came to, in three sentences, each on a line: the verdict, the best closing angle, what to open.
std::string three_sentences(const Store&, const CampaignInfo&, const std::string& page);

}  // namespace powbench::host
