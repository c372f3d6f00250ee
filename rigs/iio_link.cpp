#include "rigs/iio_link.h"

#include <iio.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstring>
#include <future>
#include <thread>

#include "core/channels.h"
#include "rigs/phase_words.h"

/// The only file that knows libiio.

namespace powbench::rigs {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t longest_value = 4096;

struct ContextDeleter {
  void operator()(iio_context* c) const { iio_context_destroy(c); }
};
struct BufferDeleter {
  void operator()(iio_buffer* b) const { iio_buffer_destroy(b); }
};
using ContextPtr = std::unique_ptr<iio_context, ContextDeleter>;
using BufferPtr = std::unique_ptr<iio_buffer, BufferDeleter>;

bool is_refusal(int error) {
  return error == EBUSY || error == EAGAIN || error == EPERM || error == ERANGE;
}

std::string broken_sentence(int error, const std::string& doing) {
  switch (error) {
    case EPIPE:
    case ECONNRESET:
    case ENOTCONN:
      return "the rig went away while " + doing + "; check that it is running and the cable is in";
    case ECONNREFUSED:
      return "nothing listens there; start the rig or correct the address";
    case ETIMEDOUT:
      return "the rig did not answer in time while " + doing;
    case ENXIO:
      return "there is no host of that name; check the address";
    case EHOSTUNREACH:
    case ENETUNREACH:
      return "no route to the rig; check the address and the network";
    case EBUSY:
      return "the rig is busy: all of its connections may be taken (" + doing + ")";
    case ENODEV:
    case ENOENT:
      return "this rig lacks what is needed for " + doing + "; is it a powbench rig?";
    default:
      return "the rig's answer makes no sense while " + doing +
             (error != 0 ? std::string(" (") + std::strerror(error) + ")" : std::string());
  }
}

[[noreturn]] void broken(int error, const std::string& doing) {
  throw LinkBroken{error, broken_sentence(error, doing)};
}

/// libiio keeps and edits the text it is given: hand it a copy of its own. Runs aside, because 0.24 may sit
/// in connect() or a first read for far longer than a person wants to wait; a late context is destroyed where
/// it appears.
ContextPtr create_context(const std::string& uri, milliseconds limit) {
  // libiio 0.24 writes to a vanished peer without MSG_NOSIGNAL: that must be an error, not the end of the program
  std::signal(SIGPIPE, SIG_IGN);
  struct Result {
    ContextPtr context;
    int error = 0;
  };
  std::promise<Result> promise;
  auto future = promise.get_future();
  std::thread([uri, p = std::move(promise)]() mutable {
    std::string copy = uri;
    errno = 0;
    ContextPtr context(iio_create_context_from_uri(copy.data()));
    const int error = context ? 0 : (errno != 0 ? errno : EIO);
    p.set_value({std::move(context), error});
  }).detach();
  if (future.wait_for(limit) != std::future_status::ready)
    throw RigError("no answer from " + uri + " within " + std::to_string(limit.count()) +
                   " ms; check the address and that a rig runs there");
  Result result = future.get();
  if (!result.context)
    throw RigError("cannot reach " + uri + ": " + broken_sentence(result.error, "connecting"));
  return std::move(result.context);
}

double to_number(const std::string& text, const std::string& what) {
  double value = std::nan("");
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value))
    throw LinkBroken{0, "the rig has '" + text + "' for " + what + ", which is no number"};
  return value;
}

}  // namespace

std::string sentence(const Refusal& r) {
  switch (r.error) {
    case EBUSY:
      return "the rig is busy (" + r.doing + ")";
    case EAGAIN:
      return "the rig is not armed (" + r.doing + ")";
    case EPERM:
      return "the rig refused for safety (" + r.doing + ")";
    default:
      return "the rig refused a value outside its range (" + r.doing + ")";
  }
}

struct IioLink::Impl {
  iio_device* device(Device d) const {
    return d == Device::daq ? daq : d == Device::control ? control : plant;
  }

