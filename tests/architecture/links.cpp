#include "tests/architecture/links.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

namespace powbench::architecture {
namespace {

/// The lines of a page; lines inside a code fence are emptied.
std::vector<std::string> prose(const Source& page) {
  std::vector<std::string> lines;
  std::istringstream in(page.text);
  std::string line;
  bool fenced = false;
  while (std::getline(in, line)) {
    const bool fence = line.find_first_not_of(' ') != std::string::npos &&
                       line.compare(line.find_first_not_of(' '), 3, "```") == 0;
    if (fence) fenced = !fenced;
    lines.push_back(fence || fenced ? "" : line);
  }
  return lines;
}

bool is_external(const std::string& target) {
  static const std::regex scheme("^[a-zA-Z][a-zA-Z0-9+.-]*:");
  return std::regex_search(target, scheme);
}

std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto u = static_cast<unsigned char>(c);
    if (c == ' ')
      anchor += '-';
    else if (u >= 0x80 || std::isalnum(u) != 0 || c == '-' || c == '_')
      anchor += static_cast<char>(std::tolower(u));
  }
  return anchor;
}

}  // namespace

std::vector<Link> links(const Source& page) {
  static const std::regex code("`[^`]*`");
  static const std::regex inline_link(R"(\]\(\s*<?([^)\s>]+)>?(\s+"[^"]*")?\s*\))");
  static const std::regex reference(R"(^\s{0,3}\[[^\]]+\]:\s*<?([^\s>]+)>?)");
  static const std::regex html(R"re((?:src|href)="([^"]+)")re");
  std::vector<Link> found;
  int number = 0;
  for (const auto& raw : prose(page)) {
    ++number;
    const auto line = std::regex_replace(raw, code, "");
    for (const auto* pattern : {&inline_link, &reference, &html})
      for (std::sregex_iterator it(line.begin(), line.end(), *pattern), end; it != end; ++it)
        found.push_back({number, (*it)[1].str()});
  }
  return found;
}

std::vector<std::string> anchors(const Source& page) {
  static const std::regex heading(R"(^#{1,6}\s+(.*?)\s*#*\s*$)");
  std::vector<std::string> found;
  std::map<std::string, int> seen;
  for (const auto& line : prose(page)) {
    std::smatch match;
    if (!std::regex_match(line, match, heading)) continue;
    const auto anchor = anchor_of(match[1].str());
    const int before = seen[anchor]++;
    found.push_back(before == 0 ? anchor : anchor + "-" + std::to_string(before));
  }
  return found;
}

std::vector<std::string> check_links(const std::vector<Source>& pages,
                                     const std::function<bool(const std::string&)>& exists) {
  namespace fs = std::filesystem;
  std::map<std::string, const Source*> by_path;
  for (const auto& page : pages) by_path[page.path] = &page;
  std::vector<std::string> wrong;
  for (const auto& page : pages)
    for (const auto& link : links(page)) {
      if (is_external(link.target)) continue;
      const auto where = page.path + ":" + std::to_string(link.line) + ": " + link.target;
      const auto hash = link.target.find('#');
      const auto file = link.target.substr(0, hash);
      auto path = file.empty()
                      ? page.path
                      : (fs::path(page.path).parent_path() / file).lexically_normal().generic_string();
      if (path.ends_with('/')) path.pop_back();
      if (path.starts_with("..") || !exists(path)) {
        wrong.push_back(where + " does not exist");
        continue;
      }
      const auto target = by_path.find(path);
      if (hash == std::string::npos || target == by_path.end()) continue;
      const auto names = anchors(*target->second);
      if (std::find(names.begin(), names.end(), link.target.substr(hash + 1)) == names.end())
        wrong.push_back(where + " names no heading of that page");
    }
  return wrong;
}

}  // namespace powbench::architecture
