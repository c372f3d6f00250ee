#include "rigs/exposure.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace powbench::rigs {
namespace {

/// Nothing: the text is no address.
std::optional<bool> is_loopback(const std::string& address) {
  in_addr four{};
  in6_addr six{};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24 == 127;
  if (inet_pton(AF_INET6, address.c_str(), &six) == 1) return IN6_IS_ADDR_LOOPBACK(&six);
  return std::nullopt;
}

}  // namespace

void check_exposure(const std::string& address, const Exposure& exposure) {
  const auto inside = is_loopback(address);
  if (!inside) throw std::invalid_argument("'" + address + "' is no address; give one such as 127.0.0.7");
  if (*inside) return;
  if (!exposure.to_network)
    throw std::invalid_argument(address +
                                " can be reached from the network, and whoever reaches a rig can see and "
                                "stop it; if that is meant, add "
                                "--open-to-network and set POWBENCH_RIG_SECRET, which firing it then takes");
  const bool usable =
      exposure.secret.size() >= 8 && exposure.secret.size() <= 30 &&
      std::all_of(exposure.secret.begin(), exposure.secret.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!usable)
    throw std::invalid_argument(
        "--open-to-network needs a secret of 8 to 30 printable characters in POWBENCH_RIG_SECRET");
}

std::string token_prefix(const Exposure& exposure) {
  return exposure.secret.empty() ? std::string() : exposure.secret + ".";
}

}  // namespace powbench::rigs
