#include "rigs/boot_id.h"

#include <atomic>
#include <cstdio>

#include "core/random.h"

namespace powbench::rigs {

std::string next_boot_id(const std::string& serial, std::uint64_t seed) {
  static std::atomic<std::uint64_t> starts{0};
  std::uint64_t state = seed;
  for (const char c : serial) state = splitmix64(state) ^ static_cast<unsigned char>(c);
  state = splitmix64(state) + ++starts;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(splitmix64(state)));
  return text;
}

}  // namespace powbench::rigs
