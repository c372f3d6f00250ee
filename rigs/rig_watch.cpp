#include "rigs/rig_watch.h"

#include <charconv>
#include <optional>
#include <utility>

#include "rigs/iio_link.h"
#include "rigs/phase_words.h"

namespace powbench::rigs {
namespace {

std::optional<double> counts_of(IioLink& link, Channel channel) {
  const std::string text = link.read_channel(channel, "raw");
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} ? std::optional(value) : std::nullopt;
}

}  // namespace

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
    s.owner = link.read(control, "lease");
    s.last_error = link.read(control, "last_error");
    s.hertz = link.read_if_there(IioLink::Device::daq, "mains_frequency");
    s.phase_u = link.read_if_there(control, "phase_u_millideg");
    s.phase_faults = link.read_if_there(control, "phase_faults");
    s.phase = phase_words(s.phase_faults, s.phase_u);
    s.gate = link.read_if_there(control, "gate");
    s.relay = link.read_if_there(control, "safety_relay");
    s.ready = link.read_if_there(control, "ready");
    s.tolerance = link.read_if_there(control, "angle_tolerance_millideg");
    return s;
  });
}

std::vector<std::pair<Channel, double>> RigWatch::latest() {
  return impl_->ask([](IioLink& link) {
    std::vector<std::pair<Channel, double>> all;
    for (std::size_t c = 0; c < channel_count; ++c) {
      const auto channel = static_cast<Channel>(c);
      if (const auto counts = counts_of(link, channel)) all.emplace_back(channel, *counts);
    }
    return all;
  });
}

double RigWatch::newest(Channel channel) {
  const auto counts = impl_->ask([&](IioLink& link) { return counts_of(link, channel); });
  if (!counts)
    throw RigError(impl_->uri + ": channel " + std::string(powbench::info(channel).name) +
                   " tells no number");
  return *counts;
}

std::vector<std::pair<std::string, std::string>> RigWatch::attributes() {
  return impl_->ask([](IioLink& link) { return link.read_all(); });
}

std::string RigWatch::state() {
  return impl_->ask([](IioLink& link) { return link.read(IioLink::Device::control, "state"); });
}

void RigWatch::stop() {
  impl_->ask([](IioLink& link) { link.write(IioLink::Device::control, "abort", "1"); });
}

}  // namespace powbench::rigs
