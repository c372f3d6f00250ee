#include "sim/magnetics/plane/msh_scanner.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace powbench::sim {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/// What was found, short enough for a sentence.
std::string shown(std::string_view word) {
  if (word.empty()) return "the end of the file";
  std::string text;
  for (const char c : word.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
  return "'" + text + "'";
}

}  // namespace

void MshScanner::fail(const std::string& text) const {
  throw std::invalid_argument((binary_ ? "byte " + std::to_string(at_) : "line " + std::to_string(line_)) +
                              ": " + text);
}

void MshScanner::skip_space() {
  while (at_ < content_.size() && is_space(content_[at_])) line_ += content_[at_++] == '\n';
}

bool MshScanner::at_end() {
  skip_space();
  return at_ == content_.size();
}

std::string_view MshScanner::word() {
  skip_space();
  const std::size_t begin = at_;
  while (at_ < content_.size() && !is_space(content_[at_])) ++at_;
  return content_.substr(begin, at_ - begin);
}

std::string_view MshScanner::line() {
  const std::size_t begin = at_;
  const std::size_t end = std::min(content_.find('\n', at_), content_.size());
  at_ = std::min(end + 1, content_.size());
  if (end < content_.size()) ++line_;
  return content_.substr(begin, end - begin);
}

std::string_view MshScanner::quoted() {
  skip_space();
  const std::size_t end_of_line = std::min(content_.find('\n', at_), content_.size());
  const std::string_view rest = content_.substr(at_, end_of_line - at_);
  const std::size_t close = rest.find('"', 1);
  if (rest.empty() || rest[0] != '"' || close == std::string_view::npos)
    fail("a name between quotation marks expected, found " + shown(rest));
  at_ += close + 1;
  return rest.substr(1, close - 1);
}

void MshScanner::expect(std::string_view wanted) {
  const auto found = word();
  if (found != wanted) fail(std::string(wanted) + " expected, found " + shown(found));
}

void MshScanner::skip_past(std::string_view wanted) {
  const std::size_t begin = at_;
  std::size_t found = content_.find(wanted, at_);
  while (found != std::string_view::npos && found > 0 && content_[found - 1] != '\n')
    found = content_.find(wanted, found + 1);
  if (found == std::string_view::npos) fail("the section has no end, " + std::string(wanted) + " expected");
  for (at_ = begin; at_ < found + wanted.size(); ++at_) line_ += content_[at_] == '\n';
}

void MshScanner::begin_data() {
  if (!binary_) return;
  const auto rest = line();
  for (const char c : rest)
    if (!is_space(c)) fail("binary data expected on the line after the section's name, found " + shown(rest));
}

template <class T>
T MshScanner::raw(const char* what) {
  T value;
  if (content_.size() - at_ < sizeof value) fail(std::string(what) + " expected, found the end of the file");
  std::memcpy(&value, content_.data() + at_, sizeof value);
  at_ += sizeof value;
  return value;
}

std::int64_t MshScanner::text_integer(const char* what, std::int64_t low, std::int64_t high) {
  const auto text = word();
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || code != std::errc() || end != text.data() + text.size() || value < low || value > high)
    fail(std::string(what) + " expected (a whole number" + (low == 0 ? " from 0" : "") + "), found " +
         shown(text));
  return value;
}

int MshScanner::integer(const char* what) {
  if (binary_) return raw<std::int32_t>(what);
  return static_cast<int>(
      text_integer(what, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()));
}

std::int64_t MshScanner::size(const char* what) {
  constexpr auto most = std::numeric_limits<std::int64_t>::max();
  if (!binary_) return text_integer(what, 0, most);
  const auto value = raw<std::uint64_t>(what);
  if (value > static_cast<std::uint64_t>(most)) fail(std::string(what) + " out of range");
  return static_cast<std::int64_t>(value);
}

std::int64_t MshScanner::count(const char* what, int bytes) {
  const auto value = size(what);
  const auto left = static_cast<std::int64_t>(content_.size() - at_);
  if (value > left / bytes + 1 || value > std::numeric_limits<int>::max())
    fail(std::string(what) + ": " + std::to_string(value) +
         " announced, more than the rest of the file holds");
  return value;
}

double MshScanner::real(const char* what) {
  double value = 0;
  std::string_view text = "not a number";
  if (binary_) {
    value = raw<double>(what);
  } else {
    text = word();
    const std::size_t sign = !text.empty() && text[0] == '+';
    const auto [end, code] = std::from_chars(text.data() + sign, text.data() + text.size(), value);
    if (text.empty() || code != std::errc() || end != text.data() + text.size()) value = std::nan("");
  }
  if (!std::isfinite(value)) fail(std::string(what) + " expected (a finite number), found " + shown(text));
  return value;
}

}  // namespace powbench::sim
