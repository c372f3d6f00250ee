#include "rigs/bridge/served_port.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace powbench::rigs {
namespace {

/// /dev/serial/by-id/... and /dev/ttyACM0 are one port.
std::string file_of(const std::string& port) {
  std::error_code ignored;
  std::string name = std::filesystem::weakly_canonical(port, ignored).string();
  if (name.empty()) name = port;
  for (char& c : name)
    if (c == '/') c = '-';
  return (std::filesystem::temp_directory_path(ignored) / ("powbench-port" + name)).string();
}

bool is_held(const std::string& port) {
  const int fd = open(port.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return false;
  const bool held = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(fd);
  return held;
}

}  // namespace

ServedPort::ServedPort(const std::string& port, const std::string& address) {
  const std::string file = file_of(port), text = std::to_string(getpid()) + " " + address + "\n";
  unlink(file.c_str());  // of a program that was killed: we hold the port
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (fd < 0) return;
  if (write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size())) file_ = file;
  close(fd);
}

ServedPort::~ServedPort() {
  if (!file_.empty()) unlink(file_.c_str());
}

std::string served_at(const std::string& port) {
  std::ifstream in(file_of(port));
  long pid = 0;
  std::string address;
  if (!(in >> pid >> address) || pid <= 0) return {};
  const bool lives = kill(static_cast<pid_t>(pid), 0) == 0 || errno == EPERM;
  return lives && is_held(port) ? address : std::string();
}

}  // namespace powbench::rigs