  std::string text(ssize_t n, const char* value, const std::string& doing) const {
    if (n < 0) broken(static_cast<int>(-n), doing);
    if (static_cast<std::size_t>(n) >= longest_value || std::strlen(value) + 1 != static_cast<std::size_t>(n))
      broken(0, doing);
    return value;
  }
  void written(ssize_t n, const std::string& value, const std::string& doing) const {
    if (n < 0 && is_refusal(static_cast<int>(-n))) throw Refusal{static_cast<int>(-n), doing};
    if (n != static_cast<ssize_t>(value.size()) + 1) broken(n < 0 ? static_cast<int>(-n) : 0, doing);
  }
  std::string channel_text(iio_channel* c, const char* attribute) const {
    char value[longest_value];
    const ssize_t n = iio_channel_attr_read(c, attribute, value, sizeof value);
    return text(n, value, std::string("reading ") + iio_channel_get_id(c) + " " + attribute);
  }
  std::string context_value(const char* name) const {
    const char* value = iio_context_get_attr_value(context.get(), name);
    return value ? value : "";
  }

  ContextPtr context;
  iio_device* daq = nullptr;
  iio_device* control = nullptr;
  iio_device* plant = nullptr;  ///< only on rigs with a programmable source
  iio_channel* angle = nullptr;
};

IioLink::IioLink(const std::string& uri, milliseconds limit, milliseconds request)
    : impl_(std::make_unique<Impl>()) {
  impl_->context = create_context(uri, limit);
  // before any buffer exists: its connection copies the time-out
  iio_context_set_timeout(impl_->context.get(), static_cast<unsigned>(request.count()));
  impl_->daq = iio_context_find_device(impl_->context.get(), "contactor-daq");
  impl_->control = iio_context_find_device(impl_->context.get(), "contactor-ctl");
  impl_->plant = iio_context_find_device(impl_->context.get(), "contactor-plant");
  impl_->angle = impl_->control ? iio_device_find_channel(impl_->control, "phase0", true) : nullptr;
  if (!impl_->daq || !impl_->angle)
    throw RigError(uri +
                   " is an IIO context but not a bench: devices contactor-daq and contactor-ctl are missing");
}

IioLink::~IioLink() = default;

bool IioLink::has_source() const {
  return impl_->plant != nullptr;
}

RigInfo IioLink::read_info(const std::string& uri) try {
  RigInfo info;
  info.uri = uri;
  const char* description = iio_context_get_description(impl_->context.get());
  info.description = description ? description : "";
  info.model = impl_->context_value("hw_model");
  info.serial = impl_->context_value("hw_serial");
  info.firmware = impl_->context_value("fw_version");
  info.kind = impl_->context_value("bench,kind");
  info.boot_id = impl_->context_value("boot_id");
  info.programmable_source = has_source();
  info.sample_rate = to_number(read(Device::daq, "sampling_frequency"), "sampling_frequency");
  info.calibration = read(Device::daq, "calibration");
  if (iio_device_find_attr(impl_->daq, "config_crc32"))
    info.configuration = read(Device::daq, "config_crc32");
  if (iio_device_find_attr(impl_->daq, "calibration_expires"))
    if (const std::string day = read(Device::daq, "calibration_expires"); day.size() == 8)  // else "none"
      info.calibration_expires = day.substr(0, 4) + "-" + day.substr(4, 2) + "-" + day.substr(6);
  info.phase = phase();
  for (const ChannelInfo& row : channel_table) {
    iio_channel* c = iio_device_find_channel(impl_->daq, std::string(row.iio_id).c_str(), false);
    if (!c) continue;
    const std::string name(row.name);
    double scale = to_number(impl_->channel_text(c, "scale"), name + " scale") * row.si_per_iio_unit;
    if (row.unit == "N") scale *= to_number(impl_->channel_text(c, "film_area"), name + " film_area");
    info.channels.push_back(
        {std::string(row.iio_id), impl_->channel_text(c, "label"), std::string(row.unit), scale});
  }
  return info;
} catch (const LinkBroken& b) {
  throw RigError(uri + ": " + b.sentence);
}

