#include "rigs/registry.h"

#include "rigs/bridge/bridge.h"
#include "rigs/bridge/served_port.h"
#include "rigs/iio_rig.h"
#include "rigs/iiod_server.h"
#include "rigs/serial_rig.h"

namespace powbench::rigs {
namespace {

/// A simulated rig is a server of its own in this process, spoken to through libiio like every other rig.
class HostedSimRig final : public Rig {
 public:
  HostedSimRig(const SimRigConfig& config, const sim::Specimen& specimen, const BoardOptions& options)
      : server_(config, specimen, options), client_(connect_iio("ip:" + server_.address())) {}

  const RigInfo& info() const override { return client_->info(); }
  Shot fire(const Conditions& c, std::chrono::milliseconds limit) override {
    return explained(client_->fire(c, limit));
  }
  std::optional<Shot> recover(std::chrono::milliseconds limit) override {
    auto shot = client_->recover(limit);
    if (shot) shot = explained(std::move(*shot));
    return shot;
  }
  bool abort() override { return client_->abort(); }
  void stop_when(std::function<bool()> asked) override { client_->stop_when(std::move(asked)); }
  /// Never to an address that the server has given up: another rig may have it by now.
  bool reconnect() override { return server_.failure().empty() && client_->reconnect(); }

 private:
  Shot explained(Shot shot) const {
    if (std::string why = shot.rig_lost ? server_.failure() : std::string(); !why.empty())
      shot.reason = std::move(why);
    return shot;
  }

  LocalRig server_;
  std::unique_ptr<Rig> client_;  // ends before its server
};

}  // namespace

Endpoint endpoint(const std::string& uri, const SimRigConfig& sim, const sim::Specimen& specimen) {
  if (is_simulated(uri)) {
    auto server =
        std::make_shared<LocalRig>(sim, specimen, uri.starts_with("qemu:") ? emulated_board : BoardOptions{});
    return {"ip:" + server->address(), server};
  }
  if (uri.starts_with("serial:")) {
    auto bridge = std::make_shared<LocalBridge>(serial_options(uri));
    return {"ip:" + bridge->address(), bridge};
  }
  return {uri, nullptr};
}

Endpoint endpoint_to_stop(const std::string& uri) {
  if (!uri.starts_with("serial:")) return {uri, nullptr};
  if (const std::string there = served_at(serial_options(uri).port); !there.empty())
    return {"ip:" + there, nullptr};
  return endpoint(uri, {}, {});
}

std::unique_ptr<Rig> open(const std::string& uri, const SimRigConfig& sim, const sim::Specimen& specimen) {
  if (uri.starts_with("sim:")) return std::make_unique<HostedSimRig>(sim, specimen, BoardOptions{});
  if (uri.starts_with("qemu:")) return std::make_unique<HostedSimRig>(sim, specimen, emulated_board);
  if (uri.starts_with("ip:") && uri.size() > 3) return connect_iio(uri);
  if (uri.starts_with("usb:")) return connect_iio(uri);
  if (uri.starts_with("serial:")) return connect_serial(uri);
  std::string known;
  for (const RigKind& kind : rig_kinds) known += (known.empty() ? "" : ", ") + std::string(kind.example);
  std::string meant;
  if (uri.find(':') == std::string::npos) {
    if (uri == "sim" || uri == "qemu")
      meant = uri + ":";
    else if (uri.starts_with("/dev/"))
      meant = "serial:" + uri;
    else if (!uri.empty())
      meant = "ip:" + uri;
  }
  if (!meant.empty()) meant = "; did you mean '" + meant + "'?";
  throw UnknownRig("unknown rig '" + uri + "'" + meant + "; a rig is named like " + known);
}

}  // namespace powbench::rigs
