#include "rigs/native_board.h"

#include "rigs/qemu_board.h"

namespace powbench::rigs {

namespace {

/// Collects the answers of one feed, so that number, mask and payload leave in one gathered write.
class Collector final : public firmware::iiod::ByteSink {
 public:
  void put(std::span<const std::uint8_t> bytes) override {
    data.insert(data.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::uint8_t> data;
};

class NativeBoard final : public Board {
 public:
  NativeBoard(const firmware::ControllerConfig& config, const firmware::Identity& identity)
      : storage_(static_cast<std::size_t>(config.record_length + spare_scans) * channel_count),
        bench_(config, identity, storage_) {
    look();
  }

  void step(std::span<const firmware::Block> blocks, std::vector<firmware::GateEdge>& edges) override {
    for (const firmware::Block& block : blocks) {
      const auto found = bench_.step(block);
      bench_.note(found);
      edges.insert(edges.end(), found.begin(), found.end());
    }
    look();
  }
  const firmware::BenchReport& report() const override { return report_; }
  void publish(const firmware::SetPoints& set_points, const firmware::PlantTruth& truth) override {
    bench_.source().set_points = set_points;
    bench_.source().truth = truth;
    look();
  }

  Answer feed(unsigned connection, std::span<const std::uint8_t> bytes) override {
    Collector out;
    const std::size_t used = bench_.feed(connection, bytes, out);
    return answered(connection, used, out);
  }
  Answer resume(unsigned connection) override {
    Collector out;
    bench_.resume(connection, out);
    return answered(connection, 0, out);
  }
  Answer expire(unsigned connection) override {
    Collector out;
    bench_.expire(connection, out);
    return answered(connection, 0, out);
  }
  void close(unsigned connection) override {
    bench_.close(connection);
    look();
  }
  void rest(std::int64_t ms) override {
    bench_.rest(ms);
    look();
  }
  firmware::Bench* native() override { return &bench_; }

 private:
  static constexpr std::int64_t spare_scans = 64;  // the ring holds more than the record, as on the board

  Answer answered(unsigned connection, std::size_t used, Collector& out) {
    look();
    const auto& c = bench_.connection(connection);
    return {used, c.status(), c.halfway(), c.timeout_ms(), std::move(out.data)};
  }
  void look() { report_ = bench_.report(); }

  std::vector<std::int16_t> storage_;
  firmware::Bench bench_;
  firmware::BenchReport report_;
};

}  // namespace

std::unique_ptr<Board> make_native_board(const firmware::ControllerConfig& config,
                                         const firmware::Identity& identity) {
  return std::make_unique<NativeBoard>(config, identity);
}

std::unique_ptr<Board> make_board(const BoardOptions& options, const firmware::ControllerConfig& config,
                                  const firmware::Identity& identity) {
  if (options.kind == BoardOptions::Kind::emulated)
    return std::make_unique<QemuBoard>(options.count_instructions, config, identity);
  return make_native_board(config, identity);
}

}  // namespace powbench::rigs
