#include "firmware/phase_feed.h"

namespace powbench::firmware {

void PhaseFeed::reset() {
  tracker_.reset();
  sum_ = summed_ = 0;
  dropped_ = 0;
  head_ = tail_ = 0;
  gaps_seen_ = gaps_done_ = 0;
  newest_ = suspicious_ = 0;
  published_[0] = {no_estimate(nominal_hertz_), 0};
}

void PhaseFeed::push(const Block& block) {
  const std::int16_t* from = block.scans.data() + index(Channel::mains_voltage);
  auto left = static_cast<std::int32_t>(block.samples());
  while (left > 0) {
    const std::int32_t wanted = decimation_ - summed_;
    const std::int32_t taken = left < wanted ? left : wanted;
    std::int32_t sum = sum_;
    for (const std::int16_t* end = from + taken * static_cast<std::int32_t>(channel_count); from != end;
         from += channel_count)
      sum += *from;
    sum_ = sum;
    summed_ += taken;
    left -= taken;
    if (summed_ < decimation_) return;
    sum_ = summed_ = 0;
    put({sum, 0});
  }
}

void PhaseFeed::put(Entry entry) {
  // room for two: what did not fit before has to be told first
  if (slots - (head_ - load_shared(tail_)) < 2) {
    dropped_ += entry.gap != 0 ? entry.value : decimation_;
    return;
  }
  if (dropped_ > 0) {
    doubt();
    queue_[head_ % slots] = {static_cast<std::int32_t>(dropped_), gaps_seen_};
    dropped_ = 0;
    store_shared(head_, head_ + 1);
  }
  queue_[head_ % slots] = entry;
  store_shared(head_, head_ + 1);
}

/// The estimate is not valid from here on, whatever the tracker still publishes of the time before.
void PhaseFeed::doubt() {
  until_then_ = estimate();
  until_then_.faults |= static_cast<std::uint16_t>(PhaseFault::gap);
  ++gaps_seen_;
}

void PhaseFeed::mark_gap(std::int64_t lost) {
  doubt();
  // what was summed so far has no place in the history either
  lost += summed_;
  sum_ = summed_ = 0;
  put({static_cast<std::int32_t>(lost), gaps_seen_});
}

void PhaseFeed::work() {
  while (tail_ != load_shared(head_)) {
    const Entry entry = queue_[tail_ % slots];
    store_shared(tail_, tail_ + 1);
    if (entry.gap != 0) {
      tracker_.mark_gap(entry.value);
      gaps_done_ = entry.gap;
      continue;
    }
    const bool due = tracker_.push_sum(entry.value);
    store_shared(suspicious_, std::uint32_t{tracker_.suspicious()});
    if (!due) continue;
    tracker_.update();
    const std::uint32_t other = 1 - newest_;
    published_[other] = {tracker_.estimate(), gaps_done_};
    store_shared(newest_, other);
  }
}

}  // namespace powbench::firmware
