#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace powbench::host {

/// A zip file: deflated files, then their directory. No time is kept, so that equal content makes equal bytes.
class Zip {
 public:
  void add(const std::string& name, std::string_view text);
  std::string finish() const;

 private:
  std::string bytes_, directory_;
  std::uint32_t files_ = 0;
};

}  // namespace powbench::host