std::string IioLink::phase() {
  for (const char* attribute : {"phase_faults", "phase_u_millideg"})
    if (!iio_device_find_attr(impl_->device(Device::control), attribute))
      return phase_words({}, {});  // an older rig
  const std::string faults = read(Device::control, "phase_faults");
  return phase_words(faults, read(Device::control, "phase_u_millideg"));
}

std::string IioLink::read(Device d, const char* attribute) {
  char value[longest_value];
  const ssize_t n = iio_device_attr_read(impl_->device(d), attribute, value, sizeof value);
  return impl_->text(n, value, std::string("reading ") + attribute);
}

std::string IioLink::read_if_there(Device d, const char* attribute) {
  return iio_device_find_attr(impl_->device(d), attribute) ? read(d, attribute) : std::string();
}

std::vector<std::pair<std::string, std::string>> IioLink::read_all() {
  std::vector<std::pair<std::string, std::string>> all;
  char value[longest_value];
  const auto keep = [&](const std::string& name, ssize_t n) {
    // what can only be written answers with an error of its own; a line that is broken answers nothing any more
    if (n < 0 && n != -EACCES && n != -EPERM && n != -EINVAL && n != -ENOSYS)
      broken(static_cast<int>(-n), "reading " + name);
    if (n > 0) all.emplace_back(name, std::string(value, strnlen(value, static_cast<std::size_t>(n))));
  };
  for (const iio_device* d : {impl_->daq, impl_->control, impl_->plant}) {
    if (!d) continue;
    const std::string device = iio_device_get_name(d);
    for (unsigned i = 0; i < iio_device_get_attrs_count(d); ++i) {
      const char* name = iio_device_get_attr(d, i);
      keep(device + "/" + name, iio_device_attr_read(d, name, value, sizeof value));
    }
    for (unsigned c = 0; c < iio_device_get_channels_count(d); ++c) {
      const iio_channel* channel = iio_device_get_channel(d, c);
      for (unsigned i = 0; i < iio_channel_get_attrs_count(channel); ++i) {
        const char* name = iio_channel_get_attr(channel, i);
        keep(device + "/" + iio_channel_get_id(channel) + "/" + name,
             iio_channel_attr_read(channel, name, value, sizeof value));
      }
    }
  }
  return all;
}

void IioLink::write(Device d, const char* attribute, const std::string& value) {
  const ssize_t n = iio_device_attr_write(impl_->device(d), attribute, value.c_str());
  impl_->written(n, value, std::string("writing ") + attribute);
}

void IioLink::write_angle(const std::string& value) {
  const ssize_t n = iio_channel_attr_write(impl_->angle, "raw", value.c_str());
  impl_->written(n, value, "writing the closing angle");
}

std::string IioLink::read_channel(Channel channel, const char* attribute) {
  const std::string id(channel_table[index(channel)].iio_id);
  iio_channel* c = iio_device_find_channel(impl_->daq, id.c_str(), false);
  if (!c) broken(ENODEV, "finding channel " + id);
  return impl_->channel_text(c, attribute);
}

std::vector<std::uint8_t> IioLink::read_scans(std::size_t samples) {
  for (const ChannelInfo& row : channel_table) {
    iio_channel* c = iio_device_find_channel(impl_->daq, std::string(row.iio_id).c_str(), false);
    if (!c) broken(ENODEV, "finding channel " + std::string(row.name));
    iio_channel_enable(c);
  }
  // one refill for the whole record: it is complete, so the answer comes at once
  BufferPtr buffer(iio_device_create_buffer(impl_->daq, samples, false));
  if (!buffer) broken(errno, "opening the record");
  const ssize_t bytes = iio_buffer_refill(buffer.get());
  if (bytes < 0) broken(static_cast<int>(-bytes), "reading the record");
  const std::size_t expected = samples * channel_count * sizeof(std::int16_t);
  if (static_cast<std::size_t>(bytes) != expected || iio_buffer_step(buffer.get()) != 2 * channel_count)
    broken(0, "reading the record: its length is wrong");
  const auto* data = static_cast<const std::uint8_t*>(iio_buffer_start(buffer.get()));
  return {data, data + bytes};
}

}  // namespace powbench::rigs
