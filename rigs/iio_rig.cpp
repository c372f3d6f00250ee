#include "rigs/iio_rig.h"

#include <iio.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstring>
#include <future>
#include <map>
#include <optional>
#include <thread>

#include "core/channels.h"
#include "core/crc32.h"
#include "core/phase.h"

/// The only file that knows libiio. Written against 0.24: an attribute that timed out or broke poisons its
/// context (every later answer would be shifted by one), so such a context is thrown away and never asked
/// again.

namespace powbench::rigs {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

struct ContextDeleter {
  void operator()(iio_context* c) const { iio_context_destroy(c); }
};
struct BufferDeleter {
  void operator()(iio_buffer* b) const { iio_buffer_destroy(b); }
};
using ContextPtr = std::unique_ptr<iio_context, ContextDeleter>;
using BufferPtr = std::unique_ptr<iio_buffer, BufferDeleter>;

/// What went wrong in one conversation: errno and what was being done.
struct Trouble {
  int error = 0;
  std::string doing;
};

bool connection_is_lost(int error) {
  return error == EPIPE || error == ETIMEDOUT || error == EBADF || error == ECONNRESET ||
         error == ECONNREFUSED || error == EIO || error == ENOTCONN;
}

std::string sentence(const Trouble& t) {
  switch (t.error) {
    case EPIPE:
    case ECONNRESET:
    case ENOTCONN:
      return "the rig went away while " + t.doing + "; check that it is running and the cable is in";
    case ECONNREFUSED:
      return "nothing listens there; start the rig or correct the address";
    case ETIMEDOUT:
      return "the rig did not answer in time while " + t.doing;
    case ENXIO:
      return "there is no host of that name; check the address";
    case EHOSTUNREACH:
    case ENETUNREACH:
      return "no route to the rig; check the address and the network";
    case EBUSY:
      return "the rig is busy: another client may be using it (" + t.doing + ")";
    case EAGAIN:
      return "the rig is not armed (" + t.doing + ")";
    case EPERM:
      return "the rig refused for safety (" + t.doing + ")";
    case ERANGE:
      return "the rig refused a value outside its range (" + t.doing + ")";
    case ENODEV:
    case ENOENT:
      return "this rig lacks what is needed for " + t.doing + "; is it a powbench rig?";
    default:
      return std::string(std::strerror(t.error)) + " while " + t.doing;
  }
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
  if (!result.context) throw RigError("cannot reach " + uri + ": " + sentence({result.error, "connecting"}));
  return std::move(result.context);
}

double to_double(const std::string& text) {
  double value = std::nan("");
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} ? value : std::nan("");
}

class IioRig final : public Rig {
 public:
  IioRig(std::string uri, milliseconds limit) : uri_(std::move(uri)), limit_(limit) {
    connect();
    read_info();
  }

  const RigInfo& info() const override { return info_; }
  Shot fire(const Conditions&, milliseconds limit) override;
  bool abort() override;
  bool reconnect() override;

 private:
  void connect();
  void read_info();
  std::string context_value(const char* name) const;

  // attribute access; a Trouble is thrown and caught in this file only
  std::string read(iio_device* d, const char* attribute);
  std::string read(iio_channel* c, const char* attribute);
  void write(iio_device* d, const char* attribute, const std::string& value);
  std::int64_t read_int(iio_device* d, const char* attribute);

  void set_conditions(const Conditions&);
  std::string wait_for_capture(Clock::time_point deadline);
  Record read_record(const Conditions&);
  void read_scans(Record&, std::size_t samples);
  std::vector<Gap> read_gaps();

  std::string uri_;
  milliseconds limit_;
  ContextPtr context_;
  iio_device* daq_ = nullptr;
  iio_device* control_ = nullptr;
  iio_device* plant_ = nullptr;  ///< only on rigs with a programmable source
  iio_channel* angle_ = nullptr;
  RigInfo info_;
};

void IioRig::connect() {
  context_.reset();
  context_ = create_context(uri_, limit_);
  iio_context_set_timeout(context_.get(),
                          2000);  // before any buffer exists: its connection copies the time-out
  daq_ = iio_context_find_device(context_.get(), "contactor-daq");
  control_ = iio_context_find_device(context_.get(), "contactor-ctl");
  plant_ = iio_context_find_device(context_.get(), "contactor-plant");
  angle_ = control_ ? iio_device_find_channel(control_, "phase0", true) : nullptr;
  if (!daq_ || !angle_)
    throw RigError(uri_ +
                   " is an IIO context but not a bench: devices contactor-daq and contactor-ctl are missing");
}

std::string IioRig::context_value(const char* name) const {
  const char* value = iio_context_get_attr_value(context_.get(), name);
  return value ? value : "";
}

