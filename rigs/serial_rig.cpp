#include "rigs/serial_rig.h"

#include <charconv>
#include <memory>

#include "rigs/bridge/bridge.h"
#include "rigs/iio_rig.h"

namespace powbench::rigs {
namespace {

constexpr std::string_view scheme = "serial:";

class SerialRig final : public Rig {
 public:
  explicit SerialRig(std::string uri)
      : uri_(std::move(uri)),
        options_(serial_options(uri_)),
        bridge_(std::make_unique<LocalBridge>(options_)) {
    options_.address = bridge_->address();  // the client remembers it
    client_ = connect_iio("ip:" + options_.address);
    learn();
  }

  const RigInfo& info() const override { return info_; }

  Shot fire(const Conditions& conditions, std::chrono::milliseconds limit) override {
    return explained(client_->fire(conditions, limit));
  }

  std::optional<Shot> recover(std::chrono::milliseconds limit) override {
    auto shot = client_->recover(limit);
    if (shot) shot = explained(std::move(*shot));
    return shot;
  }

  bool abort() override { return client_->abort(); }
  void stop_when(std::function<bool()> asked) override { client_->stop_when(std::move(asked)); }

  bool reconnect() override {
    try {
      if (!bridge_ || bridge_->failure()) {
        bridge_.reset();
        bridge_ = std::make_unique<LocalBridge>(options_);
      }
    } catch (const RigError& e) {
      absent_ = e.what();
      return false;
    }
    if (!client_->reconnect()) return false;
    learn();
    return true;
  }

 private:
  /// The bridge knows better than its client why nobody answers any more.
  Shot explained(Shot shot) const {
    if (shot.rig_lost)
      if (const auto why = failure()) shot.reason = *why;
    return shot;
  }
  std::optional<std::string> failure() const { return bridge_ ? bridge_->failure() : absent_; }
  void learn() {
    info_ = client_->info();
    info_.uri = uri_;
    absent_.reset();
  }

  std::string uri_;
  BridgeOptions options_;
  std::unique_ptr<LocalBridge> bridge_;  ///< null: the port could not be opened again
  std::optional<std::string> absent_;    ///< why not
  std::unique_ptr<Rig> client_;          // ends before its bridge
  RigInfo info_;
};

}  // namespace

BridgeOptions serial_options(const std::string& uri) {
  const std::string_view rest = std::string_view(uri).substr(scheme.size());
  const std::size_t comma = rest.find(',');
  BridgeOptions options;
  options.port = std::string(rest.substr(0, comma));
  if (options.port.empty())
    throw RigError("'" + uri + "' names no serial port; write it like serial:/dev/ttyACM0,2000000");
  if (comma == std::string_view::npos) return options;
  const std::string_view rate = rest.substr(comma + 1);
  const auto [end, error] = std::from_chars(rate.data(), rate.data() + rate.size(), options.baud);
  if (error != std::errc{} || end != rate.data() + rate.size() || options.baud < 1200 ||
      options.baud > 4'000'000)
    throw RigError("baud rate '" + std::string(rate) + "' in '" + uri +
                   "' is not a number from 1200 to 4000000; the line is always 8n1");
  return options;
}

std::unique_ptr<Rig> connect_serial(const std::string& uri) {
  return std::make_unique<SerialRig>(uri);
}

}  // namespace powbench::rigs
