#include "python/binding/waveforms.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "host/config/bad_input.h"
#include "python/binding/binding.h"

namespace powbench::python {

namespace {

WaveformClock clock_of(const Record& r) {
  return {r.sample_rate, r.fire_sample, r.samples(), r.fire_offset};
}

std::string text(std::int64_t shot, const WaveformClock& c) {
  return "shot " + std::to_string(shot) + " has " + std::to_string(c.samples) + " samples at " +
         std::to_string(c.sample_rate) + " Hz, switched on at sample " + std::to_string(c.fire_sample);
}

/// One shot's row in every array.
template <class Float>
void fill_row(const Record& r, std::span<const Channel> channels, std::size_t row,
              std::span<Float* const> to) {
  for (std::size_t k = 0; k < channels.size(); ++k) {
    Float* const place = to[k] + row * r.samples();
    if (const ChannelRecord* c = r.find(channels[k]))
      fill_values(r, *c, place);
    else
      std::fill_n(place, r.samples(), std::numeric_limits<Float>::quiet_NaN());
  }
}

}  // namespace

WaveformClock clock_of(const host::Store& store, std::int64_t shot) {
  return clock_of(store.load_record(shot));
}

template <class Float>
void fill_waveforms(const std::string& path, std::span<const std::int64_t> ids,
                    std::span<const Channel> channels, const WaveformClock& clock, std::span<Float* const> to,
                    std::span<WaveformClock> clocks, int threads) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr trouble;
  const auto work = [&] {
    try {
      const host::Store store(path, host::Store::Mode::read_only);
      for (std::size_t i = next++; i < ids.size(); i = next++) {
        const Record r = store.load_record(ids[i]);
        clocks[i] = clock_of(r);
        if (clocks[i].samples != clock.samples || clocks[i].sample_rate != clock.sample_rate ||
            clocks[i].fire_sample != clock.fire_sample)
          throw host::BadInput({text(ids[i], clocks[i]) + "; " + text(ids.front(), clock) +
                                ": they do not share a time axis; read them one by one with record()"});
        fill_row(r, channels, i, to);
      }
    } catch (...) {
      next = ids.size();  // the others stop
      const std::scoped_lock lock(mutex);
      if (!trouble) trouble = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  const auto most = static_cast<std::size_t>(std::max(threads, 1));
  for (std::size_t t = 0; t < std::min(most, ids.size()); ++t) pool.emplace_back(work);
  for (auto& t : pool) t.join();
  if (trouble) std::rethrow_exception(trouble);
}
template void fill_waveforms<float>(const std::string&, std::span<const std::int64_t>,
                                    std::span<const Channel>, const WaveformClock&, std::span<float* const>,
                                    std::span<WaveformClock>, int);
template void fill_waveforms<double>(const std::string&, std::span<const std::int64_t>,
                                     std::span<const Channel>, const WaveformClock&, std::span<double* const>,
                                     std::span<WaveformClock>, int);

}  // namespace powbench::python
