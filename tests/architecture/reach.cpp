#include "tests/architecture/reach.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "tests/architecture/rules.h"

namespace powbench::architecture {
namespace {

bool word_char(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// Where literals and comments end; `i` is at their beginning.
std::size_t end_of(const std::string& t, std::size_t i, bool& keep_quotes) {
  keep_quotes = false;
  if (t.compare(i, 2, "//") == 0) return std::min(t.find('\n', i), t.size());
  if (t.compare(i, 2, "/*") == 0) {
    const auto end = t.find("*/", i);
    return end == std::string::npos ? t.size() : end + 2;
  }
  keep_quotes = true;
  if (t[i] == '"' && i > 0 && t[i - 1] == 'R') {
    const auto open = t.find('(', i);
    if (open == std::string::npos) return t.size();
    const auto close = t.find(")" + t.substr(i + 1, open - i - 1) + "\"", open);
    return close == std::string::npos ? t.size() : close + open - i + 1;
  }
  std::size_t j = i + 1;
  while (j < t.size() && t[j] != t[i] && t[j] != '\n') j += t[j] == '\\' ? 2 : 1;
  return std::min(j + 1, t.size());
}

struct Word {
  std::string name;
  int line = 0;
  bool declares = false;  ///< the name of a function that is declared or defined here
};

/// Without the arguments of templates: `f<int(double)> g` becomes `f g`.
std::string without_arguments(const std::string& line) {
  std::string out;
  int depth = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool arrow = line[i] == '>' && i > 0 && line[i - 1] == '-';
    if (line[i] == '<')
      ++depth;
    else if (line[i] == '>' && depth > 0 && !arrow)
      --depth;
    else if (depth == 0)
      out += line[i];
  }
  return out;
}

/// True when `before` (the line up to a name that a parenthesis follows) makes it a declaration: a type stands there.
/// Sources are formatted: what stands at the beginning of a line of a .cpp is no call.
bool declaration(const std::string& line, bool header) {
  const auto before = without_arguments(line);
  static const std::set<std::string> verbs{"return", "case", "else", "throw",     "and",     "or",
                                           "not",    "new",  "do",   "co_return", "co_await"};
  if (before.find_first_of("=(") != std::string::npos) return false;
  if (!header) return before.empty() || std::isspace(static_cast<unsigned char>(before[0])) == 0;
  std::istringstream parts(before);
  std::string part, last;
  while (parts >> part) last = part;
  if (last.empty() || verbs.contains(last)) return false;
  const char c = before.back();
  return c == '&' || c == '*' ||
         (c == ' ' &&
          (word_char(last.back()) || last.back() == '>' || last.back() == '&' || last.back() == '*'));
}

std::vector<Word> words(const Source& s) {
  const bool header = s.path.ends_with(".h");
  std::vector<Word> found;
  std::istringstream in(code_of(s.text));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.starts_with("#") && line.find("define") == std::string::npos) continue;
    for (std::size_t i = 0; i < line.size();) {
      if (!word_char(line[i])) {
        ++i;
        continue;
      }
      const std::size_t first = i;
      while (i < line.size() && word_char(line[i])) ++i;
      const auto next = line.find_first_not_of(' ', i);
      const bool call = next != std::string::npos && line[next] == '(';
      found.push_back(
          {line.substr(first, i - first), number, call && declaration(line.substr(0, first), header)});
    }
  }
  return found;
}

std::string folder(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

/// What a source defines at the beginning of a line: `int f(` gives f, `int C::f(` gives C; a macro that makes
/// functions gives all its words.
std::set<std::string> defined(const Source& s) {
  std::set<std::string> names;
  std::istringstream in(code_of(s.text));
  std::string line;
  while (std::getline(in, line)) {
    line = without_arguments(line);
    const auto open = line.find('(');
    if (line.empty() || !word_char(line[0]) || open == std::string::npos) continue;
    const auto start_of = [&](std::size_t end) {
      while (end > 0 && word_char(line[end - 1])) --end;
      return end;
    };
    auto end = open, start = start_of(end);
    while (start >= 2 && line.compare(start - 2, 2, "::") == 0) end = start - 2, start = start_of(end);
    names.insert(line.substr(start, end - start));
    if (line.starts_with("POWBENCH_"))
      names.insert(line.substr(open + 1, line.find_first_of(",)") - open - 1));
  }
  return names;
}

std::set<std::string> declared(const Source& header) {
  std::set<std::string> names;
  std::string before;
  for (const auto& word : words(header)) {
    if (word.declares || before == "class" || before == "struct") names.insert(word.name);
    before = word.name;
  }
  return names;
}

}  // namespace

