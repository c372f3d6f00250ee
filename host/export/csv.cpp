#include "host/export/csv.h"

#include <fmt/format.h>

#include <iterator>

namespace powbench::host {

std::string to_csv(const Record& record) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "time [s]");
  for (const ChannelRecord& c : record.channels)
    fmt::format_to(to, ",{} [{}]", info(c.channel).name, info(c.channel).unit);
  out.push_back('\n');
  for (std::size_t i = 0; i < record.samples(); ++i) {
    fmt::format_to(to, "{:.9g}", record.time(i));
    for (const ChannelRecord& c : record.channels) fmt::format_to(to, ",{:.9g}", c.value(i));
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace powbench::host
