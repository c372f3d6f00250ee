#include "fmu/resource.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

#include "sim/specimen/specimen_fields.h"

namespace powbench::fmu {
namespace {

constexpr std::string_view first_line = "powbench contactor 1, made by powbench ";

std::string digits(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", v);
  return text;
}

std::string list(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : " ") + digits(v);
  return out;
}

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument(std::string(resource_name) + ": " + what);
}

double number(const std::string& key, const std::string& text) {
  char* end = nullptr;
  const double v = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(v)) refuse(key + " = '" + text + "': no number");
  return v;
}

std::vector<double> numbers(const std::string& key, const std::string& text) {
  std::vector<double> out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    out.push_back(number(key, text.substr(at, end - at)));
    at = end + 1;
  }
  return out;
}

std::uint64_t fnv(std::string_view text, std::uint64_t hash) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return hash;
}

}  // namespace

std::string resource_text(const sim::Specimen& s, std::string_view version) {
  std::string out = std::string(first_line) + std::string(version) + "\n";
  std::string name = s.name;
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  out += "name = " + name + "\n";
  for (const auto& f : sim::specimen_fields())
    out += std::string(f.section) + "." + std::string(f.key) + " = " + digits(f.get(s)) + "\n";
  out += "magnet.steel = " + s.magnet.steel + "\n";
  out += "magnet.steel_b = " + list(s.magnet.steel_b) + "\n";
  out += "magnet.steel_h = " + list(s.magnet.steel_h) + "\n";
  return out;
}

sim::Specimen parse_resource(std::string_view text) {
  if (!text.starts_with(first_line)) refuse("is not of this program");
  std::map<std::string, std::string> lines;
  for (std::size_t at = text.find('\n') + 1; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line(text.substr(at, end - at));
    at = end + 1;
    const auto equals = line.find(" = ");
    if (equals == std::string::npos) refuse("'" + line + "': no 'key = value'");
    lines[line.substr(0, equals)] = line.substr(equals + 3);
  }
  const auto take = [&](const std::string& key) {
    const auto found = lines.find(key);
    if (found == lines.end()) refuse(key + " is missing");
    std::string value = found->second;
    lines.erase(found);
    return value;
  };
  sim::Specimen s;
  s.name = take("name");
  for (const auto& f : sim::specimen_fields()) {
    const std::string key = std::string(f.section) + "." + std::string(f.key);
    f.set(s, number(key, take(key)));
  }
  s.magnet.steel = take("magnet.steel");
  s.magnet.steel_b = numbers("magnet.steel_b", take("magnet.steel_b"));
  s.magnet.steel_h = numbers("magnet.steel_h", take("magnet.steel_h"));
  if (!lines.empty()) refuse(lines.begin()->first + " is not known");
  return s;
}

std::string token_of(std::string_view text) {
  const std::uint64_t a = fnv(text, 0xCBF29CE484222325U), b = fnv(text, a ^ 0x9E3779B97F4A7C15U);
  char out[40];
  std::snprintf(out, sizeof out, "{%08x-%04x-%04x-%04x-%012llx}", static_cast<unsigned>(a >> 32),
                static_cast<unsigned>(a >> 16 & 0xFFFFU), static_cast<unsigned>(a & 0xFFFFU),
                static_cast<unsigned>(b >> 48), static_cast<unsigned long long>(b & 0xFFFFFFFFFFFFU));
  return out;
}

std::string read_resource(const std::string& folder) {
  const std::string path = folder + (folder.ends_with('/') ? "" : "/") + resource_name;
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in || text.empty()) throw std::invalid_argument(path + ": cannot be read");
  return text;
}

std::string folder_of_uri(std::string_view uri) {
  if (!uri.starts_with("file:"))
    throw std::invalid_argument("resource location '" + std::string(uri) + "', allowed a file: URI");
  std::string_view path = uri.substr(5);
  if (path.starts_with("//")) path = path.substr(std::min(path.find('/', 2), path.size()));
  std::string out;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const auto hex = [](char c) {
      if (c >= '0' && c <= '9') return c - '0';
      const int letter = (c | 0x20) - 'a';
      return letter >= 0 && letter < 6 ? letter + 10 : -1;
    };
    if (path[k] == '%' && k + 2 < path.size() && hex(path[k + 1]) >= 0 && hex(path[k + 2]) >= 0) {
      out += static_cast<char>(16 * hex(path[k + 1]) + hex(path[k + 2]));
      k += 2;
    } else {
      out += path[k];
    }
  }
  return out;
}

}  // namespace powbench::fmu
