#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/architecture/source_rules.h"
#include "tests/places.h"

/// Reads the project's own files for the checks.

namespace powbench::architecture {

inline std::filesystem::path project_root() {
  return test::source_dir();
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(in), {}};
}

/// All files below the top of the project with one of these endings, sorted by path. Hidden folders and what
/// a build or a run leaves behind (build, out) are skipped.
inline std::vector<Source> read_tree(const std::vector<std::string>& endings) {
  namespace fs = std::filesystem;
  std::vector<Source> files;
  for (auto it = fs::recursive_directory_iterator(project_root()); it != fs::recursive_directory_iterator();
       ++it) {
    const auto name = it->path().filename().string();
    if (it->is_directory()) {
      const bool generated = it.depth() == 0 && (name.starts_with("build") || name == "out");
      if (name.starts_with(".") || generated) it.disable_recursion_pending();
    } else if (std::find(endings.begin(), endings.end(), it->path().extension()) != endings.end()) {
      files.push_back({fs::relative(it->path(), project_root()).generic_string(), read_text(it->path())});
    }
  }
  std::sort(files.begin(), files.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
  return files;
}

/// One violation a line, for a readable failure message.
inline std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const auto& line : lines) all += line + "\n";
  return all;
}

}  // namespace powbench::architecture
