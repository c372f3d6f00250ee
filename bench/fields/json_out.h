#pragma once

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

/// The end of every benchmark here: the result into the file of `--json PATH`, if there is one.

namespace powbench::bench {

/// What follows an option on the command line; empty without it.
inline std::string option(int argc, char** argv, const char* name) {
  for (int i = 1; i + 1 < argc; ++i)
    if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
  return {};
}

inline bool flag(int argc, char** argv, const char* name) {
  return std::any_of(argv + 1, argv + argc, [&](const char* a) { return std::strcmp(a, name) == 0; });
}

/// Returns the exit code: 2 where the file cannot be written.
inline int write_json(int argc, char** argv, const nlohmann::ordered_json& result) {
  const std::string path = option(argc, argv, "--json");
  if (path.empty()) return 0;
  std::ofstream out(path);
  out << result.dump(2) << '\n';
  if (out) return 0;
  std::fprintf(stderr, "cannot write %s\n", path.c_str());
  return 2;
}

}  // namespace powbench::bench
