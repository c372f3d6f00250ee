#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "host/export/lost.h"
#include "host/export/waveforms.h"

namespace powbench::host {
namespace {

constexpr std::int16_t lost_16 = std::numeric_limits<std::int16_t>::min();
constexpr std::int32_t lost_32 = std::numeric_limits<std::int32_t>::min();

void put(std::string& to, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> (8 * i));
}

/// hh:mm:ss.nnnnnnnnn of a day that the recording begins at midnight.
std::string clock(double seconds) {
  const auto ns = static_cast<std::int64_t>(std::llround(seconds * 1e9));
  const std::int64_t s = ns / 1'000'000'000;
  return fmt::format("01/01/2000,{:02}:{:02}:{:02}.{:09}", s / 3600 % 24, s / 60 % 60, s % 60,
                     ns % 1'000'000'000);
}

/// No comma and no line end, which separate.
std::string plain(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || static_cast<unsigned char>(c) < ' '; }, ' ');
  return text.substr(0, 64);
}

}  // namespace

ComtradeText to_comtrade(const Record& r, const std::string& station) {
  std::vector<std::vector<bool>> lost;
  bool wide = false;
  for (const ChannelRecord& c : r.channels) {
    lost.push_back(lost_samples(r, c));
    for (std::size_t i = 0; i < c.raw.size(); ++i) wide = wide || (!lost.back()[i] && c.raw[i] == lost_16);
  }
  ComtradeText out;
  auto to = std::back_inserter(out.configuration);
  fmt::format_to(to, "{},{},2013\r\n{},{}A,0D\r\n", plain(station), plain(r.rig), r.channels.size(),
                 r.channels.size());
  for (std::size_t k = 0; k < r.channels.size(); ++k) {
    const ChannelRecord& c = r.channels[k];
    fmt::format_to(to, "{},{},,,{},{},{},{},{},{},1,1,P\r\n", k + 1, info(c.channel).name,
                   info(c.channel).unit, c.scale, c.offset * c.scale, c.delay == 0.0 ? 0.0 : -1e6 * c.delay,
                   wide ? -2147483647 : -32767, wide ? 2147483647 : 32767);
  }
  const double hertz = std::isfinite(r.conditions.mains_hertz) ? r.conditions.mains_hertz : 50.0;
  // where the record begins after switch-on the first sample lies later in the day
  const double before = -r.time(0);
  fmt::format_to(to, "{}\r\n1\r\n{},{}\r\n{}\r\n{}\r\n{}\r\n1\r\n0,0\r\nB,3\r\n", hertz, r.sample_rate,
                 r.samples(), clock(std::max(-before, 0.0)), clock(std::max(before, 0.0)),
                 wide ? "BINARY32" : "BINARY");
  for (std::size_t i = 0; i < r.samples(); ++i) {
    put(out.data, static_cast<std::uint32_t>(i + 1), 4);
    put(out.data, 0xFFFFFFFFU, 4);  // no stamps: the rate says it
    for (std::size_t k = 0; k < r.channels.size(); ++k) {
      const std::int16_t raw = r.channels[k].raw[i];
      if (wide)
        put(out.data, static_cast<std::uint32_t>(lost[k][i] ? lost_32 : static_cast<std::int32_t>(raw)), 4);
      else
        put(out.data, static_cast<std::uint16_t>(lost[k][i] ? lost_16 : raw), 2);
    }
  }
  return out;
}

}  // namespace powbench::host
