#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Who tested what, for whom and with which instruments: what a report needs to be signed. Part of the plan,
/// completed later by annotations of the campaign.

namespace powbench::host {

struct Instrument {
  std::string name;         ///< as "charge amplifier CA-7"
  std::string certificate;  ///< of its calibration
  std::string valid_until;  ///< last day, 2030-12-31; "" = not stated
};

struct TestRecord {
  std::string customer, order, device, serial, rating, standard, operator_name, recorded, source, remarks;
  std::vector<std::string> instruments;  ///< "NAME; CERTIFICATE; LAST DAY" each, see `instrument`
};

/// One line of the record: key in files and annotations, label in reports, meaning in templates.
struct RecordField {
  std::string_view key, label, meaning;
  std::string TestRecord::*place;
};
inline constexpr std::array<RecordField, 10> record_fields{{
    {"customer", "Customer", "who ordered the test", &TestRecord::customer},
    {"order", "Order", "number of the order or of the test", &TestRecord::order},
    {"device", "Device", "type of the device under test", &TestRecord::device},
    {"serial", "Serial number", "of the device under test", &TestRecord::serial},
    {"rating", "Rating", "of the device, such as 230 V 50 Hz, AC-3 32 A", &TestRecord::rating},
    {"standard", "Standard", "that the test follows, with its clause", &TestRecord::standard},
    {"operator", "Operator", "who tested", &TestRecord::operator_name},
    {"recorded", "Recorded", "day on which imported records were taken, as 2030-12-31",
     &TestRecord::recorded},
    {"source", "Source", "what imported records were taken from, by their file or by who imported them",
     &TestRecord::source},
    {"remarks", "Remarks", "anything else that the report's reader has to know", &TestRecord::remarks},
}};

/// Name of the calibration of an imported waveform among the instruments.
inline constexpr const char* waveform_calibration = "scales of the waveform file";

/// What is wrong with the text of an instrument; "" = nothing, and `out` is filled.
std::string read_instrument(std::string_view text, Instrument& out);

/// A day of the calendar as 2030-12-31.
bool is_day(std::string_view);
/// Today's, UTC.
std::string utc_today();

/// Completes the record: a later word replaces an earlier one; remarks and instruments are added. Of two days of
/// recording the later one counts, which is the harder test of a calibration, and a remark names both. Throws BadInput
/// for a key that is none, an empty text, a day that is none, or an instrument that cannot be read.
void complete(TestRecord&, std::string_view key, const std::string& text);

/// The same for a line that somebody adds today. Throws BadInput also for a day of recording that is to come and, where
/// the campaign is not `imported`, for what only imported records need to be told.
void refuse_line(std::string_view key, const std::string& text, bool imported);

/// Throws BadInput for a day of recording that is to come.
void refuse_day_to_come(const std::string& recorded);

/// Instruments whose last day lies before `day` (2030-12-31).
std::vector<Instrument> expired(const TestRecord&, std::string_view day);

}  // namespace powbench::host
