#include <unistd.h>

#include <mutex>
#include <string>
#include <thread>

#include "rigs/iiod_server.h"

namespace powbench::rigs {

namespace {

/// The loopback network of this process, up to its last number. Another one hardly has the same (15 bits of the id):
/// a process whose own rig has just gone would find this one in its place, and stop it.
std::string own_network() {
  const auto id = static_cast<unsigned>(getpid());
  return "127." + std::to_string(64 + (id >> 8) % 128) + "." + std::to_string(id & 255) + ".";
}

}  // namespace

struct LocalRig::Impl {
  std::unique_ptr<IiodServer> server;
  std::thread thread;
  mutable std::mutex lock;  ///< of `failure`
  std::string failure;
};

LocalRig::LocalRig(const SimRigConfig& config, const sim::Specimen& specimen, const BoardOptions& options)
    : impl_(std::make_unique<Impl>()) {
  std::string last_error;
  const std::string network = own_network();
  for (int host = 2; host < 255 && !impl_->server; ++host) {
    try {
      impl_->server =
          std::make_unique<IiodServer>(config, specimen, network + std::to_string(host), iiod_port, options);
    } catch (const AddressError& e) {
      last_error = e.what();
    }
  }
  if (!impl_->server) throw RigError("no loopback address is free for a simulated rig: " + last_error);
  impl_->thread = std::thread([this] {
    try {
      impl_->server->serve();
    } catch (const RigError& e) {
      const std::lock_guard hold(impl_->lock);
      impl_->failure = e.what();
    }
  });
}

LocalRig::~LocalRig() {
  impl_->server->stop();
  impl_->thread.join();
}

std::string LocalRig::failure() const {
  const std::lock_guard hold(impl_->lock);
  return impl_->failure;
}

const std::string& LocalRig::address() const {
  return impl_->server->address();
}

}  // namespace powbench::rigs
