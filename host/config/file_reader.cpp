#include "host/config/file_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

namespace powbench::host {

std::string full_key(std::string_view section, std::string_view key) {
  return section.empty() ? std::string(key) : std::string(section) + "." + std::string(key);
}

FileReader FileReader::open(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw BadInput({name + ": is a directory, not a file"});
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw BadInput({name + ": cannot be read: " + std::strerror(errno != 0 ? errno : ENOENT)});
  return {name, std::string(std::istreambuf_iterator<char>(in), {})};
}

void FileReader::add(int line, const std::string& text) {
  mistakes_.push_back({line, file_ + ":" + std::to_string(line) + ": " + text});
}

void FileReader::add(std::string_view section, std::string_view key, const Place& place,
                     const std::string& what, const std::string& allowed) {
  std::string text;
  if (!section.empty()) text.append("[").append(section).append("] ");
  text += key;
  if (!place.value.empty()) text += " = " + place.value;
  text += ": " + what;
  if (!allowed.empty()) text += "; allowed " + allowed;
  add(place.line, text);
}

void FileReader::fail(std::string_view section, std::string_view key, const std::string& what,
                      const std::string& allowed) {
  auto it = places_.find(full_key(section, key));
  if (it == places_.end()) {  // not in the file: name the section's line
    const auto head = places_.find(full_key(section, ""));
    const int line = section.empty() || head == places_.end() ? 1 : head->second.line;
    it = places_.emplace(full_key(section, key), Place{line, "", false}).first;
  }
  it->second.bad = true;
  add(section, key, it->second, what, allowed);
}

bool FileReader::good(std::string_view section, std::string_view key) const {
  const auto it = places_.find(full_key(section, key));
  return it != places_.end() && !it->second.bad;
}

bool FileReader::bad(std::string_view section, std::string_view key) const {
  const auto it = places_.find(full_key(section, key));
  return it != places_.end() && it->second.bad;
}

void FileReader::finish() const {
  if (mistakes_.empty()) return;
  auto sorted = mistakes_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });
  std::vector<std::string> lines;
  for (auto& m : sorted) lines.push_back(std::move(m.text));
  throw BadInput(std::move(lines));
}

}  // namespace powbench::host
