#include "rigs/rig_watch.h"

#include <utility>

#include "rigs/iio_link.h"

namespace powbench::rigs {

struct RigWatch::Impl {
  Impl(const std::string& address, std::chrono::milliseconds limit, std::chrono::milliseconds request)
      : uri(address), link(address, limit, request) {}

  template <class Ask>
  auto ask(Ask&& what) try {
    return what(link);
  } catch (const LinkBroken& b) {
    throw RigError(uri + ": " + b.sentence);
  } catch (const Refusal& r) {
    throw RigError(uri + ": " + sentence(r));
  }

  std::string uri;
  IioLink link;
};

RigWatch::RigWatch(const std::string& uri, std::chrono::milliseconds limit, std::chrono::milliseconds request)
    : impl_(std::make_unique<Impl>(uri, limit, request)) {}
RigWatch::~RigWatch() = default;

RigInfo RigWatch::info() {
  return impl_->link.read_info(impl_->uri);
}

RigStatus RigWatch::status() {
  return impl_->ask([](IioLink& link) {
    constexpr auto control = IioLink::Device::control;
    RigStatus s;
    s.state = link.read(control, "state");
    s.fault = link.read(control, "fault");
    s.phase = link.phase();
    s.owner = link.read(control, "lease");
    s.last_error = link.read(control, "last_error");
    return s;
  });
}

std::string RigWatch::state() {
  return impl_->ask([](IioLink& link) { return link.read(IioLink::Device::control, "state"); });
}

void RigWatch::stop() {
  impl_->ask([](IioLink& link) { link.write(IioLink::Device::control, "abort", "1"); });
}

}  // namespace powbench::rigs
