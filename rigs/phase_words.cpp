#include "rigs/phase_words.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <utility>

namespace powbench::rigs {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 8> meanings{
    {{"warming_up", "the history is too short"},
     {"amplitude", "its amplitude is outside 0.7 .. 1.2 of nominal"},
     {"frequency", "its frequency is outside 45 .. 65 Hz"},
     {"residual", "its distortion is above 15 %"},
     {"cross_check", "the phase-locked loop differs by more than 3 deg"},
     {"third_opinion", "the zero crossing differs by more than 5 deg"},
     {"gap", "samples were lost"},
     {"disturbed", "the waveform is not that of a cycle ago"}}};

std::string_view next_word(std::string_view& text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(word.size());
  return word;
}

bool number(std::string_view word, long& value) {
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && error == std::errc() && rest == word.data() + word.size();
}

}  // namespace

std::string phase_words(std::string_view faults, std::string_view uncertainty) {
  long bits = 0, now = 0, ahead = 0;
  if (!number(next_word(faults), bits) || !number(next_word(uncertainty), now) ||
      !number(next_word(uncertainty), ahead))
    return "not known";
  if (bits == 0) {
    char text[80];
    std::snprintf(text, sizeof text, "u = %.3f deg now, %.3f deg 20 ms ahead",
                  1e-3 * static_cast<double>(now), 1e-3 * static_cast<double>(ahead));
    return text;
  }
  std::string out = "not valid: ";
  for (bool first = true; !faults.empty(); first = false) {
    const std::string_view word = next_word(faults);
    if (word.empty()) break;
    std::string_view meaning = word;
    for (const auto& [name, what] : meanings)
      if (name == word) meaning = what;
    out += (first ? "" : "; ") + std::string(meaning);
  }
  return out;
}

}  // namespace powbench::rigs
