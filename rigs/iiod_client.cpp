#include "rigs/iiod_client.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "firmware/iiod/words.h"
#include "rigs/sim_world.h"

namespace powbench::rigs {

namespace {

constexpr std::size_t unread_limit = 1 << 16;  // bytes a client may send ahead while it is owed samples
constexpr std::size_t answer_limit = 1 << 16;  // answers collected before the client has to take them

/// WRITE DEVICE ATTRIBUTE BYTES of what only the owner may do; a token makes an owner, on whatever connection.
bool is_claim(std::string_view line) {
  const firmware::iiod::Words words(line);
  const std::string_view what = words[2];
  return firmware::iiod::same_word(words[0], "WRITE") && (what == "lease" || what == "arm" || what == "fire");
}

}  // namespace

bool IiodClient::hear(std::span<const std::uint8_t> bytes) {
  unread_.insert(unread_.end(), bytes.begin(), bytes.end());
  return unread_.size() <= unread_limit;
}

std::vector<std::uint8_t> IiodClient::answer() {
  std::size_t at = 0;
  std::vector<std::uint8_t> bytes;
  halfway_ = false;
  while (at < unread_.size() && status_ == Board::Status::ready && bytes.size() < answer_limit) {
    const auto from = unread_.begin() + static_cast<std::ptrdiff_t>(at);
    const auto line_end = std::find(from, unread_.end(), std::uint8_t{'\n'});
    const auto length = static_cast<std::size_t>(line_end - from) + (line_end == unread_.end() ? 0 : 1);
    claims_ = claims_ || is_claim({reinterpret_cast<const char*>(&*from), length});
    const auto answer = world_->board().feed(connection_, std::span(unread_).subspan(at, length));
    at += answer.used;
    status_ = answer.status;
    halfway_ = answer.halfway;
    timeout_ms_ = answer.timeout_ms;
    bytes.insert(bytes.end(), answer.bytes.begin(), answer.bytes.end());
    world_->notice_commands();
  }
  unread_.erase(unread_.begin(), unread_.begin() + static_cast<std::ptrdiff_t>(at));
  return bytes;
}

std::vector<std::uint8_t> IiodClient::resume() {
  return take(world_->board().resume(connection_));
}

std::vector<std::uint8_t> IiodClient::expire() {
  return take(world_->board().expire(connection_));
}

std::vector<std::uint8_t> IiodClient::take(Board::Answer answer) {
  status_ = answer.status;
  return std::move(answer.bytes);
}

void IiodClient::leave() {
  world_->board().close(connection_);
}

}  // namespace powbench::rigs
