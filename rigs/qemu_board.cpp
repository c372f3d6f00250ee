#include "rigs/qemu_board.h"

#include <algorithm>
#include <cassert>

#include "rigs/rig.h"

namespace powbench::rigs {

namespace lockstep = firmware::lockstep;
using lockstep::Kind;

namespace {

const char* sentence(lockstep::Refused why) {
  switch (why) {
    case lockstep::Refused::damaged:
      return "a frame was damaged";
    case lockstep::Refused::out_of_step:
      return "a frame is missing";
    case lockstep::Refused::unknown_kind:
      return "a frame is of a kind it does not know; build image and program from the same sources";
    case lockstep::Refused::other_layout:
      return "the image was built from other sources than this program";
    case lockstep::Refused::too_long:
      return "the record is longer than its memory";
  }
  return "for an unknown reason";
}

}  // namespace

QemuBoard::QemuBoard(bool count_instructions, const firmware::ControllerConfig& config,
                     const firmware::Identity& identity, const std::string& image)
    : process_(image, count_instructions), outgoing_(lockstep::largest_frame), frame_(outgoing_) {
  const std::string_view texts[] = {config.calibration_id, identity.kind,    identity.model,
                                    identity.serial,       identity.version, identity.specimen,
                                    identity.boot_id,      identity.secret};
  lockstep::Configure head{.sample_rate = config.sample_rate,
                           .record_length = config.record_length,
                           .pretrigger = config.pretrigger,
                           .calibration_bytes = sizeof config.calibration,
                           .phase_bytes = sizeof config.phase,
                           .fire_bytes = sizeof config.fire,
                           .interlock_bytes = sizeof config.interlocks,
                           .block_bytes = lockstep::block_input_bytes,
                           .answer_bytes = sizeof(lockstep::Answer),
                           .edge_bytes = sizeof(firmware::GateEdge),
                           .text_bytes = {},
                           .reserved = {}};
  for (std::size_t i = 0; i < std::size(texts); ++i)
    head.text_bytes[i] = static_cast<std::uint16_t>(std::min<std::size_t>(texts[i].size(), 1000));
  begin(Kind::configure);
  frame_.put(head);
  frame_.put(config.calibration);
  frame_.put(config.phase);
  frame_.put(config.fire);
  frame_.put(config.interlocks);
  for (std::size_t i = 0; i < std::size(texts); ++i) frame_.put(texts[i].data(), head.text_bytes[i]);
  exchange();
}

void QemuBoard::begin(Kind kind, unsigned connection) {
  frame_.begin(kind, static_cast<std::uint16_t>(connection));
}

void QemuBoard::step(std::span<const firmware::Block> blocks, std::vector<firmware::GateEdge>& edges) {
  assert(blocks.size() <= lockstep::largest_batch);
  begin(Kind::step);
  frame_.put(lockstep::StepHead{static_cast<std::uint32_t>(blocks.size()), measure_});
  for (const firmware::Block& block : blocks) {
    frame_.put(lockstep::BlockHead{block.first_sample, static_cast<std::uint32_t>(block.samples()), 0});
    frame_.put(lockstep::inputs_of(block), lockstep::block_input_bytes);
    frame_.put(block.scans.data(), block.scans.size_bytes());
  }
  exchange(&edges);
}

void QemuBoard::publish(const firmware::SetPoints& set_points, const firmware::PlantTruth& truth) {
  begin(Kind::publish);
  frame_.put(lockstep::Published{set_points, truth});
  exchange();
}

Board::Answer QemuBoard::feed(unsigned connection, std::span<const std::uint8_t> bytes) {
  bytes = bytes.first(std::min(bytes.size(), lockstep::longest_feed));
  begin(Kind::feed, connection);
  frame_.put(bytes.data(), bytes.size());
  return exchange();
}
Board::Answer QemuBoard::resume(unsigned connection) {
  begin(Kind::resume, connection);
  return exchange();
}
Board::Answer QemuBoard::expire(unsigned connection) {
  begin(Kind::expire, connection);
  return exchange();
}
void QemuBoard::close(unsigned connection) {
  begin(Kind::close, connection);
  exchange();
}

void QemuBoard::rest(std::int64_t ms) {
  begin(Kind::rest);
  frame_.put(lockstep::Rested{ms});
  exchange();
}

lockstep::Cost QemuBoard::cost() {
  begin(Kind::cost);
  exchange();
  return cost_;
}

/// Waits for one whole frame; it stays valid until the next one.
std::span<const std::uint8_t> QemuBoard::receive_frame() {
  incoming_.erase(incoming_.begin(), incoming_.begin() + static_cast<std::ptrdiff_t>(taken_));
  taken_ = 0;
  for (;;) {
    bool damaged = false;
    const std::size_t length = lockstep::frame_length(incoming_, damaged);
    if (damaged) throw RigError("the emulated board sent something that is no frame");
    if (length > 0 && incoming_.size() >= length) {
      taken_ = length;
      return std::span(incoming_).first(length);
    }
    process_.receive(incoming_);
  }
}

Board::Answer QemuBoard::exchange(std::vector<firmware::GateEdge>* edges) {
  process_.send(frame_.finish(sequence_));
  Answer out;
  for (;;) {
    lockstep::Reader reader(receive_frame());
    if (!reader.whole()) throw RigError("the emulated board sent a damaged frame");
    const lockstep::Header& header = reader.header();
    if (header.kind == Kind::refused)
      throw RigError(std::string("the emulated board refuses: ") + sentence(reader.get<lockstep::Refused>()));
    if (header.sequence != sequence_) throw RigError("the emulated board answered out of step");
    if (header.kind == Kind::more) {
      out.bytes.insert(out.bytes.end(), reader.rest().begin(), reader.rest().end());
      continue;
    }
    const auto a = reader.get<lockstep::Answer>();
    for (int i = 0; i < a.edges; ++i) {
      const auto edge = reader.get<firmware::GateEdge>();
      if (edges) edges->push_back(edge);
    }
    if (a.has_cost) reader.get(cost_);
    if (!reader.whole()) throw RigError("the emulated board sent a short frame");
    report_ = a.report;
    out.used = a.used;
    out.status = a.status;
    out.halfway = a.halfway;
    out.timeout_ms = a.timeout_ms;
    ++sequence_;
    return out;
  }
}

lockstep::Refused QemuBoard::send_raw(std::span<const std::uint8_t> bytes) {
  process_.send(bytes);
  lockstep::Reader reader(receive_frame());
  if (!reader.whole() || reader.header().kind != Kind::refused)
    throw RigError("the emulated board did not refuse");
  return reader.get<lockstep::Refused>();
}

}  // namespace powbench::rigs
