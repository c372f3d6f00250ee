#include "host/run/simulated_point.h"

#include "host/store/json.h"
#include "host/store/packing.h"
#include "host/store/point_bytes.h"

namespace powbench::host {
namespace {

void add(ByteWriter& out, const std::vector<Gap>& gaps) {
  out.add(static_cast<std::int64_t>(gaps.size()));
  for (const Gap& g : gaps) out.add(g.first).add(g.count);
}

std::vector<Gap> gaps_of(ByteReader& in) {
  std::vector<Gap> gaps;
  for (std::int64_t left = in.integer(); left > 0; --left) {
    const std::int64_t first = in.integer();
    gaps.push_back({first, in.integer()});
  }
  return gaps;
}

void add(ByteWriter& out, const Record& r) {
  out.add(r.sample_rate).add(r.fire_sample).add(r.fire_offset).add(static_cast<std::int64_t>(r.overruns));
  out.add(static_cast<std::int64_t>(r.crc32)).add(static_cast<std::int64_t>(r.shot_id));
  for (const std::string* text : {&r.rig, &r.firmware, &r.calibration, &r.sealed}) out.add(*text);
  add(out, r.gaps);
  out.add(static_cast<std::int64_t>(r.channels.size())).add(static_cast<std::int64_t>(r.samples()));
  std::vector<Samples> samples;
  for (const ChannelRecord& c : r.channels) {
    out.add(static_cast<std::int64_t>(c.channel)).add(c.scale).add(c.offset).add(c.delay).add(c.corner_hertz);
    out.add(static_cast<std::int64_t>(c.clip_low)).add(static_cast<std::int64_t>(c.clip_high));
    add(out, c.gaps);
    samples.emplace_back(c.raw);
  }
  const auto packed = pack_samples(samples);
  out.add(std::string_view(reinterpret_cast<const char*>(packed.data()), packed.size()));
}

Record record_of(ByteReader& in) {
  Record r;
  r.sample_rate = in.number();
  r.fire_sample = in.integer();
  r.fire_offset = in.number();
  r.overruns = static_cast<std::uint32_t>(in.integer());
  r.crc32 = static_cast<std::uint32_t>(in.integer());
  r.shot_id = static_cast<std::uint64_t>(in.integer());
  for (std::string* text : {&r.rig, &r.firmware, &r.calibration, &r.sealed}) *text = in.text();
  r.gaps = gaps_of(in);
  const std::int64_t channels = in.integer();
  const auto samples = static_cast<std::size_t>(in.integer());
  for (std::int64_t k = 0; k < channels; ++k) {
    ChannelRecord c;
    c.channel = static_cast<Channel>(in.integer());
    for (double* x : {&c.scale, &c.offset, &c.delay, &c.corner_hertz}) *x = in.number();
    c.clip_low = static_cast<std::int16_t>(in.integer());
    c.clip_high = static_cast<std::int16_t>(in.integer());
    c.gaps = gaps_of(in);
    c.raw.resize(samples);
    r.channels.push_back(std::move(c));
  }
  std::vector<std::span<std::int16_t>> into;
  for (ChannelRecord& c : r.channels) into.emplace_back(c.raw);
  const std::string packed = in.text();
  if (!unpack_samples({reinterpret_cast<const std::uint8_t*>(packed.data()), packed.size()}, into))
    throw StoreError(
        "a point of the store holds other samples than it says; compute it anew in another store");
  return r;
}

}  // namespace

std::string bytes_of(const SimulatedPoint& p) {
  ByteWriter out;
  out.add(p.field_states)
      .add(p.field_beyond)
      .add(to_json(p.events))
      .add(p.prediction.empty() ? "" : to_json(p.prediction));
  add(out, p.record);
  return out.bytes();
}

SimulatedPoint simulated_point(const std::string& bytes, const Conditions& conditions) {
  try {
    ByteReader in(bytes);
    SimulatedPoint p;
    p.field_states = in.integer();
    p.field_beyond = in.integer();
    p.events = events_from_json(in.text());
    if (const std::string text = in.text(); !text.empty()) p.prediction = spread_from_json(text);
    p.record = record_of(in);
    p.record.conditions = conditions;
    return p;
  } catch (const std::invalid_argument& e) {
    throw StoreError(std::string("a point of the store cannot be read: ") + e.what());
  }
}

}  // namespace powbench::host
