#include "host/export/zip.h"

#include <zlib.h>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

void put_bytes(std::string& to, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> (8 * i));
}

std::string deflated(std::string_view text) {
  z_stream z{};
  if (deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw BadInput({"no memory to compress"});
  std::string out(deflateBound(&z, text.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  z.avail_in = static_cast<uInt>(text.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

}  // namespace

void Zip::add(const std::string& name, std::string_view text) {
  const std::string packed = deflated(text);
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()));
  std::string head;
  for (const std::uint32_t v : {20, 0, 8, 0, 0x21}) put_bytes(head, v, 2);  // deflated, 1980-01-01
  for (const std::size_t v : {std::size_t{sum}, packed.size(), text.size()})
    put_bytes(head, static_cast<std::uint32_t>(v), 4);
  put_bytes(head, static_cast<std::uint32_t>(name.size()), 2), put_bytes(head, 0, 2);
  put_bytes(directory_, 0x02014B50, 4), put_bytes(directory_, 20, 2);
  directory_ += head;
  put_bytes(directory_, 0, 2), put_bytes(directory_, 0, 2), put_bytes(directory_, 0, 2),
      put_bytes(directory_, 0, 4);
  put_bytes(directory_, static_cast<std::uint32_t>(bytes_.size()), 4);
  directory_ += name;
  put_bytes(bytes_, 0x04034B50, 4);
  bytes_ += head + name + packed;
  ++files_;
}

std::string Zip::finish() const {
  std::string end;
  put_bytes(end, 0x06054B50, 4), put_bytes(end, 0, 4), put_bytes(end, files_, 2), put_bytes(end, files_, 2);
  put_bytes(end, static_cast<std::uint32_t>(directory_.size()), 4);
  put_bytes(end, static_cast<std::uint32_t>(bytes_.size()), 4), put_bytes(end, 0, 2);
  return bytes_ + directory_ + end;
}

}  // namespace powbench::host
