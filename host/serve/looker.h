#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/channels.h"
#include "rigs/rig_watch.h"

namespace powbench::host {

/// Looks at the rig ten times a second, on a line and a thread of its own, and counts how the line fares. Every
/// function may be called from any thread.
class Looker {
 public:
  /// `changed`: something that look() returns is different; `said`: a sentence for the log, when the rig is found and
  /// lost.
  Looker(std::string uri, std::function<void()> changed, std::function<void(const std::string&)> said);
  ~Looker();
  Looker(const Looker&) = delete;
  Looker& operator=(const Looker&) = delete;

  struct Look {
    std::optional<rigs::RigStatus> status;        ///< nothing: the rig does not answer
    std::optional<rigs::RigInfo> info;            ///< of the newest connection
    std::string error;                            ///< why it does not answer
    std::vector<std::pair<Channel, double>> now;  ///< newest conversion of each channel, counts
    std::size_t looks = 0, connections = 0, lost = 0;
    double answer_ms = 0, median_ms = 0, worst_ms = 0;  ///< newest, and of the newest 100 looks
  };
  Look look() const;
  /// Another line has read just now that the rig is in this state, and its gate off: what was read before is older.
  void coil_is_off(const std::string& state);
  /// Every attribute of the rig, on a line of its own. Throws RigError.
  std::vector<std::pair<std::string, std::string>> attributes();

 private:
  void work();

  const std::string uri_;
  const std::function<void()> changed_;
  const std::function<void(const std::string&)> said_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  Look look_;
  std::chrono::steady_clock::time_point told_{};
  std::deque<double> answers_;
  std::mutex reading_;  ///< one reader of attributes at a time
  std::thread thread_;
};

}  // namespace powbench::host
