#include "rigs/sensors.h"

#include <algorithm>
#include <cmath>

namespace powbench::rigs {

namespace {
constexpr double full_counts = 32768.0;
constexpr double sqrt2 = 1.4142135623730951;
constexpr double aux_full_scale = 10.0;  // V

double group_delay(const SensorConfig& c) {
  return sqrt2 / (2 * pi * c.bandwidth_hertz);
}
}  // namespace

std::array<ChannelScale, channel_count> channel_scales(const SensorConfig& c, double sample_rate) {
  std::array<ChannelScale, channel_count> scales{};
  const auto at = [&](Channel channel) -> ChannelScale& { return scales[index(channel)]; };
  // electrical inputs are averaged over the converter's sample interval; that is half an oversampled interval
  // late
  const double average = 0.5 * (oversampling - 1) / (oversampling * sample_rate);
  for (auto& s : scales) s.delay = average;
  const ChannelScale force{c.force_full_scale / full_counts, group_delay(c), c.corner_hertz};
  at(Channel::pvdf_a) = force;
  at(Channel::pvdf_b) = force;
  at(Channel::laser) = {c.laser_scale, c.laser_delay + 0.5 / c.laser_rate, 0.0};
  at(Channel::coil_current).si_per_count = c.current_full_scale / full_counts;
  at(Channel::coil_voltage).si_per_count = c.voltage_full_scale / full_counts;
  at(Channel::mains_voltage).si_per_count = c.voltage_full_scale / full_counts;
  at(Channel::contact_a).si_per_count = c.contact_full_scale / full_counts;
  at(Channel::aux).si_per_count = aux_full_scale / full_counts;
  return scales;
}

LowPass::LowPass(double hertz, double rate) {
  const double k = std::tan(pi * hertz / rate);
  const double norm = 1.0 / (1.0 + sqrt2 * k + k * k);
  b0_ = k * k * norm;
  a1_ = 2.0 * (k * k - 1.0) * norm;
  a2_ = (1.0 - sqrt2 * k + k * k) * norm;
}

double LowPass::step(double x) {
  const double y = b0_ * x + s1_;
  s1_ = 2.0 * b0_ * x - a1_ * y + s2_;
  s2_ = b0_ * x - a2_ * y;
  return y;
}

HighPass::HighPass(double hertz, double rate) {
  const double w = std::tan(pi * hertz / rate);
  gain_ = 1.0 / (1.0 + w);
  feedback_ = (1.0 - w) / (1.0 + w);
}

double HighPass::step(double x) {
  y1_ = gain_ * (x - x1_) + feedback_ * y1_;
  x1_ = x;
  return y1_;
}

Resonator::Resonator(double hertz, double damping, double rate) {
  const double w = 2 * pi * hertz, dt = 1.0 / rate;
  const double wd = w * std::sqrt(1.0 - damping * damping), decay = std::exp(-damping * w * dt);
  const double c = std::cos(wd * dt), s = std::sin(wd * dt);
  m_[0][0] = decay * (c + damping * w / wd * s);
  m_[0][1] = decay * s / wd;
  m_[1][0] = -decay * w * w / wd * s;
  m_[1][1] = decay * (c - damping * w / wd * s);
  // a constant force moves the equilibrium: x(dt) = M (x - e F) + e F with e = (1, 0)
  n_[0] = 1.0 - m_[0][0];
  n_[1] = -m_[1][0];
  w2_ = w * w;
  c_ = 2 * damping * w;
}

void Resonator::step(double force) {
  const double q = m_[0][0] * q_ + m_[0][1] * v_ + n_[0] * force;
  v_ = m_[1][0] * q_ + m_[1][1] * v_ + n_[1] * force;
  q_ = q;
  second_ = w2_ * (force - q_) - c_ * v_;
}

SensorChain::SensorChain(const SensorConfig& config, double sample_rate, double mains_hertz,
                         std::uint64_t seed)
    : config_(config),
      mains_hertz_(mains_hertz),
      random_(seed),
      low_a_(config.bandwidth_hertz, sample_rate * oversampling),
      low_b_(config.bandwidth_hertz, sample_rate * oversampling),
      high_a_(config.corner_hertz, sample_rate * oversampling),
      high_b_(config.corner_hertz, sample_rate * oversampling),
      plant_dt_(1.0 / (sample_rate * oversampling)) {
  const auto scales = channel_scales(config, sample_rate);
  for (std::size_t c = 0; c < channel_count; ++c) counts_per_si_[c] = 1.0 / scales[c].si_per_count;
  if (config.film_a_inverted) counts_per_si_[index(Channel::pvdf_a)] *= -1.0;
  for (const RingMode& m : config.ring) modes_.emplace_back(m.hertz, m.damping, sample_rate * oversampling);
  travel_.assign(static_cast<std::size_t>(config.laser_delay / plant_dt_) + 2, 0.0);
  next_laser_ = random_.uniform() / config.laser_rate;  // the laser's clock is not ours
}

void SensorChain::set_front_end(const FrontEndConfig& f) {
  for (std::size_t c = 0; c < channel_count; ++c) counts_per_si_[c] *= 1.0 + f.gain[c];
  zero_counts_ = f.zero;
}

std::int16_t SensorChain::quantise(Channel channel, double value, double noise) {
  ++conversions_;
  if (reference_channel_ == index(channel)) value = reference_;
  const double counts =
      (value + noise * random_.normal()) * counts_per_si_[index(channel)] + zero_counts_[index(channel)];
  return static_cast<std::int16_t>(std::lrint(std::clamp(counts, -32768.0, 32767.0)));
}

void SensorChain::force_step(const sim::PlantSample& p) {
  const bool film_a = wants(Channel::pvdf_a), film_b = wants(Channel::pvdf_b);
  if (!film_a && !film_b && !wants(Channel::aux)) return;  // nobody feels the frame ring
  double ring_a = 0.0, ring_b = 0.0;
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    modes_[m].step(p.core_force);
    ring_a += config_.ring[m].gain_a * modes_[m].value();
    ring_b += config_.ring[m].gain_b * modes_[m].value();
  }
  const double pickup = config_.coil_pickup * p.coil_voltage / 325.0;
  const double a = p.force_a + config_.force_crosstalk * p.force_b + ring_a + pickup;
  const double b = p.force_b + config_.force_crosstalk * p.force_a + ring_b + pickup;
  if (film_a) force_a_ = high_a_.step(low_a_.step(a));
  if (film_b) force_b_ = high_b_.step(low_b_.step(b));
}

