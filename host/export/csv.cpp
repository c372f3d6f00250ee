#include "host/export/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

namespace powbench::host {

namespace {

std::vector<bool> lost_samples(const Record& record, const ChannelRecord& c) {
  std::vector<bool> lost(record.samples(), false);
  const auto n = static_cast<std::int64_t>(lost.size());
  for (const auto* gaps : {&record.gaps, &c.gaps})
    for (const Gap& g : *gaps)
      for (auto i = std::max<std::int64_t>(g.first, 0); i < std::min(g.first + g.count, n); ++i)
        lost[static_cast<std::size_t>(i)] = true;
  return lost;
}

}  // namespace

std::string to_csv(const Record& record) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "time [s]");
  for (const ChannelRecord& c : record.channels)
    fmt::format_to(to, ",{} [{}]", info(c.channel).name, info(c.channel).unit);
  out.push_back('\n');
  std::vector<std::vector<bool>> lost;
  for (const ChannelRecord& c : record.channels) lost.push_back(lost_samples(record, c));
  for (std::size_t i = 0; i < record.samples(); ++i) {
    fmt::format_to(to, "{:.10g}", record.time(i));
    for (std::size_t k = 0; k < record.channels.size(); ++k)
      if (lost[k][i])
        out.push_back(',');
      else
        fmt::format_to(to, ",{:.9g}", record.channels[k].value(i));
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace powbench::host
