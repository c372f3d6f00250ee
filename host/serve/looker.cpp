#include "host/serve/looker.h"

#include <algorithm>
#include <chrono>

namespace powbench::host {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds line_time{1500};
constexpr milliseconds look_interval{100};
constexpr std::size_t kept_answers = 100;
constexpr double slow_line_ms = 30;  ///< a line that needs longer is spared the raw readings

}  // namespace

Looker::Looker(std::string uri, std::function<void()> changed, std::function<void(const std::string&)> said)
    : uri_(std::move(uri)),
      changed_(std::move(changed)),
      said_(std::move(said)),
      thread_([this] { work(); }) {}

Looker::~Looker() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Looker::work() {
  std::unique_ptr<rigs::RigWatch> line;
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const bool fast = look_.answer_ms < slow_line_ms;
    lock.unlock();
    Look seen;
    const auto asked = Clock::now();
    const bool connecting = !line;
    try {
      if (!line) {
        line = std::make_unique<rigs::RigWatch>(uri_, line_time);
        seen.info = line->info();
      }
      seen.status = line->status();
      if (fast && !seen.status->live()) seen.now = line->latest();
    } catch (const rigs::RigError& e) {
      line.reset();
      seen.status.reset();
      seen.error = e.what();
    }
    const double took = std::chrono::duration<double, std::milli>(Clock::now() - asked).count();
    lock.lock();
    if (asked < told_ && seen.status) seen.status = look_.status;
    const bool first = look_.looks == 0, answered = look_.status.has_value();
    const bool news =
        first || seen.status != look_.status || seen.error != look_.error || seen.now != look_.now;
    look_.status = seen.status;
    look_.error = seen.error;
    look_.now = seen.now;
    look_.answer_ms = took;
    ++look_.looks;
    if (seen.info) look_.info = seen.info;
    if (connecting && seen.status) ++look_.connections;
    if (answered && !seen.status) ++look_.lost;
    if (seen.status && !connecting) answers_.push_back(took);
    if (answers_.size() > kept_answers) answers_.pop_front();
    std::vector<double> sorted(answers_.begin(), answers_.end());
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty()) look_.median_ms = sorted[sorted.size() / 2], look_.worst_ms = sorted.back();
    lock.unlock();
    if (first || answered != seen.status.has_value())
      said_(seen.status ? "the rig answers" : "the rig does not answer: " + seen.error);
    if (news) changed_();
    lock.lock();
    wake_.wait_for(lock, look_interval, [this] { return ending_; });
  }
}

void Looker::coil_is_off(const std::string& state) {
  const std::scoped_lock lock(mutex_);
  told_ = Clock::now();
  if (!look_.status) return;
  look_.status->state = state;
  look_.status->gate = "0";
  look_.status->relay = look_.status->ready = "";  // until the next look
}

Looker::Look Looker::look() const {
  const std::scoped_lock lock(mutex_);
  return look_;
}

std::vector<std::pair<std::string, std::string>> Looker::attributes() {
  const std::scoped_lock one(reading_);
  rigs::RigWatch line(uri_, line_time);
  return line.attributes();
}

}  // namespace powbench::host