void IioRig::read_info() try {
  info_ = {};
  info_.uri = uri_;
  const char* description = iio_context_get_description(context_.get());
  info_.description = description ? description : "";
  info_.model = context_value("hw_model");
  info_.serial = context_value("hw_serial");
  info_.firmware = context_value("fw_version");
  info_.kind = context_value("bench,kind");
  info_.boot_id = context_value("boot_id");
  info_.programmable_source = plant_ != nullptr;
  info_.sample_rate = to_double(read(daq_, "sampling_frequency"));
  info_.calibration = read(daq_, "calibration");
  for (const ChannelInfo& row : channel_table) {
    iio_channel* c = iio_device_find_channel(daq_, std::string(row.iio_id).c_str(), false);
    if (!c) continue;
    double scale = to_double(read(c, "scale")) * row.si_per_iio_unit;
    if (row.unit == "N") scale *= to_double(read(c, "film_area"));
    info_.channels.push_back({std::string(row.iio_id), read(c, "label"), std::string(row.unit), scale});
  }
} catch (const Trouble& t) {
  throw RigError(uri_ + ": " + sentence(t));
}

std::string IioRig::read(iio_device* d, const char* attribute) {
  char text[600];
  const ssize_t n = iio_device_attr_read(d, attribute, text, sizeof text);
  if (n < 0) throw Trouble{static_cast<int>(-n), std::string("reading ") + attribute};
  return text;
}

std::string IioRig::read(iio_channel* c, const char* attribute) {
  char text[600];
  const ssize_t n = iio_channel_attr_read(c, attribute, text, sizeof text);
  if (n < 0)
    throw Trouble{static_cast<int>(-n), std::string("reading ") + iio_channel_get_id(c) + " " + attribute};
  return text;
}

void IioRig::write(iio_device* d, const char* attribute, const std::string& value) {
  const ssize_t n = iio_device_attr_write(d, attribute, value.c_str());
  if (n < 0) throw Trouble{static_cast<int>(-n), std::string("writing ") + attribute + " = " + value};
}

std::int64_t IioRig::read_int(iio_device* d, const char* attribute) {
  const std::string text = read(d, attribute);
  std::int64_t value = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{})
    throw Trouble{EIO, std::string("understanding ") + attribute + " = " + text};
  return value;
}

void IioRig::set_conditions(const Conditions& c) {
  const auto milli = [](double x) { return std::to_string(std::llrint(x * 1000.0)); };
  if (plant_) {
    write(plant_, "supply_millivolts", milli(c.supply_volts));
    write(plant_, "mains_millihertz", milli(c.mains_hertz));
    write(plant_, "ambient_millidegc", milli(c.ambient - zero_celsius));
    // the wire carries 18 decimal digits
    write(plant_, "seed", std::to_string(c.seed % 1'000'000'000'000'000'000ULL));
  }
  const double angle = c.closing_angle + (c.polarity < 0 ? pi : 0.0);
  const std::string centi = std::to_string(to_centi_degrees(angle));
  const ssize_t n = iio_channel_attr_write(angle_, "raw", centi.c_str());
  if (n < 0) throw Trouble{static_cast<int>(-n), "writing the closing angle"};
  write(control_, "hold_time_ms", std::to_string(std::llrint(c.hold_time * 1000.0)));
}

/// Polls `state`: waiting for a shot is no reason to block in a refill. Returns the last state seen.
std::string IioRig::wait_for_capture(Clock::time_point deadline) {
  auto pause = std::chrono::microseconds(200);
  for (;;) {
    std::string state = read(control_, "state");
    if (state != "firing" || Clock::now() > deadline) return state;
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 5 / 4, std::chrono::microseconds(10'000));
  }
}

std::vector<Gap> IioRig::read_gaps() {
  std::vector<Gap> gaps;
  const std::string text = read(daq_, "gaps");
  const char* at = text.data();
  const char* end = at + text.size();
  while (at < end) {
    Gap gap;
    auto first = std::from_chars(at, end, gap.first);
    if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') break;
    auto count = std::from_chars(first.ptr + 1, end, gap.count);
    gaps.push_back(gap);
    at = count.ptr + 1;
  }
  return gaps;
}

void IioRig::read_scans(Record& record, std::size_t samples) {
  // one refill for the whole record: it is complete, so the answer comes at once
  BufferPtr buffer(iio_device_create_buffer(daq_, samples, false));
  if (!buffer) throw Trouble{errno, "opening the record"};
  const ssize_t bytes = iio_buffer_refill(buffer.get());
  if (bytes < 0) throw Trouble{static_cast<int>(-bytes), "reading the record"};
  const auto step = static_cast<std::size_t>(iio_buffer_step(buffer.get()));
  if (static_cast<std::size_t>(bytes) != samples * step)
    throw Trouble{EIO, "reading the record: it came short"};
  const auto* data = static_cast<const std::uint8_t*>(iio_buffer_start(buffer.get()));
  record.crc32 = crc32({data, static_cast<std::size_t>(bytes)});
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    auto& raw = record.channels[c].raw;
    raw.resize(samples);
    for (std::size_t i = 0; i < samples; ++i) {
      const std::uint8_t* at = data + i * step + 2 * c;
      raw[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(at[0] | at[1] << 8));
    }
  }
}

