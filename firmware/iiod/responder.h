#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/iiod/model.h"

/// The IIOD text protocol (libiio 0.x), answered byte by byte. No heap, no exceptions, no blocking; one
/// request gives exactly one answer, in order. Written once; fed over TCP by the simulated rig and over a
/// UART by a board.

namespace powbench::firmware::iiod {

struct Words;

/// Takes answer bytes. `put` must accept everything; a port with a small buffer pauses feeding instead.
class ByteSink {
 public:
  virtual void put(std::span<const std::uint8_t> bytes) = 0;

 protected:
  ~ByteSink() = default;
};

/// State of one connection: a half-received line or payload, and the buffer it may have open.
class Connection {
 public:
  enum class Status : std::uint8_t {
    ready,    ///< waiting for bytes
    pending,  ///< a READBUF waits for samples: call Responder::resume, or Responder::expire to answer
              ///< -ETIMEDOUT
    closed,   ///< the client said EXIT
  };
  Status status() const { return status_; }
  /// A request has begun to arrive and is not whole.
  bool halfway() const { return line_length_ > 0 || line_overflow_ || write_.remaining > 0; }
  /// Time-out that this client has asked for, ms, 0 = none; negative: it has not asked.
  std::int32_t timeout_ms() const { return timeout_ms_; }

  /// Drops a half-received line or payload. A serial port does so when the line has been silent for 200 ms:
  /// one disturbed length would otherwise swallow every request behind it.
  void forget_input() {
    line_length_ = 0;
    line_overflow_ = false;
    write_ = {};
  }

 private:
  friend class Responder;
  static constexpr std::size_t line_capacity = 128;
  static constexpr std::size_t payload_capacity = 128;

  /// A WRITE whose payload is still arriving, or (device == nullptr) a payload to be swallowed.
  struct Write {
    const Device* device = nullptr;
    const Attribute* attribute = nullptr;
    int error = 0;                ///< answer once the payload is consumed
    std::uint64_t remaining = 0;  ///< payload bytes still to come
    std::size_t length = 0;       ///< payload bytes kept
  };
  struct Reader {
    const Device* device = nullptr;  ///< nullptr: no buffer open
    std::uint32_t mask = 0;
    std::uint64_t cursor = 0;
    std::uint32_t generation = 0;
    std::uint64_t wanted = 0;  ///< bytes still owed to the READBUF in progress
    bool mask_sent = false;
  };

  Status status_ = Status::ready;
  std::int32_t timeout_ms_ = -1;
  std::array<char, line_capacity> line_{};
  std::size_t line_length_ = 0;
  bool line_overflow_ = false;
  Write write_;
  std::array<char, payload_capacity> payload_{};
  Reader reader_;
};

class Responder {
 public:
  explicit Responder(const Context& context) : context_(context) {}

  /// Consumes bytes until all are used or the connection leaves `ready`; returns how many were consumed.
  std::size_t feed(Connection&, std::span<const std::uint8_t> bytes, ByteSink&);

  /// Continues a pending READBUF; status() tells whether it is answered now.
  void resume(Connection&, ByteSink&);

  /// Answers a pending READBUF with -`error` (a polled UART says EAGAIN, a server ETIMEDOUT). EAGAIN behind
  /// the last scan of a complete record becomes 0: there is nothing to poll for.
  void expire(Connection&, Errno error, ByteSink&);

 private:
  void run_line(Connection&, std::string_view line, ByteSink&);
  void print(ByteSink&) const;
  void read(const Words&, ByteSink&);
  void read_all(const Device&, std::span<const Attribute>, ByteSink&);
  void begin_write(Connection&, const Words&, ByteSink&);
  void finish_write(Connection&, ByteSink&);
  int write_all(const Device&, std::span<const Attribute>, std::string_view packed);
  int open(Connection&, const Words&);
  void begin_readbuf(Connection&, const Words&, ByteSink&);
  void trigger(const Words&, ByteSink&);

  const Device* find_device(std::string_view id) const;
  std::span<const Attribute> find_attributes(const Device&, const Words&, std::size_t& next) const;

  const Context& context_;
  const Device* trigger_ = nullptr;
  LongText value_;  ///< of the attribute being read: too long for a small stack
};

}  // namespace powbench::firmware::iiod
