#include "host/config/file_kind.h"

#include <cmath>
#include <cstdio>

namespace powbench::host {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

std::string range_text(const AllowedRange& range, const Unit& unit) {
  constexpr double most = std::numeric_limits<double>::max();
  if (range.low == -most && range.high == most) return "";
  std::string text = number_text(range.low) + ".." + number_text(range.high);
  return unit.text.empty() ? text : text + " " + std::string(unit.text);
}

std::string list_text(const std::vector<double>& values, const Unit& unit) {
  std::string text = "[";
  for (const double v : values) text += (text.size() > 1 ? ", " : "") + from_si(v, unit);
  return text + "]";
}

}  // namespace

void FileKind::section(std::string name, std::string meaning) {
  sections_.push_back({std::move(name), std::move(meaning)});
}

Field& FileKind::add(std::string key, Target target, AllowedRange range, std::string meaning, Need need) {
  const std::string allowed = range_text(range, unit_of_key(key));
  fields_.push_back(
      {sections_.back().name, std::move(key), std::move(target), range, std::move(meaning), need, allowed});
  return fields_.back();
}

Field& FileKind::number(std::string key, double& target, AllowedRange range, std::string meaning, Need need) {
  return add(std::move(key), &target, range, std::move(meaning), need);
}

Field& FileKind::number(std::string key, Accessor target, AllowedRange range, std::string meaning) {
  return add(std::move(key), std::move(target), range, std::move(meaning), Need::defaulted);
}

Field& FileKind::numbers(std::string key, std::vector<double*> places, AllowedRange range,
                         std::string meaning) {
  return add(std::move(key), Numbers{std::move(places)}, range, std::move(meaning), Need::defaulted);
}

Field& FileKind::sweep(std::string key, std::vector<double>& target, AllowedRange range, std::string meaning,
                       Need need) {
  return add(std::move(key), Sweep{&target}, range, std::move(meaning), need);
}

Field& FileKind::integer(std::string key, int& target, AllowedRange range, std::string meaning, Need need) {
  return add(std::move(key), &target, range, std::move(meaning), need);
}

Field& FileKind::seed(std::string key, std::uint64_t& target, std::string meaning) {
  Field& field = add(std::move(key), &target, {0, 0x1p53}, std::move(meaning), Need::defaulted);
  field.allowed = "0..2^53";
  return field;
}

Field& FileKind::yes_no(std::string key, bool& target, std::string meaning) {
  Field& field = add(std::move(key), &target, {}, std::move(meaning), Need::defaulted);
  field.allowed = "true, false";
  return field;
}

Field& FileKind::text(std::string key, std::string& target, std::string meaning) {
  return add(std::move(key), &target, {}, std::move(meaning), Need::defaulted);
}

Field& FileKind::texts(std::string key, Texts target, std::string meaning) {
  return add(std::move(key), std::move(target), {}, std::move(meaning), Need::defaulted);
}

Field& FileKind::words_field(std::string key, Choice choice, std::string meaning) {
  std::string allowed;
  for (const auto& word : choice.words) allowed += (allowed.empty() ? "" : ", ") + quoted(word);
  Field& field = add(std::move(key), std::move(choice), {}, std::move(meaning), Need::defaulted);
  field.allowed = std::move(allowed);
  return field;
}

const Field* FileKind::find(std::string_view section, std::string_view key) const {
  for (const auto& field : fields_)
    if (field.section == section && field.key == key) return &field;
  return nullptr;
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04X", static_cast<unsigned>(byte));
      out += escaped;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string value_text(const Field& field) {
  const Unit& unit = field.unit();
  return std::visit(Overloaded{
                        [&](double* v) {
                          const bool none = field.need == Need::optional && std::isnan(*v);
                          return none ? std::string() : from_si(*v, unit);
                        },
                        [](int* v) { return std::to_string(*v); },
                        [](std::uint64_t* v) { return std::to_string(*v); },
                        [](bool* v) { return std::string(*v ? "true" : "false"); },
                        [](std::string* v) { return v->empty() ? std::string() : quoted(*v); },
                        [&](const Accessor& a) { return from_si(a.get(), unit); },
                        [](const Choice& c) { return quoted(c.words[c.get()]); },
                        [&](const Sweep& s) { return list_text(*s.values, unit); },
                        [](const Texts& t) {
                          std::string list;
                          for (const auto& text : *t.values)
                            list += (list.empty() ? "[" : ", ") + quoted(text);
                          return list.empty() ? list : list + "]";
                        },
                        [&](const Numbers& n) {
                          std::vector<double> values;
                          for (const double* place : n.places) values.push_back(*place);
                          return list_text(values, unit);
                        },
                    },
                    field.target);
}

std::string FileKind::template_text() const {
  std::string out = "# powbench " + name_ + " file: " + meaning_ +
                    "\n# Lines that begin with '#' show the defaults; an unknown key is an error.\n";
  for (const auto& section : sections_) {
    if (!section.name.empty()) out += "\n# " + section.meaning + "\n[" + section.name + "]\n";
    for (const auto& field : fields_) {
      if (field.section != section.name) continue;
      out += "# " + field.meaning;
      if (!field.allowed.empty()) out += "; allowed " + field.allowed;
      if (field.need == Need::required) out += "; required";
      const std::string value = value_text(field);
      out += field.need == Need::required ? "\n" : "\n#";
      out += field.key + " = " + (value.empty() ? "(none)" : value) + "\n";
    }
  }
  return out;
}

std::vector<KeyLine> FileKind::lines() const {
  std::vector<KeyLine> out;
  for (const auto& section : sections_)
    for (const auto& field : fields_)
      if (field.section == section.name)
        out.push_back({section.name, section.meaning, field.key, std::string(field.unit().text),
                       field.allowed, field.meaning, value_text(field), field.need == Need::required,
                       std::holds_alternative<std::string*>(field.target) ||
                           std::holds_alternative<Choice>(field.target)});
  return out;
}

std::string FileKind::resolved_text() const {
  std::string out;
  for (const auto& section : sections_) {
    bool headed = section.name.empty();
    for (const auto& field : fields_) {
      const std::string value = field.section == section.name ? value_text(field) : "";
      if (value.empty()) continue;
      if (!headed) out += "\n[" + section.name + "]\n";
      headed = true;
      out += field.key + " = " + value + "\n";
    }
  }
  return out;
}

}  // namespace powbench::host
