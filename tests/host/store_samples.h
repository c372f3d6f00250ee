#pragma once

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/random.h"
#include "host/store/store.h"

/// What the store's tests put in and compare.

namespace powbench::host {

/// A folder of its own that goes away with the test. In memory where the machine offers that: these tests flush
/// thousands of times, and what they show does not depend on the disk.
class Folder {
 public:
  Folder() {
    const std::filesystem::path memory = "/dev/shm";
    const bool usable = access(memory.c_str(), W_OK | X_OK) == 0;
    std::string name =
        ((usable ? memory : std::filesystem::temp_directory_path()) / "powbench-store-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name = "bench.db") const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A record of every channel with noise-like samples, the extremes among them.
inline Record sample_record(std::uint64_t seed, std::size_t samples = 150) {
  Random random(seed);
  Record r;
  r.sample_rate = 100e3;
  r.fire_sample = 400;
  r.fire_offset = 3.7e-6;
  for (std::size_t k = 0; k < channel_count; ++k) {
    ChannelRecord c;
    c.channel = static_cast<Channel>(k);
    c.scale = (random.uniform() - 0.5) / 3.0;
    c.offset = random.uniform() * 10;
    c.delay = 82e-6 * random.uniform();
    c.corner_hertz = k < 2 ? 0.5 : 0.0;
    c.clip_low = -32000;
    c.clip_high = 31000;
    for (std::size_t i = 0; i < samples; ++i) c.raw.push_back(static_cast<std::int16_t>(random.below(65536)));
    c.raw.front() = -32768;
    c.raw.back() = 32767;
    r.channels.push_back(std::move(c));
  }
  r.gaps = {{10, 3}, {static_cast<std::int64_t>(samples) - 1, 1}};
  r.overruns = 4;
  r.crc32 = 0xFFFF0001U;
  r.shot_id = 77;
  r.rig = "bench \"A\", SIM-0001";
  r.firmware = "0.1.0";
  r.calibration = "2026-01";
  r.sealed = "powbench_shot=1 shot=77 seal=00000000";
  return r;
}

/// Events with values that need all 17 digits, and with unknown ones.
inline Events sample_events(std::uint64_t seed) {
  Random random(seed);
  const auto value = [&] { return Measured{random.normal() / 3.0, random.uniform() * 1e-7}; };
  Events e;
  e.pvdf_a.present = true;
  for (int i = 0; i < 3; ++i)
    e.pvdf_a.contacts.push_back(
        {value(), i < 2 ? value() : Measured{}, value(), value(), flag_clipped | flag_edge});
  e.pvdf_a.settled = value();
  e.pvdf_a.settled_force = value();
  e.pvdf_a.bounce_time = value();
  e.pvdf_a.bounce_count = 2;
  e.pvdf_a.first_train = {.openings = 2, .from = value(), .to = value()};
  e.pvdf_a.second_train = {.openings = 1, .from = value(), .to = {}};
  e.pvdf_a.resolution = 1.0 / 3.0;
  e.pvdf_a.noise = 5e-324;
  e.contact_voltage.present = true;
  e.contact_voltage.flags = flag_contradiction;
  e.pole.by_force = e.pvdf_a;
  e.pole.by_force.settled = value();
  e.pole.disagreement = value();
  e.pole.longest_disagreement = value();
  e.core.present = true;
  e.core.seat = value();
  e.core.travel = {1.7976931348623157e308, -0.0};
  e.coil.closing_angle = value();
  e.coil.flags = flag_angle_off;
  e.method = "pvdf-chain";
  e.parameters_hash = "0123";
  e.flags = flag_gap;
  return e;
}

/// Equal bit for bit, where any NaN is as good as any other.
inline bool same(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || std::memcmp(&a, &b, sizeof a) == 0;
}
inline bool same(const Measured& a, const Measured& b) {
  return same(a.value, b.value) && same(a.u, b.u);
}

inline bool same(const BounceTrain& a, const BounceTrain& b) {
  return a.openings == b.openings && same(a.from, b.from) && same(a.to, b.to);
}

inline bool same(const ContactTrain& a, const ContactTrain& b) {
  bool equal = a.present == b.present && a.contacts.size() == b.contacts.size() &&
               same(a.settled, b.settled) && same(a.settled_force, b.settled_force) &&
               same(a.bounce_time, b.bounce_time) && a.bounce_count == b.bounce_count &&
               same(a.resolution, b.resolution) && same(a.noise, b.noise) && a.flags == b.flags &&
               same(a.first_train, b.first_train) && same(a.second_train, b.second_train);
  for (std::size_t i = 0; equal && i < a.contacts.size(); ++i) {
    const auto &x = a.contacts[i], &y = b.contacts[i];
    equal = same(x.touch, y.touch) && same(x.release, y.release) && same(x.peak, y.peak) &&
            same(x.impulse, y.impulse) && x.flags == y.flags && x.probability == y.probability;
  }
  return equal;
}

inline bool same(const Events& a, const Events& b) {
  const auto &c = a.core, &d = b.core;
  const auto &x = a.coil, &y = b.coil;
  return same(a.pvdf_a, b.pvdf_a) && same(a.pvdf_b, b.pvdf_b) && same(a.contact_voltage, b.contact_voltage) &&
         same(a.pole.by_force, b.pole.by_force) && same(a.pole.disagreement, b.pole.disagreement) &&
         same(a.pole.longest_disagreement, b.pole.longest_disagreement) && c.present == d.present &&
         same(c.seat, d.seat) && same(c.settled, d.settled) && same(c.bounce_time, d.bounce_time) &&
         same(c.impact_velocity, d.impact_velocity) && same(c.travel, d.travel) && c.flags == d.flags &&
         same(x.closing_angle, y.closing_angle) && same(x.switch_on, y.switch_on) &&
         same(x.mains_hertz, y.mains_hertz) && same(x.supply_volts, y.supply_volts) &&
         same(x.peak_current, y.peak_current) && x.flags == y.flags && a.method == b.method &&
         a.parameters_hash == b.parameters_hash && a.flags == b.flags;
}

inline bool same(const Conditions& a, const Conditions& b) {
  return same(a.supply_volts, b.supply_volts) && same(a.mains_hertz, b.mains_hertz) &&
         same(a.closing_angle, b.closing_angle) && a.polarity == b.polarity &&
         same(a.hold_time, b.hold_time) && same(a.ambient, b.ambient) && a.specimen == b.specimen &&
         a.seed == b.seed;
}

/// Samples only: what the content hash guards.
inline bool same_samples(const Record& a, const Record& b) {
  bool equal = a.channels.size() == b.channels.size();
  for (std::size_t k = 0; equal && k < a.channels.size(); ++k) equal = a.channels[k].raw == b.channels[k].raw;
  return equal;
}

/// Everything but the conditions, which belong to the shot.
inline bool same(const Record& a, const Record& b) {
  bool equal = same_samples(a, b) && same(a.sample_rate, b.sample_rate) && a.fire_sample == b.fire_sample &&
               same(a.fire_offset, b.fire_offset) && a.gaps.size() == b.gaps.size() &&
               a.overruns == b.overruns && a.crc32 == b.crc32 && a.shot_id == b.shot_id && a.rig == b.rig &&
               a.firmware == b.firmware && a.calibration == b.calibration;
  for (std::size_t i = 0; equal && i < a.gaps.size(); ++i)
    equal = a.gaps[i].first == b.gaps[i].first && a.gaps[i].count == b.gaps[i].count;
  for (std::size_t k = 0; equal && k < a.channels.size(); ++k) {
    const auto &x = a.channels[k], &y = b.channels[k];
    equal = x.channel == y.channel && same(x.scale, y.scale) && same(x.offset, y.offset) &&
            same(x.delay, y.delay) && same(x.corner_hertz, y.corner_hertz) && x.clip_low == y.clip_low &&
            x.clip_high == y.clip_high;
  }
  return equal;
}

inline CampaignInfo sample_campaign(const std::string& name = "demo") {
  CampaignInfo c;
  c.name = name;
  c.plan = "repeats = 3\n";
  c.plan_hash = "plan-" + name;
  c.specimen = "name = \"reference\"\n";
  c.specimen_hash = "specimen-" + name;
  c.rig_file = "x = 1\n";
  c.rig_uri = "sim:";
  c.rig_identity = "simulated, SIM-0001";
  c.program_version = "0.1.0";
  return c;
}

inline StoredShot sample_shot(std::int64_t campaign, int number, Outcome outcome = Outcome::pass) {
  StoredShot s;
  s.campaign = campaign;
  s.number = number;
  s.repeat = number / 7;
  s.angle_deg = 30.0 * (number % 7);
  s.conditions.closing_angle = radians(s.angle_deg);
  s.conditions.seed = 9007199254740991ULL - static_cast<unsigned>(number);
  s.conditions.hold_time = 0.1 + 1e-17;
  s.outcome = outcome;
  s.reason = outcome == Outcome::pass ? "" : "the rig did not answer";
  return s;
}

/// Shots 0 .. count - 1 of a new campaign, each with the record and the events of its number as seed.
inline std::int64_t fill(Store& store, int count, std::size_t samples = 150) {
  const auto campaign = store.create_campaign(sample_campaign());
  for (int i = 0; i < count; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const Record record = sample_record(seed, samples);
    const Events events = sample_events(seed);
    store.store_shot(sample_shot(campaign, i), &record, &events, {"cutoff = 1\n", "0.1.0"});
  }
  return campaign;
}

}  // namespace powbench::host
