#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "dsp/events/event_stream.h"
#include "host/cli/verbs.h"
#include "host/config/bad_input.h"

namespace powbench::host {

namespace {

constexpr std::size_t piece =
    256;  ///< samples at a time, as a rig's buffer would bring them; changes no event

void print(const std::vector<dsp::StreamEvent>& events) {
  constexpr const char* kinds[] = {"touch", "release", "seat"};
  for (const dsp::StreamEvent& e : events)
    fmt::print("  {:<10} {:<8} {:>9.3f} ms  +- {:>6.1f} us  known {:>5.1f} ms later\n", info(e.channel).name,
               kinds[static_cast<std::size_t>(e.kind)], 1e3 * e.time.value, 2e6 * e.time.u,
               1e3 * e.latency());
}

}  // namespace

Exit stream_events(const Record& record, const dsp::ExtractOptions& options, const EventsArgs& args) {
  if (args.json || !args.picture.empty() || options.filter.wanted() || args.force_percent ||
      args.voltage_percent || args.min_opening_us)
    throw BadInput(
        {"--stream: not with --json, --picture, --filter or a lab rule, which need the whole record"});
  Record shape = record;
  for (ChannelRecord& c : shape.channels) c.raw.clear();
  dsp::EventStream stream(std::move(shape), options);
  fmt::print("{}: events as they come, at most {:.0f} ms late; +- is U (k = 2)\n", args.shot,
             1e3 * dsp::stream_latency);
  std::vector<std::int16_t> scans;
  for (std::size_t at = 0; at < record.samples(); at += piece) {
    scans.clear();
    for (std::size_t i = at; i < std::min(at + piece, record.samples()); ++i)
      for (const ChannelRecord& c : record.channels) scans.push_back(c.raw[i]);
    print(stream.push(static_cast<std::int64_t>(at), scans));
  }
  fmt::print("  the record ends\n");
  print(stream.finish());
  return Exit::pass;
}

}  // namespace powbench::host
