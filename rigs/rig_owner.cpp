#include "rigs/rig_owner.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "firmware/lease.h"

namespace powbench::rigs {

std::string make_token() {
  std::random_device entropy;
  char text[40];
  std::snprintf(text, sizeof text, "%08x%08x", entropy(), entropy());
  const char* secret = std::getenv("POWBENCH_RIG_SECRET");
  return (secret && *secret != '\0' ? std::string(secret) + "." : std::string()) + text;
}

std::string make_name() {
  char host[64] = "host";
  if (gethostname(host, sizeof host - 1) != 0) host[0] = 0;
  std::string name = "powbench-" + std::to_string(getpid()) + "@" + host;
  return name.substr(0, firmware::Lease::longest_owner);
}

}  // namespace powbench::rigs
