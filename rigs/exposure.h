#pragma once

#include <string>

namespace powbench::rigs {

/// Where a rig may be reached from. Whoever reaches it can read everything and stop it; with the secret he can fire it.
struct Exposure {
  bool to_network = false;  ///< asked for in so many words
  std::string secret{};     ///< what every owner's token must begin with, with a dot behind it
};

/// Throws std::invalid_argument, in one sentence, unless `address` is a loopback address, or the network is asked for
/// and there is a secret of 8 to 30 printable characters.
void check_exposure(const std::string& address, const Exposure&);

/// What a token must begin with: the secret and a dot, or nothing.
std::string token_prefix(const Exposure&);

}  // namespace powbench::rigs
