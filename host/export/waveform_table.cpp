#include <fmt/format.h>

#include <cmath>

#include "host/export/lost.h"
#include "host/export/waveforms.h"

namespace powbench::host {

std::vector<bool> lost_samples(const Record& record, const ChannelRecord& c) {
  std::vector<bool> lost(record.samples(), false);
  const auto n = static_cast<std::int64_t>(lost.size());
  for (const auto* gaps : {&record.gaps, &c.gaps})
    for (const Gap& g : *gaps)
      for (auto i = std::max<std::int64_t>(g.first, 0); i < std::min(g.first + g.count, n); ++i)
        lost[static_cast<std::size_t>(i)] = true;
  return lost;
}

About delays_of(const Record& r) {
  About list{
      {"time_s", "on the sampling clock; a value shows its quantity the delay of its channel earlier"}};
  for (const ChannelRecord& c : r.channels)
    list.emplace_back("delay_us " + std::string(info(c.channel).name), fmt::format("{:.9g}", c.delay * 1e6));
  return list;
}

Table waveform_table(const Record& r) {
  std::vector<double> time(r.samples());
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = r.time(i);
  Table table{{"time_s", std::move(time)}};
  for (const ChannelRecord& c : r.channels) {
    const std::vector<bool> lost = lost_samples(r, c);
    std::vector<double> values(r.samples());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = lost[i] ? std::nan("") : c.value(i);
    table.push_back(
        {std::string(info(c.channel).name) + "_" + std::string(info(c.channel).unit), std::move(values)});
  }
  return table;
}

}  // namespace powbench::host
