#include "host/import/dcc.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <pugixml.hpp>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

std::string_view local(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// The first node of this name below `from`, at any depth; the search keeps no stack.
pugi::xml_node find(const pugi::xml_node& from, std::string_view name) {
  return from.find_node([name](const pugi::xml_node& n) { return local(n) == name; });
}

std::string text_of(const pugi::xml_node& node) {
  std::string text = node.child_value();
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == std::string::npos ? "" : text.substr(begin);
}

double number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : std::nan("");
}

CertifiedQuantity quantity_of(const pugi::xml_node& real) {
  CertifiedQuantity q;
  for (const pugi::xml_node& child : real.children()) {
    if (local(child) == "value") q.value = number(text_of(child));
    if (local(child) == "unit") q.unit = text_of(child);
    if (local(child) == "label") q.name = text_of(child);
  }
  for (const char* name : {"valueExpandedMU", "uncertainty"})
    if (const auto u = find(real, name); u && std::isnan(q.expanded)) q.expanded = number(text_of(u));
  if (const auto k = find(real, "coverageFactor")) q.coverage = number(text_of(k));
  // the name stands beside the number, in the quantity that holds it
  for (const pugi::xml_node& child : real.parent().children())
    if (local(child) == "name" && q.name.empty()) q.name = text_of(find(child, "content"));
  return q;
}

/// `\milli\volt\per\newton` as a factor on {V: 1, N: -1}; nothing for another unit or a power.
struct Unit {
  double factor = 1.0;
  std::map<std::string, int> power;
};

std::optional<Unit> parse_unit(const std::string& text) {
  static const std::map<std::string, double> prefixes{{"pico", 1e-12}, {"nano", 1e-9},  {"micro", 1e-6},
                                                      {"milli", 1e-3}, {"centi", 1e-2}, {"kilo", 1e3},
                                                      {"mega", 1e6}};
  static const std::map<std::string, std::string> units{
      {"volt", "V"}, {"newton", "N"}, {"metre", "m"}, {"meter", "m"}, {"ampere", "A"}};
  Unit u;
  double prefix = 1.0;
  int sign = 1;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] != '\\') return std::nullopt;
    const std::size_t end = std::min(text.find('\\', at + 1), text.size());
    const std::string word = text.substr(at + 1, end - at - 1);
    at = end;
    if (word == "per") {
      sign = -1;
    } else if (const auto p = prefixes.find(word); p != prefixes.end()) {
      prefix *= p->second;
    } else if (const auto known = units.find(word); known != units.end()) {
      u.power[known->second] += sign;
      u.factor *= sign > 0 ? prefix : 1.0 / prefix;
      prefix = 1.0, sign = 1;
    } else {
      return std::nullopt;
    }
  }
  return u;
}

}  // namespace

Certificate parse_dcc(std::string_view xml, const std::string& file) {
  pugi::xml_document doc;
  const pugi::xml_parse_result parsed = doc.load_buffer(xml.data(), xml.size());
  if (!parsed)
    throw BadInput({fmt::format("{}: is no XML: {} at byte {}", file, parsed.description(), parsed.offset)});
  const auto root = find(doc, "digitalCalibrationCertificate");
  if (!root)
    throw BadInput(
        {file + ": is no digital calibration certificate: it has no element digitalCalibrationCertificate"});
  Certificate c;
  c.id = text_of(find(root, "uniqueIdentifier"));
  if (c.id.empty()) throw BadInput({file + ": the certificate has no uniqueIdentifier"});
  c.performed = text_of(find(root, "endPerformanceDate")).substr(0, 10);
  struct Walk : pugi::xml_tree_walker {
    std::vector<CertifiedQuantity>* to = nullptr;
    bool for_each(pugi::xml_node& node) override {
      if (local(node) == "real") to->push_back(quantity_of(node));
      return to->size() < 10'000;
    }
  } walk;
  walk.to = &c.quantities;
  if (auto results = find(root, "measurementResults")) results.traverse(walk);
  return c;
}

CertifiedGain gain_of(const Certificate& c, std::string_view unit, const std::string& file) {
  std::vector<CertifiedGain> found;
  std::string names;
  for (const CertifiedQuantity& q : c.quantities) {
    const auto u = parse_unit(q.unit);
    if (!u || u->power.size() != 2 || !u->power.contains("V") || !u->power.contains(std::string(unit)))
      continue;
    const int own = u->power.at(std::string(unit)), volts = u->power.at("V");
    if (!std::isfinite(q.value) || q.value == 0 || own * volts != -1) continue;
    const double v = q.value * u->factor, U = q.expanded * u->factor;
    found.push_back(own > 0 ? CertifiedGain{v, U, q.coverage}
                            : CertifiedGain{1 / v, std::abs(U / (v * v)), q.coverage});
    names += (names.empty() ? "'" : ", '") + q.name + "'";
  }
  if (found.size() == 1) return found[0];
  if (found.empty())
    throw BadInput({fmt::format(
        "{}: certificate {} has no quantity in {} per volt or volts per {}; write the gain into the "
        "calibration file instead",
        file, c.id, unit, unit)});
  throw BadInput({fmt::format(
      "{}: certificate {} has {} quantities in {} per volt or its inverse ({}); allowed one: write the "
      "gain into the calibration file instead",
      file, c.id, found.size(), unit, names)});
}

}  // namespace powbench::host
