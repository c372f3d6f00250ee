#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "host/config/test_record.h"
#include "host/store/store.h"

/// What the store holds, as the live bench shows it: JSON with SI units in the keys, null for what is not known.

namespace powbench::host {

/// What lists of campaigns need of the plan and the specimen of each; read once.
class CampaignFacts {
 public:
  struct Facts {
    std::string specimen;
    std::vector<double> angles;  ///< rad
    bool planned = false;        ///< not single closings, and no import
    TestRecord test;             ///< as planned, without annotations
    std::vector<double> shots;   ///< closing angle of each planned shot, deg; empty: nothing was planned
  };
  /// From any thread.
  Facts of(const CampaignInfo&);

 private:
  std::mutex mutex_;
  std::map<std::string, Facts> known_;  ///< by the hashes of plan and specimen
};

std::string campaigns_document(const Store&, CampaignFacts&);
/// Those behind shot `after`.
std::string shots_document(const Store&, const CampaignInfo&, std::int64_t after);
/// Shots with their quantities as CSV; the first line says where they come from.
std::string shots_table(const Store&, const CampaignInfo&);
std::string shot_document(const Store&, const StoredShot&);
/// Curves and marks as host/report/panels.js draws them; "[]" where the films are missing.
std::string closing_document(const Store&, const StoredShot&);
std::string waveforms_document(const Store&, const StoredShot&);
std::string events_document(const Store&, const StoredShot&);
/// The record as host/serve/frame.h packs it.
std::string frame_document(const Store&, const StoredShot&);
/// `second` against `first`.
std::string pair_document(const Store&, const CampaignInfo& first, const CampaignInfo& second);
std::string report_document(const Store&, const CampaignInfo&);
std::string junit_document(const Store&, const CampaignInfo&);
/// One at a time. Throws BadInput where no browser prints it.
std::string report_pdf(const Store&, const CampaignInfo&);

/// Of the report: its script is part of the page, so it runs in a sandbox of its own.
inline constexpr const char* report_policy =
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline' data:; style-src "
    "'unsafe-inline'; "
    "img-src data:; font-src data:";

}  // namespace powbench::host
