#include "dsp/events/event_stream.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dsp/contacts/contact_voltage.h"
#include "dsp/contacts/detect_round.h"
#include "dsp/events/extract.h"
#include "dsp/filter/force.h"

namespace powbench::dsp {

namespace {

using Kind = StreamEvent::Kind;
constexpr Channel films[] = {Channel::pvdf_a, Channel::pvdf_b};
constexpr double same = 60e-6;  ///< s: a later look may date an edge so much otherwise

/// Touches and releases of a train in order of time.
std::vector<StreamEvent> edges_of(const ContactTrain& t, Channel c, double known) {
  std::vector<StreamEvent> out;
  for (const Contact& contact : t.contacts) {
    if (contact.touch.known()) out.push_back({c, Kind::touch, contact.touch, known});
    if (contact.release.known()) out.push_back({c, Kind::release, contact.release, known});
  }
  return out;
}

}  // namespace

EventStream::EventStream(Record shape, const ExtractOptions& options)
    : record_(std::move(shape)), options_(options) {
  check(options_);
  const double rate = record_.sample_rate;
  if (!(std::isfinite(rate) && rate > 0))
    throw std::invalid_argument("sample_rate = " + std::to_string(rate) + " Hz: allowed above 0");
  if (record_.channels.empty()) throw std::invalid_argument("no channel to stream");
  const auto most = static_cast<std::int64_t>(stream_longest * rate);
  if (record_.fire_sample < 0 || record_.fire_sample > most)
    throw std::invalid_argument("fire_sample = " + std::to_string(record_.fire_sample) + ": allowed 0 .. " +
                                std::to_string(most) + ", " + std::to_string(stream_longest) + " s");
  for (ChannelRecord& c : record_.channels) c.raw.clear();
  block_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(stream_block * rate));
  next_ = record_.fire_sample + block_;
  limit_ = record_.fire_sample + most;
}

double EventStream::known() const {
  return record_.time(record_.samples()) - 1 / record_.sample_rate;
}

std::vector<StreamEvent> EventStream::push(std::int64_t first, std::span<const std::int16_t> scans) {
  const std::size_t width = record_.channels.size();
  if (first != came_)
    throw std::invalid_argument("sample " + std::to_string(first) + " came, " + std::to_string(came_) +
                                " follows: lost samples are filled and listed as gaps, not left out");
  if (scans.size() % width != 0)
    throw std::invalid_argument(std::to_string(scans.size()) + " values: allowed whole scans of " +
                                std::to_string(width) + " channels");
  std::vector<StreamEvent> out;
  came_ += static_cast<std::int64_t>(scans.size() / width);
  for (std::size_t at = 0; at < scans.size(); at += width) {
    const auto have = static_cast<std::int64_t>(record_.samples());
    if (have >= limit_) break;
    for (std::size_t c = 0; c < width; ++c) record_.channels[c].raw.push_back(scans[at + c]);
    if (have + 1 < next_) continue;
    next_ += block_;
    look(known(), known() - stream_wait, false, out);
  }
  return out;
}

std::vector<StreamEvent> EventStream::finish() {
  std::vector<StreamEvent> out;
  if (record_.samples() > 0) look(known(), known(), true, out);
  return out;
}

/// Detection alone: is there an edge that has become old enough since the last extraction?
bool EventStream::due(double until) const {
  const auto asked = [&](double t) { return t <= until && t > asked_ - same; };
  for (const Channel c : films) {
    const Force f = restore_force(record_, c, options_, std::nullopt);
    if (!f.present) continue;
    const double t_end = closing_end(record_, f.signal);
    for (const Interval& i : detect_round(f.signal, f.noise, f.settled, t_end, options_, false).intervals)
      if (asked(i.touch) || asked(i.release)) return true;
  }
  for (const Contact& i : contact_voltage_train(record_, options_).contacts)
    if (asked(i.touch.value) || (i.release.known() && asked(i.release.value))) return true;
  return false;
}

void EventStream::look(double known, double until, bool last, std::vector<StreamEvent>& out) {
  if (until < 0 || (!last && !due(until))) return;
  asked_ = until;
  const Events e = extract_events(record_, options_);
  std::vector<StreamEvent> fresh;
  const auto offer = [&](const std::vector<StreamEvent>& edges, Channel c) {
    auto& given = given_[index(c)];
    for (const StreamEvent& edge : edges) {
      if (edge.time.value > until) break;
      const bool in_turn = given.empty()
                               ? edge.kind != Kind::release
                               : edge.kind != given.back().kind && edge.time.value > given.back().time.value;
      const bool there = std::any_of(given.begin(), given.end(), [&](const StreamEvent& g) {
        return g.kind == edge.kind && std::abs(g.time.value - edge.time.value) < same;
      });
      if (!in_turn || there) continue;
      given.push_back(edge);
      fresh.push_back(edge);
    }
  };
  offer(edges_of(e.pvdf_a, Channel::pvdf_a, known), Channel::pvdf_a);
  offer(edges_of(e.pvdf_b, Channel::pvdf_b, known), Channel::pvdf_b);
  offer(edges_of(e.contact_voltage, Channel::contact_a, known), Channel::contact_a);
  if (e.core.seat.known() && given_[index(Channel::laser)].empty())
    offer({{Channel::laser, Kind::seat, e.core.seat, known}}, Channel::laser);
  std::stable_sort(fresh.begin(), fresh.end(),
                   [](const StreamEvent& a, const StreamEvent& b) { return a.time.value < b.time.value; });
  out.insert(out.end(), fresh.begin(), fresh.end());
}

}  // namespace powbench::dsp