Record IioRig::read_record(const Conditions& conditions) {
  Record record;
  record.conditions = conditions;
  record.sample_rate = info_.sample_rate;
  record.fire_sample = read_int(daq_, "fire_sample");
  record.fire_offset = 1e-9 * static_cast<double>(read_int(daq_, "fire_offset_ns"));
  record.gaps = read_gaps();
  record.overruns = static_cast<std::uint32_t>(read_int(daq_, "overruns"));
  record.shot_id = static_cast<std::uint64_t>(read_int(daq_, "shot_id"));
  record.rig = info_.model + ", " + info_.serial;
  record.firmware = info_.firmware;
  record.calibration = read(daq_, "calibration");
  for (std::size_t i = 0; i < channel_count; ++i) {
    const ChannelInfo& row = channel_table[i];
    iio_channel* c = iio_device_find_channel(daq_, std::string(row.iio_id).c_str(), false);
    if (!c) throw Trouble{ENODEV, "finding channel " + std::string(row.name)};
    iio_channel_enable(c);
    ChannelRecord channel;
    channel.channel = static_cast<Channel>(i);
    channel.scale = to_double(read(c, "scale")) * row.si_per_iio_unit;
    channel.offset = to_double(read(c, "offset"));
    channel.delay = 1e-9 * to_double(read(c, "delay_ns"));
    if (row.unit == "N") {
      channel.scale *= to_double(read(c, "film_area"));
      channel.corner_hertz = to_double(read(c, "corner_frequency"));
    }
    record.channels.push_back(std::move(channel));
  }
  const auto samples = static_cast<std::size_t>(read_int(daq_, "record_length"));
  read_scans(record, samples);
  const auto expected = [this] {
    std::uint32_t value = 0;
    const std::string crc = read(daq_, "record_crc32");
    std::from_chars(crc.data(), crc.data() + crc.size(), value, 16);
    return value;
  };
  if (record.crc32 != expected()) {
    // opening again rewinds; once is a disturbed line (record or checksum), twice is a fault
    read_scans(record, samples);
    if (record.crc32 != expected()) throw Trouble{EIO, "checking the record: its CRC does not match"};
  }
  return record;
}

Shot IioRig::fire(const Conditions& conditions, milliseconds limit) {
  const auto deadline = Clock::now() + limit;
  Shot shot;
  const auto failed = [&](Outcome outcome, std::string reason) {
    shot.outcome = outcome;
    shot.reason = std::move(reason);
    return shot;
  };
  if (!context_) {
    shot.rig_lost = true;
    return failed(Outcome::error, "not connected to the rig");
  }
  try {
    set_conditions(conditions);
    write(control_, "arm", "1");
    write(control_, "fire", "1");
    const std::string state = wait_for_capture(deadline);
    if (state == "captured") {
      shot.record = read_record(conditions);
      shot.outcome = Outcome::pass;
      if (shot.record.overruns > 0 || !shot.record.gaps.empty())
        return failed(Outcome::error, "samples were lost inside the record");
      return shot;
    }
    if (state == "firing") {
      abort();
      return failed(Outcome::timeout,
                    "the rig did not finish within " + std::to_string(limit.count()) + " ms");
    }
    shot.interlock = true;
    const std::string why = read(control_, "last_error");
    abort();
    return failed(Outcome::error, "the rig tripped: " + why);
  } catch (const Trouble& t) {
    shot.rig_lost = connection_is_lost(t.error);
    if (shot.rig_lost) {
      context_.reset();
      return failed(t.error == ETIMEDOUT ? Outcome::timeout : Outcome::error, sentence(t));
    }
    shot.interlock = t.error == EPERM;
    std::string why;
    try {
      why = read(control_, "last_error");
    } catch (const Trouble&) {
      shot.rig_lost = true;
      context_.reset();
    }
    return failed(Outcome::error, sentence(t) + (why.empty() || why == "no error" ? "" : ": " + why));
  }
}

bool IioRig::abort() {
  if (!context_) return false;
  try {
    write(control_, "abort", "1");
    return true;
  } catch (const Trouble&) {
    context_.reset();
    return false;
  }
}

bool IioRig::reconnect() {
  const RigInfo before = info_;
  try {
    connect();
    read_info();
  } catch (const RigError&) {
    context_.reset();
    return false;
  }
  const bool same = info_.serial == before.serial && info_.model == before.model;
  if (!same) {
    context_.reset();
    info_ = before;
  }
  return same;
}

}  // namespace

std::unique_ptr<Rig> connect_iio(const std::string& uri, milliseconds limit) {
  return std::make_unique<IioRig>(uri, limit);
}

}  // namespace powbench::rigs
