#pragma once

#include <string>

/// A serial port belongs to one program, and the board behind it must be stoppable by all: whoever holds the port
/// leaves the address at which its bridge serves in a file of the folder for temporary files, `powbench-port-...`. It
/// counts only if the program that it names holds the lock of the port and is of the user who wrote it: a stop must not
/// be confirmed by another rig.

namespace powbench::rigs {

/// Leaves the address as long as it lives. Where the file cannot be written, nothing is left: a stop then needs the
/// address by hand.
class ServedPort {
 public:
  ServedPort(const std::string& port, const std::string& address);
  ~ServedPort();
  ServedPort(const ServedPort&) = delete;
  ServedPort& operator=(const ServedPort&) = delete;

 private:
  std::string file_;  ///< empty: nothing was left
};

/// Address of the bridge that holds the port, "127.0.0.2"; empty: nobody holds it, or a program without a bridge.
std::string served_at(const std::string& port);

}  // namespace powbench::rigs