std::string code_of(const std::string& text) {
  std::string out = text;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool separator = out[i] == '\'' && i > 0 && word_char(out[i - 1]);  // 1'000
    const bool comment = out[i] == '/' && i + 1 < out.size() && (out[i + 1] == '/' || out[i + 1] == '*');
    if (separator || (!comment && out[i] != '"' && out[i] != '\'')) continue;
    bool quotes = false;
    const auto end = end_of(text, i, quotes);
    for (std::size_t j = i + (quotes ? 1 : 0); j + (quotes ? 1 : 0) < end; ++j)
      if (out[j] != '\n') out[j] = ' ';
    i = end - 1;
  }
  return out;
}

bool in_product(std::string_view path) {
  for (const auto top : {"core/", "dsp/", "firmware/", "sim/", "fmu/", "rigs/", "host/", "python/"})
    if (path.starts_with(top)) return true;
  return false;
}

std::vector<Unreached> files_not_reached(const std::vector<Source>& sources) {
  std::map<std::string, const Source*> files;
  std::map<std::string, std::set<std::string>> definitions;
  std::vector<std::string> open;
  for (const auto& s : sources) {
    if (!in_product(s.path)) continue;
    files[s.path] = &s;
    if (s.path.ends_with(".cpp")) definitions[s.path] = defined(s);
    const bool module = s.path.starts_with("firmware/port/") || s.path.starts_with("python/") ||
                        s.path.starts_with("fmu/fmi");  // called by simulators
    const bool program = module || code_of(s.text).find("\nint main(") != std::string::npos;
    if (program) open.push_back(s.path);
  }
  std::set<std::string> reached;
  while (!open.empty()) {
    const auto path = open.back();
    open.pop_back();
    if (!files.contains(path) || !reached.insert(path).second) continue;
    const Source& s = *files[path];
    for (const auto& include : includes(s)) open.push_back(include.target);
    if (!path.ends_with(".h")) continue;
    const auto names = declared(s);
    for (const auto& [source, made] : definitions)
      if (folder(source) == folder(path) &&
          std::any_of(made.begin(), made.end(), [&](const auto& name) { return names.contains(name); }))
        open.push_back(source);
  }
  std::vector<Unreached> found;
  for (const auto& [path, s] : files)
    if (!reached.contains(path)) found.push_back({path, path});
  return found;
}

std::vector<Unreached> functions_not_reached(const std::vector<Source>& sources) {
  std::set<std::string> used;
  std::map<std::string, std::string> first;
  for (const auto& s : sources) {
    if (!in_product(s.path)) continue;
    for (const auto& word : words(s))
      if (!word.declares)
        used.insert(word.name);
      else if (s.path.ends_with(".h"))
        first.emplace(word.name, s.path + ":" + std::to_string(word.line));
  }
  std::vector<Unreached> found;
  for (const auto& [name, where] : first)
    if (!used.contains(name)) found.push_back({name, where});
  return found;
}

std::vector<std::string> check_said_once(const std::vector<Source>& sources) {
  std::vector<std::string> wrong;
  for (const auto& s : sources) {
    if (!in_product(s.path)) continue;
    const auto code = code_of(s.text);
    for (const auto& rule : said_once())
      if (s.path != rule.where && code.find(rule.text) != std::string::npos)
        wrong.push_back(s.path + ": '" + std::string(rule.text) + "' is said in " + std::string(rule.where));
  }
  return wrong;
}

std::vector<std::string> check_reached(const std::vector<Unreached>& found,
                                       const std::vector<std::string_view>& known,
                                       const std::vector<std::string_view>& outside) {
  std::set<std::string> names;
  std::vector<std::string> wrong;
  for (const auto& f : found) {
    names.insert(f.name);
    const auto in = [&](const auto& list) {
      return std::find(list.begin(), list.end(), f.name) != list.end();
    };
    if (!in(known) && !in(outside)) wrong.push_back(f.where + ": " + f.name + " is reached from no program");
  }
  for (const auto& name : known)
    if (!names.contains(std::string(name)))
      wrong.push_back(std::string(name) +
                      " is reached, or gone: take it off the list in tests/architecture/rules.h");
  return wrong;
}

}  // namespace powbench::architecture
