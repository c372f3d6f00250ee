#include <fmt/format.h>
#ifdef POWBENCH_PACKING_PEERS
#include <lz4.h>
#include <zstd.h>
#endif

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/dsp_rig_truth.h"
#include "core/cpu_time.h"
#include "host/store/hash.h"
#include "host/store/packing.h"

/// Ways to keep the samples of a record without loss: share of the bare bytes, CPU rate of packing and unpacking, in
/// MB of bare samples a second. Records of the simulated rig with the noise of its sensors, at twelve angles.
/// Usage: bench_store_packing [--json PATH]

namespace {

using namespace powbench;
using Bytes = std::vector<std::uint8_t>;

struct Method {
  std::string name;
  std::function<Bytes(const Record&)> pack;
  std::function<void(const Bytes&, Record&)> unpack;  ///< into a record of the right size
};

Bytes scans(const Record& r) {
  Bytes out(2 * r.channels.size() * r.samples());
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    for (std::size_t i = 0; i < r.samples(); ++i)
      std::memcpy(&out[2 * (i * r.channels.size() + k)], &r.channels[k].raw[i], 2);
  return out;
}

void from_scans(const Bytes& bytes, Record& r) {
  for (std::size_t k = 0; k < r.channels.size(); ++k)
    for (std::size_t i = 0; i < r.samples(); ++i)
      std::memcpy(&r.channels[k].raw[i], &bytes[2 * (i * r.channels.size() + k)], 2);
}

Bytes ours(const Record& r) {
  std::vector<host::Samples> channels;
  for (const auto& c : r.channels) channels.emplace_back(c.raw);
  return host::pack_samples(channels);
}

void ours_back(const Bytes& bytes, Record& r) {
  std::vector<std::span<std::int16_t>> channels;
  for (auto& c : r.channels) channels.emplace_back(c.raw);
  if (!host::unpack_samples(bytes, channels)) std::abort();
}

#ifdef POWBENCH_PACKING_PEERS
/// All low bytes of a channel, then all its high ones; with `delta`, of the differences.
Bytes shuffled(const Record& r, bool delta) {
  Bytes out;
  for (const auto& c : r.channels) {
    const std::size_t n = c.raw.size(), at = out.size();
    out.resize(at + 2 * n);
    std::uint16_t before = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto x = static_cast<std::uint16_t>(c.raw[i]);
      const auto v = static_cast<std::uint16_t>(delta ? x - before : x);
      before = x;
      out[at + i] = static_cast<std::uint8_t>(v);
      out[at + n + i] = static_cast<std::uint8_t>(v >> 8);
    }
  }
  return out;
}

void unshuffled(const Bytes& bytes, Record& r, bool delta) {
  std::size_t at = 0;
  for (auto& c : r.channels) {
    const std::size_t n = c.raw.size();
    std::uint16_t sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto v = static_cast<std::uint16_t>(bytes[at + i] | bytes[at + n + i] << 8);
      sum = static_cast<std::uint16_t>(delta ? sum + v : v);
      c.raw[i] = static_cast<std::int16_t>(sum);
    }
    at += 2 * n;
  }
}

Bytes zstd(const Bytes& in, int level) {
  Bytes out(ZSTD_compressBound(in.size()));
  out.resize(ZSTD_compress(out.data(), out.size(), in.data(), in.size(), level));
  return out;
}

Bytes lz4(const Bytes& in) {
  Bytes out(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(in.size()))));
  out.resize(static_cast<std::size_t>(
      LZ4_compress_default(reinterpret_cast<const char*>(in.data()), reinterpret_cast<char*>(out.data()),
                           static_cast<int>(in.size()), static_cast<int>(out.size()))));
  return out;
}

Bytes unzstd(const Bytes& in, std::size_t size) {
  Bytes out(size);
  ZSTD_decompress(out.data(), size, in.data(), in.size());
  return out;
}

Bytes unlz4(const Bytes& in, std::size_t size) {
  Bytes out(size);
  LZ4_decompress_safe(reinterpret_cast<const char*>(in.data()), reinterpret_cast<char*>(out.data()),
                      static_cast<int>(in.size()), static_cast<int>(size));
  return out;
}

std::size_t bare(const Record& r) {
  return 2 * r.channels.size() * r.samples();
}
#endif

