#include "host/export/csv.h"

#include <fmt/format.h>

#include <iterator>
#include <vector>

#include "host/export/lost.h"

namespace powbench::host {

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
    fmt::format_to(to, "{}", record.time(i));
    for (std::size_t k = 0; k < record.channels.size(); ++k)
      if (lost[k][i])
        out.push_back(',');
      else
        fmt::format_to(to, ",{}", record.channels[k].value(i));
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace powbench::host
