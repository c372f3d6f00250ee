#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "core/channels.h"
#include "core/crc32.h"
#include "firmware/bench.h"

/// The frames of the lock-step between plant and emulated board, shared by both ends. The plant asks, the
/// board answers; nothing else is ever on the line. Little-endian, fixed-width fields, CRC-32 behind each
/// frame.

namespace powbench::firmware::lockstep {

static_assert(std::endian::native == std::endian::little, "frames are copied, not translated");

inline constexpr std::uint32_t magic = 0x31425750;         // "PWB1"
inline constexpr std::size_t largest_frame = 32 * 1024;    ///< bytes, header and CRC included
inline constexpr std::size_t largest_batch = 32;           ///< blocks in one frame
inline constexpr std::size_t largest_block = 64;           ///< samples in one block
inline constexpr std::size_t longest_feed = 4 * 1024;      ///< protocol bytes in one frame
inline constexpr std::int64_t longest_record = 1'000'000;  ///< scans: 16 MB of memory for records
inline constexpr std::size_t crc_bytes = sizeof(std::uint32_t);

enum class Kind : std::uint16_t {
  // plant to board
  configure = 1,  ///< Configure, then the texts; the first frame, once
  step,           ///< StepHead, then per block BlockHead and its scans
  publish,        ///< Published: set-points and truth for the source device
  feed,           ///< protocol bytes of a client
  resume,         ///< samples may have arrived for a waiting READBUF
  expire,         ///< the time of a waiting READBUF is up
  close,          ///< the client is gone
  cost,           ///< asks for Cost
  rest,           ///< Rested: time that passed for the lease alone
  // board to plant
  more = 64,  ///< protocol bytes; the answer goes on in the next frame
  answer,     ///< Answer, then its edges, then protocol bytes
  refused,    ///< a Refusal; the board stops
};

enum class Refused : std::uint32_t {
  damaged = 1,   ///< magic, length or CRC is wrong
  out_of_step,   ///< a frame is missing or came twice
  unknown_kind,  ///< of another version
  other_layout,  ///< the two ends were compiled from different sources
  too_long,      ///< record, batch or text beyond what the board holds
};

struct Header {
  std::uint32_t magic;
  std::uint32_t bytes;  ///< of the whole frame
  std::uint32_t sequence;
  Kind kind;
  std::uint16_t connection;
};
static_assert(sizeof(Header) == 16);

/// Followed by four structures and eight texts. The sizes let a board of other sources refuse.
struct Configure {
  std::int64_t sample_rate, record_length, pretrigger;
  std::uint32_t calibration_bytes, phase_bytes, fire_bytes, interlock_bytes;
  std::uint32_t block_bytes, answer_bytes, edge_bytes;
  std::uint16_t text_bytes[8];  ///< calibration, kind, model, serial, version, specimen, boot, secret
  std::uint16_t reserved[2];
};
static_assert(sizeof(Configure) == 72);

struct StepHead {
  std::uint32_t blocks;
  std::uint32_t measure;  ///< 1: count the instructions of these blocks
};

/// What a block carries beside its samples travels as it lies in memory: both compilers lay out fixed-width
/// members alike, and the sizes are compared in Configure.
inline constexpr std::size_t block_inputs_at = sizeof(std::int64_t) + sizeof(std::span<const std::int16_t>);
inline constexpr std::size_t block_input_bytes = sizeof(Block) - block_inputs_at;
static_assert(std::is_trivially_copyable_v<Block> && std::is_standard_layout_v<Block>);
static_assert(offsetof(Block, scans) == sizeof(std::int64_t), "the pointer stands between number and inputs");
inline const std::uint8_t* inputs_of(const Block& block) {
  return reinterpret_cast<const std::uint8_t*>(&block) + block_inputs_at;
}
inline std::uint8_t* inputs_of(Block& block) {
  return reinterpret_cast<std::uint8_t*>(&block) + block_inputs_at;
}

/// Followed by the inputs and the scans.
struct BlockHead {
  std::int64_t first_sample;
  std::uint32_t samples, unused;
};
static_assert(sizeof(BlockHead) == 16);

struct Published {
  SetPoints set_points;
  PlantTruth truth;
};
static_assert(sizeof(Published) == 72);

struct Rested {
  std::int64_t ms;
};

/// Followed by the edges.
struct Answer {
  BenchReport report;
  std::uint32_t used;       ///< bytes of a feed that were taken
  std::int32_t timeout_ms;  ///< as iiod::Connection::timeout_ms()
  Bench::Status status;
  bool halfway;   ///< as iiod::Connection::halfway()
  bool has_cost;  ///< a Cost follows the edges
  std::uint16_t edges;
};
static_assert(std::is_trivially_copyable_v<Answer> && std::is_trivially_copyable_v<GateEdge>);

/// What the blocks that were measured cost, in ticks of the board's 25 MHz timer, and the deepest stack so
/// far.
struct Cost {
  std::uint64_t control_ticks;     ///< the samples' interrupt
  std::uint64_t background_ticks;  ///< the level below it, blocks in which the estimate was not renewed
  std::uint64_t update_ticks;      ///< the same, blocks in which it was
  std::uint32_t blocks, update_blocks, samples;
  std::uint32_t worst_control_ticks, worst_background_ticks;  ///< of a block
  std::uint32_t stack_bytes, empty_ticks;                     ///< deepest stack; what measuring itself takes
  std::uint32_t reserved;
};
static_assert(sizeof(Cost) == 56);

/// Fills a frame from the front. What does not fit is a bug of the caller.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> memory) : memory_(memory) {}

