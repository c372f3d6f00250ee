#include "host/config/test_record.h"

#include <fmt/format.h>

#include <charconv>
#include <chrono>

#include "host/config/bad_input.h"
#include "host/config/nearest.h"

namespace powbench::host {

namespace {

constexpr std::string_view form =
    "\"NAME; CERTIFICATE; LAST DAY\", such as \"charge amplifier CA-7; K-2041; 2027-03-01\"";

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

}  // namespace

bool is_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto number = [&](std::size_t at, std::size_t n) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + at + n, value);
    return error == std::errc() && end == text.data() + at + n ? value : -1;
  };
  using namespace std::chrono;
  const int y = number(0, 4), m = number(5, 2), d = number(8, 2);
  return y >= 1900 && m > 0 && d > 0 &&
         year_month_day(year(y), month(static_cast<unsigned>(m)), day(static_cast<unsigned>(d))).ok();
}

std::string utc_today() {
  using namespace std::chrono;
  const year_month_day d{floor<days>(system_clock::now())};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(d.year()), static_cast<unsigned>(d.month()),
                     static_cast<unsigned>(d.day()));
}

std::string read_instrument(std::string_view text, Instrument& out) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    parts.push_back(trimmed(text.substr(at, end - at)));
    at = end + 1;
  }
  if (parts.size() < 2 || parts.size() > 3 || parts[0].empty() || parts[1].empty())
    return "is no instrument; wanted " + std::string(form);
  if (parts.size() == 3 && !is_day(parts[2]))
    return "'" + parts[2] + "' is no day; wanted " + std::string(form);
  out = {parts[0], parts[1], parts.size() == 3 ? parts[2] : ""};
  return "";
}

void complete(TestRecord& record, std::string_view key, const std::string& text) {
  if (trimmed(text).empty()) throw BadInput({std::string(key) + ": the text is empty"});
  if (key == "instrument") {
    Instrument unused;
    if (const std::string wrong = read_instrument(text, unused); !wrong.empty())
      throw BadInput({"instrument: '" + text + "' " + wrong});
    record.instruments.push_back(text);
    return;
  }
  if (key == "recorded" && !is_day(text))
    throw BadInput({"recorded: '" + text + "' is no day; allowed a day as 2030-12-31"});
  std::vector<std::string> known{"instrument"};
  for (const RecordField& f : record_fields) {
    known.emplace_back(f.key);
    if (f.key != key) continue;
    std::string& place = record.*f.place;
    if (f.place == &TestRecord::recorded && !place.empty() && place != text) {
      const std::string line = "recorded: stated as " + place + " and then as " + text +
                               "; calibrations are judged by the later day";
      record.remarks += (record.remarks.empty() ? "" : "\n") + line;
      place = std::max(place, text);
      return;
    }
    place = f.place == &TestRecord::remarks && !place.empty() ? place + "\n" + text : text;
    return;
  }
  std::string allowed;
  for (const std::string& k : known) allowed += (allowed.empty() ? "" : ", ") + k;
  const std::string guess = nearest(key, known);
  throw BadInput({std::string(key) + ": no line of the test record; allowed " + allowed +
                  (guess.empty() ? "" : "; did you mean '" + guess + "'?")});
}

void refuse_day_to_come(const std::string& recorded) {
  const std::string today = utc_today();
  if (recorded > today)
    throw BadInput({"recorded: '" + recorded + "' is a day to come; allowed up to " + today});
}

void refuse_line(std::string_view key, const std::string& text, bool imported) {
  TestRecord unused;
  complete(unused, key, text);
  refuse_day_to_come(unused.recorded);
  if (!imported && (key == "recorded" || key == "source"))
    throw BadInput(
        {std::string(key) + ": is told of imported records; this campaign has its own days and rig"});
}

std::vector<Instrument> expired(const TestRecord& record, std::string_view day) {
  std::vector<Instrument> list;
  for (const std::string& text : record.instruments) {
    Instrument i;
    if (read_instrument(text, i).empty() && !i.valid_until.empty() && i.valid_until < day) list.push_back(i);
  }
  return list;
}

}  // namespace powbench::host
