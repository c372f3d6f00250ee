#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rigs/bridge/options.h"

/// From a board on a serial line to an IIO server. Debian's libiio has no serial backend, and a plain pipe
/// would mix the bytes of several clients: this one knows where a request and its answer end.

namespace powbench::rigs {

class Bridge {
 public:
  /// Opens the port, finds the board, reads its description and listens. Throws RigError with one sentence.
  explicit Bridge(const BridgeOptions&);
  ~Bridge();
  Bridge(const Bridge&) = delete;
  Bridge& operator=(const Bridge&) = delete;

  const std::string& address() const;
  /// What the board calls itself: model and serial number, as far as it says.
  std::string board() const;

  /// Serves until stop() is called from another thread, or SIGINT / SIGTERM when `until_interrupted`. Throws
  /// RigError when the port goes away.
  void serve(bool until_interrupted = false);
  void stop();
  /// Why the port is gone; empty while it is there. From any thread.
  std::string lost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A bridge in a thread of its own. Ends with the object.
class LocalBridge {
 public:
  explicit LocalBridge(const BridgeOptions&);
  ~LocalBridge();
  LocalBridge(const LocalBridge&) = delete;
  LocalBridge& operator=(const LocalBridge&) = delete;

  const std::string& address() const;
  /// Why it does not serve any more.
  std::optional<std::string> failure() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::rigs
