#include "host/config/edit_text.h"

#include <optional>
#include <vector>

namespace powbench::host {
namespace {

std::string_view trimmed(std::string_view s) {
  const auto from = s.find_first_not_of(" \t\r");
  return from == std::string_view::npos ? std::string_view()
                                        : s.substr(from, s.find_last_not_of(" \t\r") - from + 1);
}

/// Where the comment of a line begins, its white space included; the end where there is none.
std::size_t comment_begin(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote == '"' && line[i] == '\\')
      ++i;
    else if (quote != 0)
      quote = line[i] == quote ? '\0' : quote;
    else if (line[i] == '"' || line[i] == '\'')
      quote = line[i];
    else if (line[i] == '#') {
      while (i > 0 && (line[i - 1] == ' ' || line[i - 1] == '\t')) --i;
      return i;
    }
  }
  return line.size();
}

/// Brackets and braces that a line opens and leaves open.
int left_open(std::string_view line) {
  int depth = 0;
  char quote = 0;
  line = line.substr(0, comment_begin(line));
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote == '"' && line[i] == '\\')
      ++i;
    else if (quote != 0)
      quote = line[i] == quote ? '\0' : quote;
    else if (line[i] == '"' || line[i] == '\'')
      quote = line[i];
    else
      depth += line[i] == '[' || line[i] == '{' ? 1 : line[i] == ']' || line[i] == '}' ? -1 : 0;
  }
  return depth;
}

bool is_key_line(std::string_view line, std::string_view key) {
  line = trimmed(line);
  if (!line.starts_with(key)) return false;
  line = trimmed(line.substr(key.size()));
  return line.starts_with('=');
}

std::optional<std::string_view> heading(std::string_view line) {
  line = trimmed(line.substr(0, comment_begin(line)));
  if (line.size() < 3 || line.front() != '[' || line.back() != ']' || line[1] == '[') return std::nullopt;
  return trimmed(line.substr(1, line.size() - 2));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

/// Lines of a section: [first, last); nothing where the section is not there.
struct Span {
  std::size_t first = 0, last = 0;
};
std::optional<Span> span_of(const std::vector<std::string>& lines, std::string_view section) {
  bool inside = section.empty();
  Span span{0, lines.size()};
  int depth = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (const auto name = depth == 0 ? heading(lines[i]) : std::nullopt) {
      if (inside) return Span{span.first, i};
      if (*name == section) inside = true, span.first = i + 1;
    } else {
      depth += left_open(lines[i]);
    }
  }
  return inside ? std::optional<Span>(span) : std::nullopt;
}

}  // namespace

std::string with_value(const std::string& text, std::string_view section, std::string_view key,
                       const std::string& value) {
  std::vector<std::string> lines = lines_of(text);
  auto span = span_of(lines, section);
  if (!span && value.empty()) return text;
  if (!span) {
    if (!lines.empty() && !trimmed(lines.back()).empty()) lines.emplace_back();
    lines.push_back("[" + std::string(section) + "]");
    span = Span{lines.size(), lines.size()};
  }
  const auto at = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  std::string line = std::string(key) + " = " + value;
  std::size_t place = span->last, commented = span->last;
  for (std::size_t i = span->first; i < span->last && place == span->last; ++i) {
    if (is_key_line(lines[i], key)) place = i;
    const std::string_view bare = trimmed(lines[i]);
    if (commented == span->last && bare.starts_with('#') && is_key_line(bare.substr(1), key)) commented = i;
  }
  if (place < span->last) {
    std::size_t end = place;
    for (int depth = left_open(lines[place]); depth > 0 && end + 1 < span->last;)
      depth += left_open(lines[++end]);
    line += lines[end].substr(comment_begin(lines[end]));
    lines.erase(lines.begin() + at(place), lines.begin() + at(end + 1));
    if (!value.empty()) lines.insert(lines.begin() + at(place), line);
  } else if (value.empty()) {
    return text;
  } else if (commented < span->last) {
    lines[commented] = line;
  } else {
    // behind the last line of the section that holds a value: comments behind it belong to the next heading
    std::size_t behind = span->last;
    while (behind > span->first && trimmed(lines[behind - 1]).empty()) --behind;
    std::size_t said = behind;
    while (said > span->first &&
           (trimmed(lines[said - 1]).empty() || trimmed(lines[said - 1]).starts_with('#')))
      --said;
    if (said > span->first) behind = said;
    lines.insert(lines.begin() + at(behind), line);
  }
  std::string out;
  for (const std::string& l : lines) out += l + "\n";
  return out;
}

std::string by_hand_plan(const std::string& plan_text) {
  return with_value(plan_text, "", "order", "\"by_hand\"");
}

}  // namespace powbench::host
