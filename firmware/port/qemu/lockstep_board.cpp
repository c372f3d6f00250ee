#include "firmware/port/qemu/lockstep_board.h"

namespace powbench::firmware::lockstep {

/// Collects an answer. Protocol bytes leave in frames of their own, as many as they need, ahead of it.
class LockstepBoard::Sender final : public iiod::ByteSink {
 public:
  Sender(LockstepBoard& board, std::uint32_t sequence, std::uint16_t connection)
      : sequence_(sequence), connection_(connection), board_(board), bytes_(board.out_) {
    bytes_.begin(Kind::more, connection_);
  }

  void put(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const std::size_t n = bytes.size() < bytes_.room() ? bytes.size() : bytes_.room();
      bytes_.put(bytes.data(), n);
      held_ += n;
      bytes = bytes.subspan(n);
      if (!bytes.empty()) flush();
    }
  }
  void flush() {
    if (held_ > 0) board_.platform_.send(bytes_.finish(sequence_));
    bytes_.begin(Kind::more, connection_);
    held_ = 0;
  }

  std::uint32_t used = 0;
  std::uint32_t sequence_;
  std::uint16_t connection_;

 private:
  LockstepBoard& board_;
  Writer bytes_;
  std::size_t held_ = 0;
};

void LockstepBoard::refuse(Refused why) {
  Writer writer(out_);
  writer.begin(Kind::refused);
  writer.put(why);
  platform_.send(writer.finish(expected_));
}

bool LockstepBoard::handle(std::span<const std::uint8_t> frame) {
  Reader reader(frame);
  const Header& header = reader.header();
  if (!reader.whole()) return refuse(Refused::damaged), false;
  if (header.sequence != expected_) return refuse(Refused::out_of_step), false;
  if ((header.kind == Kind::configure) == bench_.has_value() || header.connection >= Bench::max_connections)
    return refuse(Refused::unknown_kind), false;
  Sender out(*this, header.sequence, header.connection);
  edge_count_ = 0;
  switch (header.kind) {
    case Kind::configure:
      if (!configure(reader)) return false;
      break;
    case Kind::step:
      if (!step(reader)) return false;
      break;
    case Kind::publish: {
      const auto published = reader.get<Published>();
      bench_->source().set_points = published.set_points;
      bench_->source().truth = published.truth;
      break;
    }
    case Kind::feed:
    case Kind::resume:
    case Kind::expire:
    case Kind::close:
      protocol(reader, out);
      break;
    case Kind::rest:
      bench_->rest(reader.get<Rested>().ms);
      break;
    case Kind::cost:
      break;
    default:
      return refuse(Refused::unknown_kind), false;
  }
  ++expected_;
  answer(out, header.kind == Kind::cost);
  return true;
}

bool LockstepBoard::configure(Reader& in) {
  const auto head = in.get<Configure>();
  ControllerConfig config;
  if (head.calibration_bytes != sizeof config.calibration || head.phase_bytes != sizeof config.phase ||
      head.fire_bytes != sizeof config.fire || head.interlock_bytes != sizeof config.interlocks ||
      head.block_bytes != block_input_bytes || head.answer_bytes != sizeof(Answer) ||
      head.edge_bytes != sizeof(GateEdge))
    return refuse(Refused::other_layout), false;
  config.sample_rate = head.sample_rate;
  config.record_length = head.record_length;
  config.pretrigger = head.pretrigger;
  in.get(config.calibration);
  in.get(config.phase);
  in.get(config.fire);
  in.get(config.interlocks);
  std::string_view text[std::size(head.text_bytes)];
  std::size_t used = 0;
  for (std::size_t i = 0; i < std::size(text); ++i) {
    const auto bytes = in.bytes(head.text_bytes[i]);
    if (used + bytes.size() > texts_.size()) return refuse(Refused::too_long), false;
    if (!bytes.empty()) std::memcpy(texts_.data() + used, bytes.data(), bytes.size());
    text[i] = {texts_.data() + used, bytes.size()};
    used += bytes.size();
  }
  // the ring also holds the block that arrives while the record's first scan is still wanted
  const auto scans = static_cast<std::size_t>(head.record_length) + largest_block;
  if (!in.whole() || head.record_length < 1 || scans * channel_count > storage_.size())
    return refuse(Refused::too_long), false;
  config.calibration_id = text[0];
  const Identity identity{.kind = text[1],
                          .model = text[2],
                          .serial = text[3],
                          .version = text[4],
                          .specimen = text[5],
                          .boot_id = text[6],
                          .secret = text[7]};
  bench_.emplace(config, identity, storage_.first(scans * channel_count));
  return true;
}

bool LockstepBoard::step(Reader& in) {
  const auto head = in.get<StepHead>();
  if (head.blocks > largest_batch) return refuse(Refused::too_long), false;
  for (std::uint32_t b = 0; b < head.blocks; ++b) {
    const auto block_head = in.get<BlockHead>();
    const auto inputs = in.bytes(block_input_bytes);
    const auto scans = in.bytes(std::size_t{2} * channel_count * block_head.samples);
    if (!in.whole() || block_head.samples < 1 || block_head.samples > largest_block)
      return refuse(Refused::damaged), false;
    // where the converters' DMA would have left them, aligned
    static std::array<std::int16_t, largest_block * channel_count> dma;
    std::memcpy(dma.data(), scans.data(), scans.size());
    Block block{.first_sample = block_head.first_sample,
                .scans = {dma.data(), block_head.samples * channel_count}};
    std::memcpy(inputs_of(block), inputs.data(), inputs.size());
    const auto edges = platform_.run_block(*bench_, block, head.measure != 0);
    bench_->note(edges);
    for (const GateEdge& edge : edges)
      if (edge_count_ < edges_.size()) edges_[edge_count_++] = edge;
  }
  return true;
}

void LockstepBoard::protocol(Reader& in, Sender& out) {
  const Header& header = in.header();
  if (header.kind == Kind::feed)
    out.used = static_cast<std::uint32_t>(bench_->feed(header.connection, in.rest(), out));
  if (header.kind == Kind::resume) bench_->resume(header.connection, out);
  if (header.kind == Kind::expire) bench_->expire(header.connection, out);
  if (header.kind == Kind::close) bench_->close(header.connection);
}

void LockstepBoard::answer(Sender& out, bool with_cost) {
  out.flush();
  const iiod::Connection& connection = bench_->connection(out.connection_);
  const Answer a{.report = bench_->report(),
                 .used = out.used,
                 .timeout_ms = connection.timeout_ms(),
                 .status = connection.status(),
                 .halfway = connection.halfway(),
                 .has_cost = with_cost,
                 .edges = edge_count_};
  Writer writer(out_);
  writer.begin(Kind::answer, out.connection_);
  writer.put(a);
  writer.put(edges_.data(), sizeof(GateEdge) * edge_count_);
  if (with_cost) writer.put(platform_.cost());
  platform_.send(writer.finish(out.sequence_));
}

}  // namespace powbench::firmware::lockstep
