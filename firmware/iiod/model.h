#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/text.h"

/// What an IIO context offers, as constant tables: devices, channels, attributes. The responder serves any
/// such table.

namespace powbench::firmware::iiod {

/// Linux error numbers: the protocol uses them on every platform.
enum Errno : int {
  eperm = 1,
  eio = 5,
  e2big = 7,
  ebadf = 9,
  eagain = 11,
  ebusy = 16,
  enodev = 19,
  einval = 22,
  erange = 34,
  eoverflow = 75,
  etimedout = 110,
  enoent = 2,
};

/// A named text value. `read` fills the text and returns 0 or -errno; `write` (nullptr: read-only) returns 0
/// or -errno. Names use [A-Za-z0-9_.-] only and stand in alphabetical order; a value is never empty.
struct Attribute {
  std::string_view name;
  int (*read)(const void* self, std::uint32_t argument, Text& out);
  int (*write)(void* self, std::uint32_t argument, std::string_view value) = nullptr;
  std::uint32_t argument =
      0;  ///< handed to read and write, so that one function can serve a row of attributes
};

struct Channel {
  std::string_view id;  ///< "voltage0", "timestamp" ...
  bool output = false;
  int scan_index = -1;                      ///< position in the buffer, -1: not buffered
  int bits = 16;                            ///< 16: le:S16/16>>0, 64: le:S64/64>>0
  std::span<const Attribute> attributes{};  ///< in alphabetical order
};

/// Where buffered samples come from.
class BufferSource {
 public:
  /// Scans that can be copied now, from `cursor` on; 0: none yet.
  virtual std::size_t available(std::uint64_t cursor) const = 0;
  /// The record is complete and `cursor` stands behind its last scan.
  virtual bool finished(std::uint64_t cursor) const = 0;
  /// Bytes of one scan with the channels of `mask`.
  virtual std::size_t scan_bytes(std::uint32_t mask) const = 0;
  /// Copies `scans` scans from `cursor` on to `out` (scans * scan_bytes(mask) bytes).
  virtual void copy(std::uint64_t cursor, std::size_t scans, std::uint32_t mask, std::uint8_t* out) const = 0;
  /// The next scans as they lie in memory, ready for the wire: at most `scans` of them, and only as many as lie in one
  /// piece; empty: copy() has to make them. They stay there until the generation changes.
  virtual std::span<const std::uint8_t> in_place(std::uint64_t cursor, std::size_t scans,
                                                 std::uint32_t mask) const = 0;
  /// Changes with every new record: a reader opened on an older one gets -EBADF.
  virtual std::uint32_t generation() const = 0;

 protected:
  ~BufferSource() = default;
};

struct Device {
  std::string_view id;  ///< "iio:deviceN" or "triggerN"
  std::string_view name;
  std::string_view label;  ///< empty: none
  std::span<const Channel> channels{};
  std::span<const Attribute> attributes{};
  std::span<const Attribute> buffer_attributes{};
  void* self = nullptr;  ///< handed to the attribute functions
  const BufferSource* buffer = nullptr;
  bool has_trigger = false;  ///< accepts SETTRIG

  bool is_trigger() const { return id.starts_with("trigger"); }
};

struct ContextAttribute {
  std::string_view name;
  std::string_view value;
};

struct Context {
  std::string_view description;
  std::span<const ContextAttribute> attributes{};
  std::span<const Device* const> devices{};
  /// Locked (true), then unlocked (false) around every attribute function: a port whose controller runs in an
  /// interrupt keeps it out meanwhile. nullptr: not needed.
  void (*lock)(bool held) = nullptr;
};

}  // namespace powbench::firmware::iiod
