#include "rigs/bridge/served_port.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
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

/// The program that holds the port by its lock, as the system tells it; 0: none, or not told.
long holder_of(const std::string& port) {
  struct stat is {};
  if (stat(port.c_str(), &is) != 0) return 0;
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);  // "1: FLOCK ADVISORY WRITE 1234 00:05:86 0 EOF", device in hexadecimal
    std::string number, kind, how, access;
    long pid = 0;
    unsigned major = 0, minor = 0;
    unsigned long inode = 0;
    char colon = 0;
    words >> number >> kind >> how >> access >> pid >> std::hex >> major >> colon >> minor >> colon >>
        std::dec >> inode;
    if (words && kind == "FLOCK" && makedev(major, minor) == is.st_dev && inode == is.st_ino) return pid;
  }
  return 0;
}

/// The file comes from the user whose program that is: anybody may write into the folder.
bool same_user(const std::string& file, long pid) {
  struct stat left {
  }, process{};
  return lstat(file.c_str(), &left) == 0 && S_ISREG(left.st_mode) &&
         stat(("/proc/" + std::to_string(pid)).c_str(), &process) == 0 && left.st_uid == process.st_uid;
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
  const std::string file = file_of(port);
  const long holder = holder_of(port);
  std::ifstream in(file);
  long pid = 0;
  std::string address;
  const bool told = static_cast<bool>(in >> pid >> address);
  return told && holder > 0 && pid == holder && same_user(file, holder) ? address : std::string();
}

}  // namespace powbench::rigs
