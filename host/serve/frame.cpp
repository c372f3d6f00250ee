#include "host/serve/frame.h"

#include <nlohmann/json.hpp>

namespace powbench::host {

std::string record_frame(const Record& record, std::int64_t shot, const std::string& origin) {
  using Object = nlohmann::ordered_json;
  Object channels = Object::array();
  for (const ChannelRecord& c : record.channels)
    channels.push_back({{"name", info(c.channel).name},
                        {"unit", info(c.channel).unit},
                        {"scale", c.scale},
                        {"offset", c.offset},
                        {"clip_low", c.clip_low},
                        {"clip_high", c.clip_high}});
  std::string head = Object{
      {"shot", shot},
      {"origin", origin},
      {"rate_hz", record.sample_rate},
      {"samples", record.samples()},
      {"fire_sample", record.fire_sample},
      {"channels",
       channels}}.dump();
  if (head.size() % 2 != 0) head += ' ';
  std::string out;
  out.reserve(4 + head.size() + 2 * record.samples() * record.channels.size());
  for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(head.size() >> shift & 0xFF);
  out += head;
  for (const ChannelRecord& c : record.channels)
    for (const std::int16_t count : c.raw) {
      const auto bits = static_cast<std::uint16_t>(count);
      out += static_cast<char>(bits & 0xFF);
      out += static_cast<char>(bits >> 8);
    }
  return out;
}

}  // namespace powbench::host
