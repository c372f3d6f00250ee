#include "rigs/bridge/layout.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace powbench::rigs::bridge {
namespace {

/// The text of the next start tag of `element` from `at` on, without its brackets; `at` moves behind it.
std::string_view next_tag(std::string_view xml, std::string_view element, std::size_t& at) {
  const std::string opening = "<" + std::string(element) + " ";
  const std::size_t start = xml.find(opening, at);
  std::size_t end = start == std::string_view::npos ? xml.size() : start;
  // a bracket inside a value ends nothing
  for (bool quoted = false; end < xml.size() && (quoted || xml[end] != '>'); ++end)
    if (xml[end] == '"') quoted = !quoted;
  if (end == xml.size()) {
    at = end;
    return {};
  }
  at = end + 1;
  return xml.substr(start + 1, end - start - 1);
}

std::string_view value_of(std::string_view tag, std::string_view attribute) {
  const std::string opening = " " + std::string(attribute) + "=\"";
  const std::size_t start = tag.find(opening);
  if (start == std::string_view::npos) return {};
  const std::size_t from = start + opening.size();
  const std::size_t end = tag.find('"', from);
  return end == std::string_view::npos ? std::string_view{} : tag.substr(from, end - from);
}

std::size_t number_at(std::string_view text) {
  std::size_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Bytes of one sample of a format such as le:S12/16X2>>0: storage bits, times repeat.
std::size_t sample_bytes(std::string_view format) {
  const std::size_t slash = format.find('/');
  if (slash == std::string_view::npos) return 0;
  const std::string_view storage = format.substr(slash + 1);
  const std::size_t repeat = storage.find('X');
  return number_at(storage) / 8 *
         (repeat == std::string_view::npos ? 1 : number_at(storage.substr(repeat + 1)));
}

std::vector<std::size_t> scan_widths(std::string_view device) {
  std::vector<std::pair<std::size_t, std::size_t>> elements;  // index, bytes
  for (std::size_t at = 0; at < device.size();) {
    const std::string_view tag = next_tag(device, "scan-element", at);
    const std::size_t bytes = sample_bytes(value_of(tag, "format"));
    if (bytes > 0) elements.emplace_back(number_at(value_of(tag, "index")), bytes);
  }
  std::stable_sort(elements.begin(), elements.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::size_t> widths;
  for (const auto& [index, bytes] : elements) widths.push_back(bytes);
  return widths;
}

}  // namespace

std::size_t DeviceLayout::scan_bytes(std::uint32_t mask) const {
  if (widths.size() < 32 && mask >> widths.size() != 0) return 0;
  std::size_t size = 0;
  for (std::size_t i = 0; i < widths.size() && i < 32; ++i) {
    if ((mask >> i & 1U) == 0) continue;
    size = (size + widths[i] - 1) / widths[i] * widths[i] + widths[i];
  }
  return size;
}

std::vector<DeviceLayout> read_devices(std::string_view xml) {
  std::vector<DeviceLayout> devices;
  for (std::size_t at = 0; at < xml.size();) {
    const std::string_view tag = next_tag(xml, "device", at);
    if (tag.empty()) break;
    std::size_t end = xml.find("</device>", at);
    if (tag.ends_with('/')) end = at;
    if (end == std::string_view::npos) end = xml.size();
    devices.push_back({std::string(value_of(tag, "id")), std::string(value_of(tag, "name")),
                       scan_widths(xml.substr(at, end - at))});
    at = end;
  }
  return devices;
}

std::string context_attribute(std::string_view xml, std::string_view name) {
  for (std::size_t at = 0; at < xml.size();) {
    const std::string_view tag = next_tag(xml, "context-attribute", at);
    if (value_of(tag, "name") == name) return std::string(value_of(tag, "value"));
  }
  return {};
}

}  // namespace powbench::rigs::bridge
