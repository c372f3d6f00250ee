#include "host/import/wav.h"

#include <fmt/format.h>

#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

constexpr std::uint64_t most_channels = 64;

std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t length) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < length; ++i)
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

struct Format {
  std::uint64_t code = 0, channels = 0, hertz = 0, bits = 0;
  std::size_t frame() const { return channels * (bits / 8); }
  bool understood() const {
    return (code == 1 && (bits == 8 || bits == 16 || bits == 24 || bits == 32)) ||
           (code == 3 && (bits == 32 || bits == 64));
  }
};

/// Share of full scale.
double sample(std::string_view bytes, std::size_t at, const Format& f) {
  const std::uint64_t raw = number(bytes, at, f.bits / 8);
  if (f.code == 3)
    return f.bits == 32 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)))
                        : std::bit_cast<double>(raw);
  if (f.bits == 8) return (static_cast<double>(raw) - 128.0) / 128.0;  // the one that has no sign
  const std::uint64_t sign = std::uint64_t{1} << (f.bits - 1);
  return static_cast<double>(static_cast<std::int64_t>(raw ^ sign) - static_cast<std::int64_t>(sign)) /
         static_cast<double>(sign);
}

CsvTable table_of(std::string_view data, const Format& f) {
  CsvTable table;
  const std::size_t rows = data.size() / f.frame();
  table.header.emplace_back("time [s]");
  table.columns.emplace_back(rows);
  for (std::size_t c = 0; c < f.channels; ++c) {
    table.header.push_back(fmt::format("ch{} [V]", c + 1));
    table.columns.emplace_back(rows);
  }
  for (std::size_t row = 0; row < rows; ++row) {
    table.columns[0][row] = static_cast<double>(row) / static_cast<double>(f.hertz);
    for (std::size_t c = 0; c < f.channels; ++c) {
      const double value = sample(data, row * f.frame() + c * (f.bits / 8), f);
      if (!std::isfinite(value)) ++table.over_range;
      table.columns[c + 1][row] = std::isfinite(value) ? value : std::nan("");
    }
    table.line.push_back(static_cast<std::uint32_t>(row + 1));
  }
  return table;
}

}  // namespace

CsvTable parse_wav(std::string_view bytes, const std::string& file) {
  const auto refuse = [&](const std::string& why) { throw BadInput({file + ": " + why}); };
  if (bytes.size() < 12 || bytes.substr(0, 4) != "RIFF" || bytes.substr(8, 4) != "WAVE")
    refuse("is no WAV file: it does not begin with RIFF and WAVE");
  Format format;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::string_view kind = bytes.substr(at, 4);
    const std::uint64_t length = number(bytes, at + 4, 4), left = bytes.size() - at - 8;
    if (kind == "fmt ") {
      if (length < 16 || length > left)
        refuse(fmt::format("its format chunk has {} bytes; 16 or more", length));
      format = {number(bytes, at + 8, 2), number(bytes, at + 10, 2), number(bytes, at + 12, 4),
                number(bytes, at + 22, 2)};
      if (format.code == 0xFFFE && length >= 26) format.code = number(bytes, at + 32, 2);
      if (!format.understood())
        refuse(fmt::format(
            "format {} with {} bits; PCM (1) with 8, 16, 24 or 32, or IEEE float (3) with 32 or 64 is read",
            format.code, format.bits));
      if (format.channels < 1 || format.channels > most_channels)
        refuse(fmt::format("{} channels; allowed 1 to {}", format.channels, most_channels));
      if (format.hertz < 1) refuse("a sampling rate of 0");
    }
    if (kind == "data") {
      if (format.code == 0) refuse("its data come before their format");
      const bool to_the_end =
          length == 0xFFFF'FFFF;  // written by a recorder that did not know how long it would be
      if (length > left && !to_the_end)
        refuse(fmt::format("ends {} bytes before its data do: it is cut", length - left));
      const std::size_t used = to_the_end ? left : length;
      if (used < 2 * format.frame()) refuse("has fewer than two samples");
      if (used / format.frame() > most_rows)
        refuse(fmt::format("has {} samples; at most {} are read", used / format.frame(), most_rows));
      return table_of(bytes.substr(at + 8, used), format);
    }
    if (length > left) break;
    at += 8 + length + length % 2;
  }
  refuse(format.code == 0 ? "has no format chunk: it is cut or damaged"
                          : "has no data chunk: it is cut or damaged");
  return {};
}

bool is_wav(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".wav";
}

}  // namespace powbench::host