std::vector<Method> methods() {
  std::vector<Method> list{{"bare scans", scans, from_scans}};
#ifdef POWBENCH_PACKING_PEERS
  list.push_back({"lz4 of the scans", [](const Record& r) { return lz4(scans(r)); },
                  [](const Bytes& b, Record& r) { from_scans(unlz4(b, bare(r)), r); }});
  for (const int level : {1, 3, 9})
    list.push_back({fmt::format("zstd -{} of the scans", level),
                    [level](const Record& r) { return zstd(scans(r), level); },
                    [](const Bytes& b, Record& r) { from_scans(unzstd(b, bare(r)), r); }});
  for (const bool delta : {false, true}) {
    const std::string what = delta ? "differences, bytes shuffled, " : "bytes shuffled, ";
    list.push_back({what + "lz4", [delta](const Record& r) { return lz4(shuffled(r, delta)); },
                    [delta](const Bytes& b, Record& r) { unshuffled(unlz4(b, bare(r)), r, delta); }});
    for (const int level : {1, 3, 9})
      list.push_back({fmt::format("{}zstd -{}", what, level),
                      [delta, level](const Record& r) { return zstd(shuffled(r, delta), level); },
                      [delta](const Bytes& b, Record& r) { unshuffled(unzstd(b, bare(r)), r, delta); }});
  }
#endif
  list.push_back({"blocks of 64, differences in bits (the store's)", ours, ours_back});
  return list;
}

/// Median CPU seconds of one call.
template <class F>
double cost(F&& call) {
  std::vector<double> s;
  for (int i = 0; i < 15; ++i) {
    const double from = thread_cpu_seconds();
    call();
    s.push_back(thread_cpu_seconds() - from);
  }
  std::nth_element(s.begin(), s.begin() + 7, s.end());
  return s[7];
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Record> records;
  for (int i = 0; i < 12; ++i)
    records.push_back(
        bench::rig_record(100e3, radians(30.0 * i), 50.0, static_cast<std::uint64_t>(i)).record);
  double all = 0;
  for (const Record& r : records) all += static_cast<double>(2 * r.channels.size() * r.samples());
  fmt::print(
      "{} records of 8 channels, {:.0f} kB of samples each; MB of bare samples a CPU second, medians of "
      "15\n\n",
      records.size(), all / 1e3 / static_cast<double>(records.size()));
  fmt::print("{:<48} {:>8} {:>10} {:>10}\n", "method", "size %", "pack MB/s", "unpack MB/s");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Method& m : methods()) {
    double packed = 0, there = 0, back = 0;
    for (const Record& r : records) {
      const Bytes bytes = m.pack(r);
      Record again = r;
      for (auto& c : again.channels) std::fill(c.raw.begin(), c.raw.end(), std::int16_t{});
      m.unpack(bytes, again);
      for (std::size_t k = 0; k < r.channels.size(); ++k)
        if (again.channels[k].raw != r.channels[k].raw) {
          fmt::print(stderr, "{}: not the same samples\n", m.name);
          return 1;
        }
      packed += static_cast<double>(bytes.size());
      there += cost([&] { m.pack(r); });
      back += cost([&] { m.unpack(bytes, again); });
    }
    fmt::print("{:<48} {:>8.1f} {:>10.0f} {:>10.0f}\n", m.name, 100 * packed / all, all / there / 1e6,
               all / back / 1e6);
    rows.push_back({{"method", m.name},
                    {"size_percent", 100 * packed / all},
                    {"pack_MB_per_s", all / there / 1e6},
                    {"unpack_MB_per_s", all / back / 1e6}});
  }
  double hashing = 0;
  for (const Record& r : records) {
    const Bytes bytes = scans(r);
    hashing += cost([&] { host::sha256_hex(bytes); });
  }
  fmt::print("\nfor comparison: the SHA-256 of the bare samples, {:.0f} MB/s\n", all / hashing / 1e6);
#ifndef POWBENCH_PACKING_PEERS
  fmt::print("built without liblz4 and libzstd: their rows are missing\n");
#endif
  if (argc == 3 && std::string(argv[1]) == "--json")
    std::ofstream(argv[2])
        << nlohmann::ordered_json{{"rows", rows}, {"sha256_MB_per_s", all / hashing / 1e6}}.dump(2) << '\n';
  return 0;
}
