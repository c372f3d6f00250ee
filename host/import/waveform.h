#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/record.h"
#include "dsp/options.h"
#include "host/import/calibration.h"

/// Anyone's waveform as a record of a rig, so that it takes the same path as all others.

namespace powbench::host {

struct Imported {
  Record record;
  dsp::ExtractOptions options;  ///< defaults with what the calibration says
  std::string recorded;         ///< day of the record, 2030-12-31; "" = not given
  std::string source;           ///< what the records were taken from, by the calibration file; "" = not given
  std::string calibration;      ///< with its last day, as an instrument of the test record; "" = without one
  bool angle_commanded = false;    ///< the calibration file names the closing angle
  std::vector<std::string> notes;  ///< what was done to the numbers, one sentence each
};

/// From the text of a waveform file: header, samples, time stamps, counts. Throws BadInput naming file, line, column,
/// value and what is allowed. `today` as `2030-12-31`, for the calibration's last day; `calibration_file` names it in
/// messages.
///
/// Stamps become a uniform clock (clock.h). Above 2.5 MS/s neighbouring samples are averaged down to 1 MS/s .. 2.5
/// MS/s. Cells without a number are gaps of their channel; a channel that has one number every few rows is a slower
/// one, bridged by straight lines. Force and travel outside what a contactor can show are refused: the unit is wrong.
Imported import_waveform(std::string_view text, const std::string& file, const Calibration&,
                         const std::string& calibration_file, const std::string& today);

/// Reads both files; the calibration file is the one given, else the one beside the waveform if there is one.
Imported import_file(const std::filesystem::path&, const std::optional<std::filesystem::path>& calibration);

}  // namespace powbench::host
