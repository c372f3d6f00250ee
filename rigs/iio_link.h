#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/channels.h"
#include "rigs/rig.h"

/// One libiio context of a bench, and nothing above it. Written against libiio 0.24: a context whose answer came late
/// or damaged is out of step (every later answer would be that of the request before), and nothing on the wire tells.
/// So whoever finds an answer that does not fit throws the link away.

namespace powbench::rigs {

/// The answer is missing, or cannot be that to its request: the link is of no use any more.
struct LinkBroken {
  int error = 0;  ///< errno, or 0
  std::string sentence;
};

/// The rig understood and refused.
struct Refusal {
  int error = 0;  ///< EBUSY, EAGAIN, EPERM or ERANGE
  std::string doing;
};

/// In words, for a person.
std::string sentence(const Refusal&);

class IioLink {
 public:
  enum class Device : std::uint8_t { daq, control, plant };

  /// Throws RigError with one sentence within `limit`: nothing answers, or what answers is no bench.
  IioLink(const std::string& uri, std::chrono::milliseconds limit, std::chrono::milliseconds request);
  ~IioLink();
  IioLink(const IioLink&) = delete;
  IioLink& operator=(const IioLink&) = delete;

  bool has_source() const;
  /// What the rig says about itself. Throws RigError for a number that is none.
  RigInfo read_info(const std::string& uri);

  // each throws LinkBroken, the writing ones Refusal too
  /// What the rig says of the phase of its mains now.
  std::string phase();
  std::string read(Device, const char* attribute);
  /// "" where this rig has no such attribute.
  std::string read_if_there(Device, const char* attribute);
  /// Every attribute that can be read, in the order of the rig: "contactor-daq/voltage0/scale" and its value.
  std::vector<std::pair<std::string, std::string>> read_all();
  void write(Device, const char* attribute, const std::string& value);
  void write_angle(const std::string& value);
  /// An attribute of an input channel.
  std::string read_channel(Channel, const char* attribute);
  /// The bytes of the record, all channels.
  std::vector<std::uint8_t> read_scans(std::size_t samples);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::rigs