double SensorChain::laser(const sim::PlantSample& p) {
  travel_[travel_next_] = p.travel;
  travel_next_ = (travel_next_ + 1) % travel_.size();
  while (next_laser_ <= p.time || !laser_started_) {
    if (!laser_started_) next_laser_ = p.time + next_laser_;
    // value of the travel one transport delay before the laser's own sampling instant, between two plant
    // samples
    const double back = (p.time - next_laser_ + config_.laser_delay) / plant_dt_;
    const auto whole = static_cast<std::size_t>(std::max(back, 0.0));
    const double part = std::max(back, 0.0) - static_cast<double>(whole);
    const auto ago = [&](std::size_t n) {
      n = std::min(n, travel_.size() - 1);
      return travel_[(travel_next_ + travel_.size() - 1 - n) % travel_.size()];
    };
    const double noise = config_.laser_noise * random_.normal();
    if (!laser_dropped_) laser_value_ = ago(whole) * (1.0 - part) + ago(whole + 1) * part + noise;
    laser_started_ = true;
    next_laser_ += 1.0 / config_.laser_rate;
  }
  return laser_value_;
}

void SensorChain::convert(std::span<const sim::PlantSample> plant, std::span<std::int16_t> scan) {
  double voltage = 0.0, mains = 0.0, current = 0.0, contact = 0.0, travel = 0.0, acceleration = 0.0;
  constexpr double frame_stiffness = 1e8;  // N/m: turns a mode's force into its motion at the accelerometer
  for (const sim::PlantSample& p : plant) {
    force_step(p);
    if (wants(Channel::laser)) travel = laser(p);
    voltage += p.coil_voltage;
    mains += p.mains_voltage;
    current += p.coil_current;
    const bool closed = p.force_a > 0.0 && p.force_b > 0.0;
    contact += closed ? 0.0 : config_.contact_open_voltage;
    acceleration += p.base_acceleration;
    for (const Resonator& m : modes_) acceleration += m.acceleration() / frame_stiffness;
  }
  const double share = 1.0 / static_cast<double>(plant.size());
  const double phase = 2 * pi * mains_hertz_ * plant.back().time;
  const double hum = config_.force_hum * sqrt2 * (std::sin(phase + 0.7) + std::sin(3 * phase + 1.9) / 3.0);
  const auto put = [&](Channel c, double value, double noise) {
    scan[index(c)] = wants(c) ? quantise(c, value, noise) : std::int16_t{0};
  };
  put(Channel::pvdf_a, force_a_ + hum, config_.force_noise);
  put(Channel::pvdf_b, force_b_ + 0.8 * hum, config_.force_noise);
  put(Channel::laser, travel, 0.0);
  put(Channel::coil_current, current * share, config_.current_noise);
  put(Channel::coil_voltage, voltage * share, config_.voltage_noise);
  put(Channel::mains_voltage, mains * share, config_.voltage_noise);
  put(Channel::contact_a, contact * share, config_.contact_noise);
  put(Channel::aux, acceleration * share * aux_full_scale / config_.accelerometer_full_scale,
      config_.accelerometer_noise * aux_full_scale / config_.accelerometer_full_scale);
}

}  // namespace powbench::rigs
