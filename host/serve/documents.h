#pragma once

#include <string>

#include "host/store/store.h"

/// What the store holds, as the live bench shows it: JSON with SI units in the keys, null for what is not known.

namespace powbench::host {

std::string campaigns_document(const Store&);
std::string shots_document(const Store&, const CampaignInfo&);
std::string shot_document(const Store&, const StoredShot&);
/// Curves and marks as host/report/panels.js draws them; "[]" where the films are missing.
std::string closing_document(const Store&, const StoredShot&);
std::string waveforms_document(const Store&, const StoredShot&);
std::string report_document(const Store&, const CampaignInfo&);

/// Of the report: its script is part of the page, so it runs in a sandbox of its own.
inline constexpr const char* report_policy =
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline' data:; style-src "
    "'unsafe-inline'; "
    "img-src data:; font-src data:";

}  // namespace powbench::host
