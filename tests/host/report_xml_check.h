#pragma once

#include <string>
#include <string_view>
#include <vector>

/// A small check that text is well-formed XML as far as elements, attributes and entities go: enough to catch broken
/// nesting and missing escapes, independent of the writer under test.

namespace powbench::host::test {

inline bool is_name_char(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
         c == ':';
}

/// Position after a name at `i`, or npos.
inline std::size_t skip_name(std::string_view s, std::size_t i) {
  const std::size_t begin = i;
  while (i < s.size() && is_name_char(s[i])) ++i;
  return i > begin ? i : std::string_view::npos;
}

/// An entity of the five known ones at `i`.
inline bool known_entity(std::string_view s, std::size_t i) {
  for (const std::string_view e : {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"})
    if (s.substr(i).starts_with(e)) return true;
  return false;
}

/// Attributes from `i` up to > or />. Returns the position of that end, or npos with `error` set.
inline std::size_t skip_attributes(std::string_view s, std::size_t i, std::string& error) {
  while (i < s.size() && s[i] == ' ') {
    i = skip_name(s, i + 1);
    if (i == std::string_view::npos || s.substr(i, 2) != "=\"") {
      error = "attribute without name or value";
      return std::string_view::npos;
    }
    for (i += 2; i < s.size() && s[i] != '"'; ++i)
      if (s[i] == '<' || (s[i] == '&' && !known_entity(s, i))) {
        error = "raw < or & in an attribute";
        return std::string_view::npos;
      }
    ++i;
  }
  return i;
}

/// Empty when well-formed, else what is wrong and where.
inline std::string xml_error(std::string_view s) {
  std::vector<std::string> open;
  std::string error;
  const auto at = [&](std::size_t i, const std::string& what) {
    return what + " at byte " + std::to_string(i);
  };
  for (std::size_t i = 0; i < s.size();) {
    if (s[i] == '&' && !known_entity(s, i)) return at(i, "raw &");
    if (s[i] == '>') return at(i, "raw >");
    if (s[i] != '<') {
      ++i;
      continue;
    }
    if (s.substr(i).starts_with("<!DOCTYPE") || s.substr(i).starts_with("<?xml")) {
      i = s.find('>', i) + 1;
      continue;
    }
    const bool closing = s.substr(i, 2) == "</";
    const std::size_t begin = i + (closing ? 2 : 1), end = skip_name(s, begin);
    if (end == std::string_view::npos) return at(i, "raw <");
    const std::string tag(s.substr(begin, end - begin));
    const std::size_t stop = closing ? end : skip_attributes(s, end, error);
    if (!error.empty()) return at(i, error);
    const bool empty = s.substr(stop, 2) == "/>";
    if (!empty && s.substr(stop, 1) != ">") return at(i, "tag not closed");
    if (closing) {
      if (open.empty() || open.back() != tag) return at(i, "</" + tag + "> closes nothing");
      open.pop_back();
    } else if (!empty) {
      open.push_back(tag);
    }
    i = stop + (empty ? 2 : 1);
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

/// The page without its scripts: those that are part of it, data of the closer look and code as data: URLs. Any other
/// stays.
inline std::string without_own_scripts(std::string html) {
  for (const std::string own :
       {"<script src=\"data:text/javascript;base64,", "<script type=\"application/json\" id=\"closings\">",
        "<script type=\"application/json\" id=\"device\">"})
    for (auto i = html.find(own); i != std::string::npos; i = html.find(own))
      html.erase(i, html.find("</script>", i) + 9 - i);
  return html;
}

}  // namespace powbench::host::test
