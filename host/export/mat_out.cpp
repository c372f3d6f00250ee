#include "host/export/mat_out.h"

#include <bit>
#include <cstdint>

namespace powbench::host {
namespace {

static_assert(std::endian::native == std::endian::little);

template <class Number>
void put_number(std::string& to, Number v) {
  to.append(reinterpret_cast<const char*>(&v), sizeof v);
}

constexpr std::int32_t mat_int8 = 1, mat_int32 = 5, mat_uint32 = 6, mat_double = 9, mat_matrix = 14;
constexpr std::uint32_t class_of_doubles = 6;

void put_element(std::string& to, std::int32_t type, const std::string& bytes) {
  put_number(to, type);
  put_number(to, static_cast<std::uint32_t>(bytes.size()));
  to += bytes;
  to.append((8 - bytes.size() % 8) % 8, '\0');
}

}  // namespace

std::string to_mat(const std::vector<MatVariable>& variables) {
  std::string out = "MATLAB 5.0 MAT-file, written by powbench";
  out.resize(116, ' ');
  out.append(8, '\0');
  put_number(out, std::uint16_t{0x0100});
  out += "IM";  // little-endian
  for (const auto& v : variables) {
    std::string body, part;
    put_number(part, class_of_doubles), put_number(part, std::uint32_t{0});
    put_element(body, mat_uint32, part);
    part.clear();
    put_number(part, static_cast<std::int32_t>(v.rows)),
        put_number(part, static_cast<std::int32_t>(v.columns));
    put_element(body, mat_int32, part);
    put_element(body, mat_int8, v.name);
    part.clear();
    for (std::size_t c = 0; c < v.columns; ++c)
      for (std::size_t r = 0; r < v.rows; ++r) put_number(part, v.values[r * v.columns + c]);
    put_element(body, mat_double, part);
    put_element(out, mat_matrix, body);
  }
  return out;
}

}  // namespace powbench::host
