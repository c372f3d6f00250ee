#include "dsp/filter/cascade.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dsp/filter/sos.h"

namespace powbench::dsp {

namespace {

/// Largest pole radius, as 1 - r without cancellation.
double slowest_decay(std::span<const Section> sections) {
  double least = 1;
  for (const Section& q : sections) {
    // poles of delta^2 + d1 delta + d0
    const double half = q.d1 / 2, discriminant = half * half - q.d0;
    if (discriminant < 0) {
      const double loss = q.d1 - q.d0;  // 1 - |z|^2
      least = std::min(least, loss / (1 + std::sqrt(std::max(0.0, 1 - loss))));
    } else {
      const double slow = q.d0 / (half + std::sqrt(discriminant));  // 1 - z of the slower pole
      least = std::min({least, slow, 2 - half - std::sqrt(discriminant)});
    }
  }
  return least;
}

void require_frames(std::size_t size) {
  if (size % lanes)
    throw std::invalid_argument("frames = " + std::to_string(size) + " values: allowed multiples of " +
                                std::to_string(lanes));
}

/// A value that is not finite never leaves the state again.
void require_finite(const std::vector<double>& state) {
  double sum = 0;
  for (const double v : state) sum += v * 0;
  if (sum != 0) throw std::invalid_argument("record: allowed finite values only; bridge gaps first");
}

/// Spreads the state of one lane over all, scaled by `level` for each lane: (2 sections, 8).
std::vector<double> spread(const std::vector<double>& unit, const double* level) {
  std::vector<double> out(unit.size() * lanes);
  for (std::size_t i = 0; i < unit.size(); ++i)
    for (std::size_t w = 0; w < lanes; ++w) out[i * lanes + w] = unit[i] * level[w];
  return out;
}

}  // namespace

SosProgram::SosProgram(std::span<const Section> sections) : sections_(sections.begin(), sections.end()) {
  difference_ = !sections_.empty() && sections_.front().n0 == 0.0;
  if (difference_) {  // delta (b0 delta + n1) = (z - 1) (b0 delta + n1), of which (z - 1) / z is the difference
    Section& q = sections_.front();
    q = {q.b0, q.b0 + q.n1, q.n1, q.d1, q.d0};
  }
  for (const Section& q : sections_)
    coefficients_.push_back({q.b0, 1 - q.d1, q.n1 - q.d1 * q.b0, q.n0 - q.d0 * q.b0, q.d0});
}

std::vector<double> SosProgram::steady(double level) const {
  std::vector<double> state{difference_ ? level : 0.0};
  if (difference_) level = 0;
  for (const Section& q : sections_) {
    const double y = level * (q.n0 / q.d0);
    const double s1 = y - q.b0 * level;
    state.push_back(s1);
    state.push_back(q.d1 * s1 - (q.n1 - q.d1 * q.b0) * level);
    level = y;
  }
  return state;
}

Cascade::Cascade(std::vector<Section> sections, const SosKernel& kernel)
    : sections_(std::move(sections)), program_(sections_), kernel_(&kernel) {
  if (sections_.empty()) throw std::invalid_argument("sections = 0: allowed at least one");
  memory_ = filter_memory(sections_, 1e-6);
  // From 1e-6 on the slowest pole decides; a quarter on top for the poles beside it.
  const double decay = slowest_decay(sections_);
  warm_up_ = memory_ + static_cast<std::size_t>(std::ceil(1.25 * std::log(1e11) / decay));
}

void Cascade::pass_pieces(double* first, std::ptrdiff_t step, std::size_t n,
                          const std::vector<double>& state) const {
  const std::size_t piece = n / lanes / 8 * 8;
  const std::ptrdiff_t stride = step * static_cast<std::ptrdiff_t>(piece);
  const std::ptrdiff_t back = step * static_cast<std::ptrdiff_t>(warm_up_);
  // Lanes 1 .. 7 see the samples before their piece; lane 0 has none and reads lane 1's, then gets its own state.
  double level[lanes];
  for (std::size_t w = 0; w < lanes; ++w)
    level[w] = first[static_cast<std::ptrdiff_t>(std::max<std::size_t>(w, 1)) * stride - back];
  std::vector<double> lane_state = spread(program_.steady(1.0), level);
  alignas(64) double tile[64 * lanes];
  for (std::size_t i = 0; i < warm_up_;) {
    const std::size_t now = std::min<std::size_t>(64, warm_up_ - i);
    for (std::size_t w = 0; w < lanes; ++w) {
      const double* from = first + static_cast<std::ptrdiff_t>(std::max<std::size_t>(w, 1)) * stride - back +
                           step * static_cast<std::ptrdiff_t>(i);
      for (std::size_t j = 0; j < now; ++j) tile[j * lanes + w] = from[step * static_cast<std::ptrdiff_t>(j)];
    }
    kernel_->run_frames(program_.loop(), lane_state.data(), tile, 1, now);
    i += now;
  }
  for (std::size_t i = 0; i < state.size(); ++i) lane_state[i * lanes] = state[i];
  kernel_->run_pieces(program_.loop(), lane_state.data(), first, first, stride, step, piece);
  std::vector<double> rest(state.size());
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = lane_state[i * lanes + lanes - 1];
  const std::size_t done = piece * lanes;
  kernel_->run_one(program_.loop(), rest.data(), first + step * static_cast<std::ptrdiff_t>(done), step,
                   n - done);
  lane_state.insert(lane_state.end(), rest.begin(), rest.end());
  require_finite(lane_state);
}

void Cascade::pass(double* first, std::ptrdiff_t step, std::size_t n, std::vector<double> state) const {
  // whole blocks of eight samples a piece, each with a whole warm-up before it
  if (n / lanes / 8 * 8 >= warm_up_ && n >= 4096) return pass_pieces(first, step, n, state);
  kernel_->run_one(program_.loop(), state.data(), first, step, n);
  require_finite(state);
}

void Cascade::pass_frames(double* first, std::ptrdiff_t step, std::size_t frames, bool steady) const {
  const double zero[lanes]{};
  std::vector<double> state = spread(program_.steady(1.0), steady ? first : zero);
  kernel_->run_frames(program_.loop(), state.data(), first, step, frames);
  require_finite(state);
}

void Cascade::forward(std::span<double> x) const {
  if (!x.empty()) pass(x.data(), 1, x.size(), program_.rest());
}

void Cascade::forward_frames(std::span<double> x) const {
  require_frames(x.size());
  if (!x.empty()) pass_frames(x.data(), 1, x.size() / lanes, false);
}

void Cascade::zero_phase(std::span<double> x) const {
  if (x.empty() || x.size() < memory_) throw FilterMemoryError(x.size(), memory_);
  pass(x.data(), 1, x.size(), program_.steady(x.front()));
  pass(x.data() + x.size() - 1, -1, x.size(), program_.steady(x.back()));
}

void Cascade::zero_phase_frames(std::span<double> x) const {
  require_frames(x.size());
  const std::size_t frames = x.size() / lanes;
  if (frames == 0 || frames < memory_) throw FilterMemoryError(frames, memory_);
  pass_frames(x.data(), 1, frames, true);
  pass_frames(x.data() + (frames - 1) * lanes, -1, frames, true);
}

CascadeStream::CascadeStream(const Cascade& cascade) : cascade_(&cascade), state_(cascade.program_.rest()) {}

void CascadeStream::push(std::span<double> x) {
  cascade_->kernel().run_one(cascade_->program_.loop(), state_.data(), x.data(), 1, x.size());
  position_ += static_cast<std::int64_t>(x.size());
  require_finite(state_);
}

ZeroPhaseStream::ZeroPhaseStream(const Cascade& cascade, std::size_t block)
    : cascade_(&cascade),
      block_(block ? block : std::max<std::size_t>(65536, 4 * cascade.warm_up())),
      state_(cascade.program_.rest()) {
  held_.reserve(block_ + cascade.warm_up());
  work_.reserve(block_ + cascade.warm_up());
}

void ZeroPhaseStream::push(std::span<const double> x, std::vector<double>& out) {
  if (x.empty()) return;
  if (position_ == 0) state_ = cascade_->program_.steady(x.front());
  const std::size_t full = block_ + cascade_->warm_up();
  while (!x.empty()) {
    const std::size_t now = std::min(x.size(), full - held_.size());
    held_.insert(held_.end(), x.begin(), x.begin() + static_cast<std::ptrdiff_t>(now));
    cascade_->kernel().run_one(cascade_->program_.loop(), state_.data(), held_.data() + held_.size() - now, 1,
                               now);
    position_ += static_cast<std::int64_t>(now);
    x = x.subspan(now);
    if (held_.size() == full) release(block_, false, out);
  }
}

void ZeroPhaseStream::release(std::size_t samples, bool at_end, std::vector<double>& out) {
  work_.assign(held_.begin(), held_.end());
  const std::size_t n = work_.size();
  // Inside the record any start will do, it is forgotten; at its end the steady state, as in zero_phase().
  cascade_->pass(work_.data() + n - 1, -1, n, cascade_->program_.steady(work_.back()));
  out.insert(out.end(), work_.begin(), work_.begin() + static_cast<std::ptrdiff_t>(samples));
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(samples));
  finished_ += static_cast<std::int64_t>(samples);
  if (at_end) position_ = finished_;
}

void ZeroPhaseStream::finish(std::vector<double>& out) {
  if (position_ == 0 || position_ < static_cast<std::int64_t>(cascade_->memory()))
    throw FilterMemoryError(static_cast<std::size_t>(position_), cascade_->memory());
  if (!held_.empty()) release(held_.size(), true, out);
}

}  // namespace powbench::dsp
