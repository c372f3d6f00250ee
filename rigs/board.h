#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/bench.h"

/// A board as the simulated plant sees it: samples in, gate edges out, and the protocol of its clients. The
/// same firmware runs behind it, either compiled into this program or on an emulated processor.

namespace powbench::rigs {

class Board {
 public:
  using Status = firmware::Bench::Status;

  /// Answer to protocol bytes.
  struct Answer {
    std::size_t used = 0;  ///< bytes that were taken; the others are to come again
    Status status = Status::ready;
    bool halfway = false;          ///< a request has begun to arrive and is not whole
    std::int32_t timeout_ms = -1;  ///< this client's, 0: none; negative: it has not asked for one
    std::vector<std::uint8_t> bytes;
  };

  virtual ~Board() = default;

  /// Runs the controller over the blocks, one after the other, and appends the edges to `edges`. Several at
  /// once only while no edge can come: not firing, gate off.
  virtual void step(std::span<const firmware::Block> blocks, std::vector<firmware::GateEdge>& edges) = 0;
  /// After the last call of any of the others.
  virtual const firmware::BenchReport& report() const = 0;
  /// What the source device shows from now on.
  virtual void publish(const firmware::SetPoints&, const firmware::PlantTruth&) = 0;

  /// Connections 0 .. firmware::Bench::max_connections - 1.
  virtual Answer feed(unsigned connection, std::span<const std::uint8_t> bytes) = 0;
  virtual Answer resume(unsigned connection) = 0;
  virtual Answer expire(unsigned connection) = 0;
  virtual void close(unsigned connection) = 0;
  /// Wall time that passed, ms: it counts for the lease alone.
  virtual void rest(std::int64_t ms) = 0;

  /// The firmware itself where it runs in this process, for whoever feeds it as another kind of port would; else
  /// nullptr.
  virtual firmware::Bench* native() { return nullptr; }

  /// The calling thread is the one that will drive the board for long.
  virtual void adopt_thread() {}
};

/// Which board.
struct BoardOptions {
  enum class Kind : std::uint8_t { native, emulated };
  Kind kind = Kind::native;
  bool count_instructions = false;  ///< emulated: virtual time advances by instructions, reproducibly
  std::string boot_id{};            ///< tells one start from another; empty: all starts look alike
  std::string secret{};             ///< what every owner's token must begin with; empty: anything
  /// Silence after which a client makes room for another; unset: 10 s.
  std::optional<std::chrono::milliseconds> idle{};
  /// Time after which the client that came last makes room when none was silent for so long; unset: 0.25 s.
  std::optional<std::chrono::milliseconds> stay{};
};
inline const BoardOptions emulated_board{BoardOptions::Kind::emulated, false, {}, {}, {}, {}};

/// Throws RigError when an emulated board cannot be had.
std::unique_ptr<Board> make_board(const BoardOptions&, const firmware::ControllerConfig&,
                                  const firmware::Identity&);

}  // namespace powbench::rigs
