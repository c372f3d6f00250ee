#include "host/store/hash.h"

#include <openssl/evp.h>

#include <array>
#include <stdexcept>

namespace powbench::host {

namespace {

using Bytes = std::array<unsigned char, EVP_MAX_MD_SIZE>;

void require(int done) {
  if (done != 1) throw std::runtime_error("SHA-256 is not available in this build of libcrypto");
}

std::string hex_digits(const Bytes& digest, unsigned int size) {
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += "0123456789abcdef"[digest[i] >> 4];
    text += "0123456789abcdef"[digest[i] & 15U];
  }
  return text;
}

EVP_MD_CTX* raw(const std::shared_ptr<void>& context) {
  return static_cast<EVP_MD_CTX*>(context.get());
}

}  // namespace

std::string sha256_hex(std::span<const std::uint8_t> bytes) {
  Bytes digest{};
  unsigned int size = 0;
  require(EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr));
  return hex_digits(digest, size);
}

std::string sha256_hex(std::string_view text) {
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Sha256::Sha256() : context_(EVP_MD_CTX_new(), [](void* c) { EVP_MD_CTX_free(static_cast<EVP_MD_CTX*>(c)); }) {
  require(EVP_DigestInit_ex(raw(context_), EVP_sha256(), nullptr));
}

void Sha256::add(std::string_view part) {
  require(EVP_DigestUpdate(raw(context_), part.data(), part.size()));
}

std::string Sha256::hex() {
  Bytes digest{};
  unsigned int size = 0;
  require(EVP_DigestFinal_ex(raw(context_), digest.data(), &size));
  return hex_digits(digest, size);
}

}  // namespace powbench::host
