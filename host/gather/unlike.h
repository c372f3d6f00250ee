#pragma once

#include <string>
#include <vector>

#include "host/store/store.h"

namespace powbench::host {

/// In what two campaigns were not alike beside their closings: specimen, rig, supply, temperature, extraction. One
/// line each, as "supply voltage: 230 V, then 200 V"; none where they were alike.
std::vector<std::string> unlike(const Store&, const CampaignInfo& first, const CampaignInfo& second);

/// How many measured closings of the second campaign hold a record of the first, bit for bit: a simulated rig given the
/// same plan and seed twice, or one file imported twice. That these agree says nothing.
std::size_t same_records(const Store&, const CampaignInfo& first, const CampaignInfo& second);

/// The same as a sentence with its cause as far as the origins tell it; "" where there is none.
std::string same_records_sentence(const Store&, const CampaignInfo& first, const CampaignInfo& second);

}  // namespace powbench::host
