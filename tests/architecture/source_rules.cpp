#include "tests/architecture/source_rules.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "tests/architecture/rules.h"

namespace powbench::architecture {
namespace {

std::string at(const Source& s, int line) {
  return s.path + ":" + std::to_string(line) + ": ";
}

std::string folder_of(const std::string& path) {
  const auto slash = path.find('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

const Folder* find_folder(const std::string& name) {
  for (const auto& f : folders())
    if (f.name == name) return &f;
  return nullptr;
}

bool contains(const std::vector<std::string_view>& list, std::string_view item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

/// The text with comments blanked and line breaks kept, so that line numbers stay true.
std::string without_comments(const std::string& text) {
  std::string out = text;
  enum { code, line_comment, block_comment, literal } state = code;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool pair = i + 1 < out.size();
    if (state == code && pair && out[i] == '/' && (out[i + 1] == '/' || out[i + 1] == '*')) {
      state = out[i + 1] == '/' ? line_comment : block_comment;
      out[i] = ' ';
      out[++i] = ' ';
    } else if (state == code && out[i] == '"') {
      state = literal;
    } else if (state == literal && out[i] == '\\') {
      ++i;
    } else if ((state == literal && (out[i] == '"' || out[i] == '\n')) ||
               (state == line_comment && out[i] == '\n')) {
      state = code;
    } else if (state == block_comment && pair && out[i] == '*' && out[i + 1] == '/') {
      state = code;
      out[i] = ' ';
      out[++i] = ' ';
    } else if ((state == line_comment || state == block_comment) && out[i] != '\n') {
      out[i] = ' ';
    }
  }
  return out;
}

/// Standard C++ headers have neither a dot nor a slash.
bool is_standard(const std::string& header) {
  return header.find_first_of("./") == std::string::npos;
}

/// Headers of the operating system: fine where files and sockets live.
bool is_system(const std::string& header) {
  static const std::vector<std::string_view> list{"unistd.h", "fcntl.h", "signal.h", "poll.h", "termios.h",
                                                  "time.h",   "netdb.h", "spawn.h",  "sched.h"};
  return contains(list, header) || header.starts_with("sys/") || header.starts_with("netinet/") ||
         header.starts_with("arpa/");
}

bool allowed_third_party(const std::string& header, const std::string& path) {
  return std::any_of(allowances().begin(), allowances().end(), [&](const Allowance& a) {
    return header.starts_with(a.header) && path.starts_with(a.where) &&
           (!a.sources_only || path.ends_with(".cpp"));
  });
}

using Graph = std::map<std::string, std::set<std::string>>;

/// A closed walk `a -> b -> a` in the graph, or nothing.
std::string find_cycle(const Graph& graph) {
  std::map<std::string, int> colour;  // 0 new, 1 on the walk, 2 done
  std::vector<std::string> walk;
  std::string found;
  const std::function<bool(const std::string&)> visit = [&](const std::string& node) {
    colour[node] = 1;
    walk.push_back(node);
    const auto edges = graph.find(node);
    if (edges != graph.end())
      for (const auto& next : edges->second) {
        if (colour[next] == 2) continue;
        if (colour[next] == 0) {
          if (visit(next)) return true;
          continue;
        }
        for (auto it = std::find(walk.begin(), walk.end(), next); it != walk.end(); ++it)
          found += *it + " -> ";
        found += next;
        return true;
      }
    walk.pop_back();
    colour[node] = 2;
    return false;
  };
  for (const auto& entry : graph)
    if (colour[entry.first] == 0 && visit(entry.first)) break;
  return found;
}

/// Words that promise work instead of doing it, spelt in halves so that this file passes its own check.
const std::vector<std::string>& forbidden_words() {
  static const std::vector<std::string> words{std::string("to") + "do", std::string("fix") + "me",
                                              std::string("place") + "holder", std::string("dum") + "my",
                                              std::string("xx") + "x"};
  return words;
}

/// Paths that exist on one machine only.
const std::vector<std::string>& forbidden_paths() {
  static const std::vector<std::string> paths{std::string("/ho") + "me/", std::string("/wo") + "rk/",
                                              std::string("/ro") + "ot/"};
  return paths;
}

bool word_in(const std::string& line, const std::string& word) {
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (auto i = line.find(word); i != std::string::npos; i = line.find(word, i + 1)) {
    const bool starts = i == 0 || !is_word(line[i - 1]);
    const bool ends = i + word.size() == line.size() || !is_word(line[i + word.size()]);
    if (starts && ends) return true;
  }
  return false;
}

}  // namespace

std::vector<Include> includes(const Source& source) {
  std::vector<Include> found;
  std::istringstream lines(without_comments(source.text));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    auto i = line.find_first_not_of(" \t");
    if (i == std::string::npos || line[i] != '#') continue;
    i = line.find_first_not_of(" \t", i + 1);
    if (i == std::string::npos || line.compare(i, 7, "include") != 0) continue;
    i = line.find_first_of("<\"", i + 7);
    if (i == std::string::npos) continue;
    const bool angled = line[i] == '<';
    const auto end = line.find(angled ? '>' : '"', i + 1);
    if (end != std::string::npos) found.push_back({number, angled, line.substr(i + 1, end - i - 1)});
  }
  return found;
}

std::vector<std::string> check_arrows(const std::vector<Source>& sources) {
  std::vector<std::string> wrong;
  std::set<std::string> known;
  for (const auto& s : sources) known.insert(s.path);
  for (const auto& s : sources) {
    const Folder* from = find_folder(folder_of(s.path));
    if (from == nullptr) {
      wrong.push_back(at(s, 1) + "this folder is not in the table of folders");
      continue;
    }
    for (const auto& include : includes(s)) {
      if (include.angled) continue;
      const std::string to = folder_of(include.target);
      if (find_folder(to) == nullptr || include.target.find("../") != std::string::npos)
        wrong.push_back(at(s, include.line) + "\"" + include.target +
                        "\" is not written from the top of the project");
      else if (!known.contains(include.target) && !contains(generated_headers(), include.target))
        wrong.push_back(at(s, include.line) + "\"" + include.target + "\" does not exist");
      else if (to != from->name && !contains(from->may_include, to))
        wrong.push_back(at(s, include.line) + std::string(from->name) + " may not include " + to + " (\"" +
                        include.target + "\")");
    }
  }
  return wrong;
}

std::vector<std::string> check_third_party(const std::vector<Source>& sources) {
  std::vector<std::string> wrong;
  for (const auto& s : sources) {
    const Folder* from = find_folder(folder_of(s.path));
    if (from == nullptr || from->third_party) continue;
    for (const auto& include : includes(s)) {
      if (!include.angled) continue;
      const auto& header = include.target;
      if (is_standard(header)
              ? from->pure && contains(file_headers(), header) && !allowed_third_party(header, s.path)
          : is_system(header) ? from->pure
                              : !allowed_third_party(header, s.path))
        wrong.push_back(at(s, include.line) + "<" + header + "> has no place here");
    }
  }
  return wrong;
}

std::vector<std::string> check_firmware_reach(const std::vector<Source>& sources) {
  std::map<std::string, const Source*> by_path;
  for (const auto& s : sources) by_path[s.path] = &s;
  std::set<std::string> reached;
  std::vector<const Source*> open;
  for (const auto& s : sources)
    if (s.path.starts_with(portable_firmware) && !s.path.starts_with(firmware_ports)) {
      reached.insert(s.path);
      open.push_back(&s);
    }
  std::vector<std::string> wrong;
  while (!open.empty()) {
    const Source& s = *open.back();
    open.pop_back();
    for (const auto& include : includes(s)) {
      if (include.angled && contains(hosted_headers(), include.target))
        wrong.push_back(at(s, include.line) + "the microcontroller would reach <" + include.target + ">");
      const auto next = by_path.find(include.target);
      if (!include.angled && next != by_path.end() && reached.insert(include.target).second)
        open.push_back(next->second);
    }
  }
  return wrong;
}

std::vector<std::string> check_cycles(const std::vector<Source>& sources) {
  Graph files, between_folders;
  for (const auto& s : sources)
    for (const auto& include : includes(s)) {
      if (include.angled) continue;
      files[s.path].insert(include.target);
      if (folder_of(s.path) != folder_of(include.target))
        between_folders[folder_of(s.path)].insert(folder_of(include.target));
    }
  std::vector<std::string> wrong;
  for (const auto* graph : {&between_folders, &files})
    if (const auto cycle = find_cycle(*graph); !cycle.empty()) wrong.push_back("cycle: " + cycle);
  return wrong;
}

std::vector<std::string> check_order(const std::vector<Source>& sources,
                                     const std::vector<std::string_view>& order) {
  const auto place = [&](const std::string& path) {
    return std::find(order.begin(), order.end(), path.substr(0, path.rfind('/'))) - order.begin();
  };
  const auto outside = static_cast<std::ptrdiff_t>(order.size());
  std::vector<std::string> wrong;
  for (const auto& s : sources)
    for (const auto& include : includes(s)) {
      const auto later = place(include.target);
      if (place(s.path) < later && later < outside)
        wrong.push_back(at(s, include.line) + std::string(order[static_cast<std::size_t>(later)]) +
                        " comes later");
    }
  return wrong;
}

std::vector<std::string> check_text(const std::vector<Source>& sources) {
  std::vector<std::string> wrong;
  for (const auto& s : sources) {
    std::istringstream lines(s.text);
    std::string line;
    int number = 0;
    bool once = false;
    while (std::getline(lines, line)) {
      ++number;
      once = once || line.starts_with("#pragma once");
      const auto width =
          std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });  // UTF-8
      if (width > widest_line && !s.path.ends_with(".md"))
        wrong.push_back(at(s, number) + "wider than " + std::to_string(widest_line) + " characters");
      for (const auto& path : forbidden_paths())
        if (line.find(path) != std::string::npos)
          wrong.push_back(at(s, number) + "names a path of one machine");
      std::transform(line.begin(), line.end(), line.begin(),
                     [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
      for (const auto& word : forbidden_words())
        if (word_in(line, word)) wrong.push_back(at(s, number) + "contains the word '" + word + "'");
    }
    if (number > longest_file)
      wrong.push_back(at(s, number) + "longer than " + std::to_string(longest_file) + " lines");
    if (s.path.ends_with(".h") && !once) wrong.push_back(at(s, 1) + "header without #pragma once");
  }
  return wrong;
}

std::vector<std::string> check_waiting(const std::vector<Source>& sources) {
  std::vector<std::string> wrong;
  for (const auto& s : sources) {
    if (!s.path.starts_with("tests/") || s.path.starts_with("tests/architecture/") ||
        s.path == waiting_helper)
      continue;
    std::istringstream lines(s.text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number)
      for (const auto& word : clock_words())
        if (line.find(word) != std::string::npos)
          wrong.push_back(at(s, number) + "uses '" + std::string(word) + "'; wait for what is meant with " +
                          std::string(waiting_helper));
  }
  return wrong;
}

}  // namespace powbench::architecture
