#include "host/config/unknown_key.h"

#include <vector>

#include "host/config/file_reader.h"
#include "host/config/nearest.h"

namespace powbench::host {
namespace {

using Words = std::vector<std::string>;

std::string meant(const std::string& guess) {
  return "; did you mean '" + guess + "'?";
}

std::string known(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "; known: " : ", ") + word;
  return text;
}

Words sections_of(const FileKind& kind) {
  Words names;
  for (const Section& section : kind.sections())
    if (!section.name.empty()) names.push_back(section.name);
  return names;
}

Words keys_of(const FileKind& kind, const std::string& section) {
  Words keys;
  for (const Field& field : kind.fields())
    if (field.section == section) keys.push_back(field.key);
  return keys;
}

/// The section below `section` that a key is named after, as limits.t_ct1 for t_ct1_ms in [limits]; or empty.
std::string section_below(const FileKind& kind, const std::string& section, const std::string& key) {
  std::string longest;
  for (const std::string& inner : sections_of(kind)) {
    if (!inner.starts_with(section + ".")) continue;
    const std::string last = inner.substr(section.size() + 1);
    if ((key == last || key.starts_with(last + "_")) && inner.size() > longest.size()) longest = inner;
  }
  return longest;
}

constexpr std::string_view group_prefix = "group.";

/// The names of groups without what all begin with.
Words group_names(const Words& sections) {
  Words out;
  for (const auto& s : sections)
    if (s.starts_with(group_prefix)) out.push_back(s.substr(group_prefix.size()));
  return out;
}

std::string listed(const std::string& words, const Words& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? words : ", ") + name;
  return text;
}

/// What groups there are, which have no section, and which of them may be meant.
std::string groups(const std::string& section, const Words& all, const Words& open) {
  const Words names = group_names(open);
  const std::string guess = nearest(section.substr(group_prefix.size()), names);
  return listed("; the mesh has ", group_names(all)) + listed("; without a section: ", names) +
         (guess.empty() ? "" : meant(std::string(group_prefix) + guess));
}

}  // namespace

std::string unknown_key(const FileKind& kind, const std::string& section, const std::string& key) {
  const Words here = keys_of(kind, section);
  if (const std::string guess = nearest(key, here); !guess.empty()) return "unknown key" + meant(guess);
  Words elsewhere;
  for (const Field& field : kind.fields()) {
    if (field.key == key)
      return field.section.empty() ? "unknown key here; '" + key + "' stands above the first [section]"
                                   : "unknown key here" + meant(full_key(field.section, key));
    if (field.section != section) elsewhere.push_back(field.key);
  }
  const std::string guess = nearest(key, elsewhere);
  for (const Field& field : kind.fields())
    if (!guess.empty() && field.key == guess) return "unknown key" + meant(full_key(field.section, guess));
  const std::string inner = section_below(kind, section, key);
  if (!inner.empty())
    return "unknown key; write [" + inner + "] and its keys below" + known(keys_of(kind, inner));
  return "unknown key" + known(here);
}

std::string unknown_section(const FileKind& kind, const std::string& section,
                            const std::set<std::string>& there) {
  const Words all = sections_of(kind);
  Words open;  // a group stands for one part, so that its section is not meant twice
  for (const auto& name : all)
    if (!there.contains(name)) open.push_back(name);
  if (section.starts_with(group_prefix)) return "unknown section" + groups(section, all, open);
  const std::string guess = nearest(section, all);
  return "unknown section" + (guess.empty() ? known(all) : meant(guess));
}

}  // namespace powbench::host
