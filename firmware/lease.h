#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// Who may energise the coil: one owner at a time, known by a token that it chose and shows with every command.

namespace powbench::firmware {

class Lease {
 public:
  static constexpr std::int64_t shortest_ms = 100, longest_ms = 3'600'000;
  static constexpr std::size_t longest_token = 48, longest_owner = 40;

  enum class Claim : std::uint8_t { granted, taken, malformed, forbidden };

  /// `samples_per_second`: of the clock that pass() counts.
  explicit Lease(std::int64_t samples_per_second) : rate_(samples_per_second) {}

  /// Grants the lease for `ms` (shortest_ms .. longest_ms; checked by the caller) if it is free or already this
  /// token's. `owner` is the name that others see; it may be empty. Malformed: a token or name that is too long or
  /// not printable; forbidden: a token that does not begin with the secret.
  Claim claim(std::string_view token, std::int64_t ms, std::string_view owner) {
    if (!usable(token, longest_token) || (!owner.empty() && !usable(owner, longest_owner)))
      return Claim::malformed;
    if (!token.starts_with(secret_)) return Claim::forbidden;
    if (held() && !is_owner(token)) return Claim::taken;
    if (!held()) ++number_;
    token_size_ = keep(token, token_);
    if (!owner.empty() || !held()) owner_size_ = keep(owner.empty() ? "unnamed" : owner, owner_);
    term_ = ms * rate_ / 1000;
    renew();
    return Claim::granted;
  }

  bool held() const { return left_ > 0; }
  /// The token of the lease in force.
  bool is_owner(std::string_view token) const { return held() && token == view(token_, token_size_); }
  /// The owner has spoken: the lease starts anew.
  void renew() {
    left_ = term_;
    heard_ = true;
    ++renewed_;
  }
  void give_back() { left_ = 0; }

  /// Lets time pass; true when the lease has ended just now.
  bool pass(std::int64_t samples) {
    if (left_ == 0) return false;
    left_ = left_ > samples ? left_ - samples : 0;
    return left_ == 0;
  }
  /// The owner has spoken since the last call.
  bool take_heard() {
    const bool was = heard_;
    heard_ = false;
    return was;
  }

  std::string_view owner() const { return view(owner_, owner_size_); }
  std::int64_t left_ms() const { return left_ * 1000 / rate_; }
  /// Counts the leases: another one is another owner.
  std::uint32_t number() const { return number_; }
  std::uint32_t times_renewed() const { return renewed_; }
  /// What every token must begin with from now on; the text must outlive the lease.
  void protect(std::string_view secret) { secret_ = secret; }

 private:
  static bool usable(std::string_view s, std::size_t most) {
    if (s.empty() || s.size() > most) return false;
    for (const char c : s)
      if (c <= ' ' || c > '~') return false;
    return true;
  }
  template <std::size_t N>
  static std::size_t keep(std::string_view from, std::array<char, N>& to) {
    for (std::size_t i = 0; i < from.size(); ++i) to[i] = from[i];
    return from.size();
  }
  template <std::size_t N>
  static std::string_view view(const std::array<char, N>& text, std::size_t size) {
    return {text.data(), size};
  }

  std::int64_t rate_, term_ = 0, left_ = 0;  ///< samples
  std::array<char, longest_token> token_{};
  std::array<char, longest_owner> owner_{};
  std::size_t token_size_ = 0, owner_size_ = 0;
  std::string_view secret_{};
  std::uint32_t number_ = 0, renewed_ = 0;
  bool heard_ = false;
};

}  // namespace powbench::firmware
