#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rigs/board.h"

namespace powbench::rigs {

class SimWorld;

/// A client as the board knows it, without its socket: bytes heard, answers owed, in order.
class IiodClient {
 public:
  /// `connection`: its number on the board. The world must outlive it.
  IiodClient(SimWorld& world, unsigned connection) : world_(&world), connection_(connection) {}

  /// Keeps bytes for answer(). False: it has sent more ahead than a client may.
  bool hear(std::span<const std::uint8_t> bytes);
  /// Hands what was heard to the board, request by request, until a READBUF waits for samples or so much is answered
  /// that the client has to take it first. What one client is owed at a time stays bounded, and the others get their
  /// turn.
  std::vector<std::uint8_t> answer();
  /// The same of a READBUF that waits: its samples may be there; its time is over.
  std::vector<std::uint8_t> resume();
  std::vector<std::uint8_t> expire();
  void leave();

  unsigned connection() const { return connection_; }
  Board::Status status() const { return status_; }
  bool unanswered() const { return !unread_.empty(); }
  bool halfway() const { return halfway_; }                ///< after answer(), as Board::Answer
  std::int32_t timeout_ms() const { return timeout_ms_; }  ///< as Board::Answer
  bool claims() const {
    return claims_;
  }  ///< it has asked for the lease, or to arm or fire: it may be the owner

 private:
  std::vector<std::uint8_t> take(Board::Answer);

  SimWorld* world_;
  unsigned connection_;
  Board::Status status_ = Board::Status::ready;
  bool halfway_ = false, claims_ = false;
  std::int32_t timeout_ms_ = -1;
  std::vector<std::uint8_t> unread_;
};

}  // namespace powbench::rigs
