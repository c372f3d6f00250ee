#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "host/store/store.h"

namespace powbench::host {

/// Writes a picture, its folder too. Throws StoreError where that cannot be.
inline void write_picture(const std::filesystem::path& file, const std::string& text) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw StoreError(file.string() + ": cannot be written; choose another folder");
}

}  // namespace powbench::host
