#include "rigs/sim_world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "core/random.h"
#include "core/version.h"

namespace powbench::rigs {

namespace {

constexpr std::int64_t block_samples = 10;  // what the board's DMA half-buffer holds at 100 kS/s
constexpr std::int64_t batch_blocks = 20;   // handed over at once while no edge can come
constexpr double relay_travel = 0.005;      // s: until the safety relay follows
constexpr double warm_up_least = 0.100;     // s: pre-trigger and the phase tracker's memory
constexpr double warm_up_most = 0.500;      // s: after that the firmware may say why it does not fire

firmware::ControllerConfig controller_config(const SimRigConfig& rig, std::string_view calibration_id) {
  const auto scales = channel_scales(rig.sensors, rig.sample_rate);
  firmware::ControllerConfig c;
  c.sample_rate = std::llrint(rig.sample_rate);
  c.record_length = std::llrint(rig.record_length * rig.sample_rate);
  c.pretrigger = std::llrint(rig.pretrigger * rig.sample_rate);
  c.calibration_id = calibration_id;
  for (std::size_t i = 0; i < channel_count; ++i) {
    const ChannelInfo& channel = channel_table[i];
    // force travels as pressure (no IIO force type exists): divide by the film area
    const double area = channel.unit == "N" ? rig.sensors.film_area : 1.0;
    auto& out = c.calibration[i];
    out.scale_pico = std::llrint(scales[i].si_per_count / area / channel.si_per_iio_unit * 1e12);
    out.delay_ns = std::llrint(scales[i].delay * 1e9);
    out.corner_microhertz = std::llrint(scales[i].corner_hertz * 1e6);
    out.film_area_pico = std::llrint(rig.sensors.film_area * 1e12);
    out.sensitivity_femto = std::llrint(rig.sensors.charge_sensitivity * 1e15);
  }
  const double mains_scale = scales[index(Channel::mains_voltage)].si_per_count;
  const auto samples = [&](double seconds) { return std::llrint(seconds * rig.sample_rate); };
  c.phase.sample_rate = static_cast<float>(rig.sample_rate);
  c.phase.nominal_amplitude = static_cast<float>(230.0 * std::sqrt(2.0) / mains_scale);
  c.fire.sample_rate = c.sample_rate;
  c.fire.phase_timeout_samples = samples(1.0);
  c.fire.quiet_samples = samples(0.005);
  c.limits.contact_open_volts = 0.5 * rig.sensors.contact_open_voltage;
  c.interlocks = firmware::interlock_config(c.limits, firmware::count_scales(c.calibration), rig.sample_rate);
  // no pause between shots and no shots a minute: every shot here has a device at rest, and no time passes
  // between shots
  return c;
}

/// The device on the rig: its specimen with the fixed deviations and this shot's scatter.
sim::Specimen device_for_shot(sim::Specimen s, const SimRigConfig& rig, Random& random) {
  const DeviceConfig& d = rig.device;
  s.coil.resistance *= 1.0 + d.coil_resistance;
  s.core.return_rate *= 1.0 + d.return_rate;
  s.core.friction *= (1.0 + d.friction) * std::max(0.0, 1.0 + rig.scatter.friction * random.normal());
  s.bridges.gap += d.gap + rig.scatter.gap * random.normal();
  s.bridges.tilt_gap += d.tilt_gap;
  return s;
}

}  // namespace

std::string_view rig_config_error(const SimRigConfig& rig) {
  return firmware::config_error(controller_config(rig, "none"), std::size_t{1} << 32);
}

SimWorld::SimWorld(const SimRigConfig& config, const sim::Specimen& specimen, const BoardOptions& options)
    : config_(config),
      specimen_(specimen),
      calibration_id_("virtual-" + config.serial),
      boot_id_(options.boot_id),
      secret_(options.secret) {
  const firmware::Identity identity{.kind = options.kind == BoardOptions::Kind::native ? "sim" : "qemu",
                                    .model = config_.name,
                                    .serial = config_.serial,
                                    .version = program_version,
                                    .specimen = specimen_.name,
                                    .boot_id = boot_id_,
                                    .secret = secret_};
  board_ = make_board(options, controller_config(config_, calibration_id_), identity);
  const auto per_block = static_cast<std::size_t>(block_samples);
  if (config_.supply.mains.kind == sim::Mains::Kind::dc)
    throw std::invalid_argument(
        "[supply] kind = dc: a rig fires on the phase of its mains and there is none; allowed ac, half_wave, "
        "full_wave; "
        "`powbench sim --sensors` takes dc");
  times_.resize(per_block * oversampling);
  states_.resize(per_block * oversampling);
  scans_.resize(per_block * channel_count * batch_blocks);
  begin_shot({});
  board_->publish({}, {});
  step_blocks(100);  // so that the channels read something before the first shot
}

SimWorld::~SimWorld() = default;

void SimWorld::begin_shot(firmware::SetPoints set_points) {
  Random random(static_cast<std::uint64_t>(set_points.seed));
  ++set_points.seed;
  const double celsius = 1e-3 * static_cast<double>(set_points.ambient_millidegc);
  sim::Mains mains = config_.supply.mains;
  mains.volts = 1e-3 * static_cast<double>(set_points.supply_millivolts) * (1.0 + config_.device.supply) *
                (1.0 + config_.scatter.supply * random.normal()) * config_.faults.mains_dip;
  mains.hertz = 1e-3 * static_cast<double>(set_points.mains_millihertz);
  mains.phase = 2 * pi * random.uniform();
  const sim::PlantOptions options{
      .relative_tolerance = config_.integrator_tolerance,
      .coil_kelvin = celsius + zero_celsius + config_.scatter.coil_temperature * random.normal(),
      .coil_switch = config_.supply.coil_switch,
      .suppression = config_.supply.suppression};
  const sim::Specimen device = device_for_shot(specimen_, config_, random);
  plant_ = std::make_unique<sim::Plant>(device, mains, options);
  sensors_ = std::make_unique<SensorChain>(config_.sensors, config_.sample_rate, mains.hertz, random.next());
  sensors_->set_front_end(config_.front_end);
  connect_reference(set_points);
  origin_ = relay_since_ = sample_;
  relay_in_ = relay_in_ && config_.faults.relay_welded;  // it has opened while nothing went on
  edges_.clear();
  scheduled_.clear();
  switched_.clear();
  switched_on_ = -1.0;
  samples_lost_ = false;
  board_->publish(set_points, {});
}

/// A source of known quantity at one input, as somebody who calibrates would connect it.
void SimWorld::connect_reference(const firmware::SetPoints& s) {
  reference_channel_ = s.reference_channel;
  reference_micro_ = s.reference_micro;
  sensors_->set_reference(
      s.reference_channel < 0 ? channel_count : static_cast<std::size_t>(s.reference_channel),
      1e-6 * static_cast<double>(s.reference_micro));
}

/// A shot that was cut short ends before the next request, and a relay that does not open is found out: beyond that
/// no time passes while nothing goes on.
bool SimWorld::at_rest() const {
  const auto& report = board_->report();
  if (report.state == firmware::State::firing) return true;
  const bool welded = config_.faults.relay_welded && relay_in_ && !report.relay_closed &&
                      report.state != firmware::State::fault;
  return !report.gate_on && !report.settling && !welded;
}

/// The safety relay follows its command.
void SimWorld::move_relay() {
  const bool told = board_->report().relay_closed && !config_.faults.relay_open;
  const bool stays = told == relay_in_ || (relay_in_ && config_.faults.relay_welded);
  if (stays) relay_since_ = sample_;
  if (static_cast<double>(sample_ - relay_since_) >= relay_travel * config_.sample_rate) relay_in_ = told;
}

void SimWorld::notice_commands() {
  while (!at_rest()) step_blocks(1);
  const firmware::SetPoints& wanted = board_->report().set_points;
  if (wanted.reference_channel != reference_channel_ || wanted.reference_micro != reference_micro_)
    connect_reference(wanted);
  // every request sees newer samples while a source is connected: their mean is what a calibration takes
  if (reference_channel_ >= 0 && board_->report().shots_armed == shots_seen_) step_blocks(1);
  if (board_->report().shots_armed == shots_seen_) return;
  shots_seen_ = board_->report().shots_armed;
  begin_shot(board_->report().set_points);
  const auto samples = [&](double s) { return std::llrint(s * config_.sample_rate); };
  step_blocks((samples(warm_up_least) + block_samples - 1) / block_samples);
  while (!board_->report().phase_valid && sample_ - origin_ < samples(warm_up_most)) step_blocks(1);
}

bool SimWorld::busy() const {
  return board_->report().state == firmware::State::firing || board_->report().gate_on;
}

void SimWorld::run(double seconds) {
  const std::int64_t end = sample_ + std::llrint(seconds * config_.sample_rate);
  while (sample_ < end && busy()) step_blocks(1);
  board_->publish(board_->report().set_points, truth());
}

double SimWorld::plant_time(firmware::Tick tick) const {
  return (static_cast<double>(tick.sample - origin_ + 1) + tick.fraction / 65536.0) / config_.sample_rate;
}

/// Takes the edges that fall before `until` out of the queue, in plant time.
std::vector<SwitchEdge> SimWorld::due_edges(double until) {
  std::vector<SwitchEdge> due;
  std::erase_if(edges_, [&](const firmware::GateEdge& e) {
    const double at = plant_time(e.at);
    if (at >= until) return false;
    if (e.on) switched_on_ = at;
    switched_.push_back({std::max(at, plant_->now()), e.on});  // a late edge takes effect at once
    due.push_back({at, e.on && !config_.faults.coil_open});
    return true;
  });
  return due;
}

/// Lets `count` blocks pass. As long as nothing can switch the coil they go to the board in batches: a batch
/// gives what its blocks give one by one, at a fraction of the exchanges.
void SimWorld::step_blocks(std::int64_t count) {
  const std::size_t per_block = static_cast<std::size_t>(block_samples) * channel_count;
  std::vector<firmware::Block> blocks;
  while (count > 0) {
    const std::int64_t batch = busy() ? 1 : std::min(count, batch_blocks);
    blocks.clear();
    for (std::int64_t b = 0; b < batch; ++b)
      blocks.push_back(
          convert_block(std::span(scans_).subspan(static_cast<std::size_t>(b) * per_block, per_block)));
    const std::size_t before = edges_.size();
    board_->step(blocks, edges_);
    assert(batch == 1 || edges_.size() == before);
    scheduled_.insert(scheduled_.end(), edges_.begin() + static_cast<std::ptrdiff_t>(before), edges_.end());
    count -= batch;
  }
}

/// Advances plant and sensors by one block.
firmware::Block SimWorld::convert_block(std::span<std::int16_t> scans) {
  move_relay();
  const double dt = 1.0 / (config_.sample_rate * oversampling);
  const std::int64_t first = (sample_ - origin_) * oversampling;
  for (std::size_t i = 0; i < times_.size(); ++i)
    times_[i] = static_cast<double>(first + static_cast<std::int64_t>(i) + 1) * dt;
  advance_through(*plant_, due_edges(times_.back()), times_, states_);
  const double since_on = switched_on_ < 0 ? -1.0 : times_.back() - switched_on_;
  if (config_.faults.laser_dropout) sensors_->drop_laser(since_on > 0.012 && since_on < 0.014);
  for (std::size_t i = 0; i < static_cast<std::size_t>(block_samples); ++i)
    sensors_->convert({&states_[i * oversampling], oversampling},
                      scans.subspan(i * channel_count, channel_count));

  // virtual time passes faster than anyone can speak: an open connection of the owner stands for the heartbeat
  firmware::Block block{.first_sample = sample_,
                        .scans = scans,
                        .relay_in = relay_in_,
                        .owner_present = board_->report().owner_connected};
  sample_ += block_samples;
  if (config_.faults.lost_samples > 0 && !samples_lost_ && since_on > 0.005) {
    samples_lost_ = true;  // this block's first conversions never arrive
    const auto lost =
        std::min<std::size_t>(static_cast<std::size_t>(config_.faults.lost_samples), block_samples - 1);
    block.first_sample += static_cast<std::int64_t>(lost);
    block.scans = block.scans.subspan(lost * channel_count);
  }
  return block;
}

firmware::PlantTruth SimWorld::truth() const {
  constexpr auto none = firmware::PlantTruth::none;
  firmware::PlantTruth truth;
  if (switched_on_ < 0) return truth;
  using Kind = sim::PlantEvent::Kind;
  bool a = false, b = false;
  for (const sim::PlantEvent& e : plant_->events()) {
    if (e.time < switched_on_) continue;
    const std::int64_t t = std::llrint((e.time - switched_on_) * 1e9);
    const bool was_closed = a && b;
    if (e.kind == Kind::touch_a) a = true;
    if (e.kind == Kind::release_a) a = false;
    if (e.kind == Kind::touch_b) b = true;
    if (e.kind == Kind::release_b) b = false;
    if (e.kind == Kind::core_touch && truth.seat_ns == none) truth.seat_ns = t;
    if (a && b && !was_closed) {
      if (truth.touch_ns == none) truth.touch_ns = t;
      // openings after switch-off are not bounces
      truth.settled_ns = t;
    }
  }
  return truth;
}

}  // namespace powbench::rigs