  void begin(Kind kind, std::uint16_t connection = 0) {
    kind_ = kind;
    connection_ = connection;
    size_ = sizeof(Header);
  }
  void put(const void* bytes, std::size_t n) {
    if (n == 0) return;  // an empty range may have no address
    std::memcpy(memory_.data() + size_, bytes, n);
    size_ += n;
  }
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(&value, sizeof value);
  }
  /// Bytes that still fit.
  std::size_t room() const { return memory_.size() - size_ - crc_bytes; }

  std::span<const std::uint8_t> finish(std::uint32_t sequence) {
    const Header header{magic, static_cast<std::uint32_t>(size_ + crc_bytes), sequence, kind_, connection_};
    std::memcpy(memory_.data(), &header, sizeof header);
    const std::uint32_t crc = crc32({memory_.data(), size_});
    put(crc);
    return {memory_.data(), size_};
  }

 private:
  std::span<std::uint8_t> memory_;
  std::size_t size_ = 0;
  Kind kind_{};
  std::uint16_t connection_ = 0;
};

/// Bytes of the frame that starts with `bytes`; 0: too few to tell, or no frame (then `damaged` is set).
inline std::size_t frame_length(std::span<const std::uint8_t> bytes, bool& damaged) {
  if (bytes.size() < sizeof(Header)) return 0;
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  damaged =
      header.magic != magic || header.bytes < sizeof(Header) + crc_bytes || header.bytes > largest_frame;
  return damaged ? 0 : header.bytes;
}

/// Takes a whole frame apart, from the front. Reading beyond its end gives zeros and whole() = false.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> frame) : rest_(frame.first(frame.size() - crc_bytes)) {
    std::uint32_t crc = 0;
    std::memcpy(&crc, frame.data() + rest_.size(), sizeof crc);
    whole_ = crc32(rest_) == crc;
    header_ = get<Header>();
  }

  const Header& header() const { return header_; }
  bool whole() const { return whole_; }
  std::span<const std::uint8_t> rest() const { return rest_; }

  std::span<const std::uint8_t> bytes(std::size_t n) {
    if (n > rest_.size()) {
      whole_ = false;
      return {};
    }
    const auto taken = rest_.first(n);
    rest_ = rest_.subspan(n);
    return taken;
  }
  template <class T>
  bool get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto from = bytes(sizeof value);
    if (from.empty()) return false;
    std::memcpy(&value, from.data(), sizeof value);
    return true;
  }
  template <class T>
  T get() {
    T value{};
    get(value);
    return value;
  }

 private:
  std::span<const std::uint8_t> rest_;
  Header header_{};
  bool whole_ = false;
};

}  // namespace powbench::firmware::lockstep
