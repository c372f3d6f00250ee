#include "host/store/packing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace powbench::host {

namespace {

using Block = std::array<std::uint16_t, packed_block>;
using Words = std::array<std::uint64_t, 16>;

constexpr unsigned widest = 16;

std::uint16_t fold(std::uint16_t d) {
  return static_cast<std::uint16_t>((d << 1) ^ (d & 0x8000U ? 0xFFFFU : 0U));
}
constexpr std::uint16_t unfold(std::uint16_t z) {
  return static_cast<std::uint16_t>((z >> 1) ^ (z & 1U ? 0xFFFFU : 0U));
}

unsigned width_of(const Block& residuals) {
  unsigned all = 0;
  for (const std::uint16_t r : residuals) all |= r;
  return static_cast<unsigned>(std::bit_width(all));
}

void put_word(std::vector<std::uint8_t>& out, std::uint64_t word) {
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
}

void put_bits(std::vector<std::uint8_t>& out, const Block& residuals, unsigned width) {
  std::uint64_t word = 0;
  unsigned used = 0;
  for (const std::uint16_t r : residuals) {
    word |= static_cast<std::uint64_t>(r) << used;
    used += width;
    if (used < 64) continue;
    put_word(out, word);
    used -= 64;
    word = used == 0 ? 0 : static_cast<std::uint64_t>(r) >> (width - used);
  }
}

std::uint16_t residual(std::uint16_t x, std::uint16_t before, std::uint16_t before2, int order) {
  return order == 1 ? fold(static_cast<std::uint16_t>(x - before))
                    : fold(static_cast<std::uint16_t>(x - 2U * before + before2));
}

/// The two values ahead of the next block.
struct Past {
  std::uint16_t x1 = 0, x2 = 0;
};

void pack_block(std::vector<std::uint8_t>& out, const Block& x, Past& past) {
  const std::int16_t smallest =
      static_cast<std::int16_t>(*std::min_element(x.begin(), x.end(), [](std::uint16_t a, std::uint16_t b) {
        return static_cast<std::int16_t>(a) < static_cast<std::int16_t>(b);
      }));
  std::array<Block, 3> residuals;
  for (std::size_t i = 0; i < packed_block; ++i) {
    residuals[0][i] = static_cast<std::uint16_t>(x[i] - static_cast<std::uint16_t>(smallest));
    residuals[1][i] = residual(x[i], past.x1, past.x2, 1);
    residuals[2][i] = residual(x[i], past.x1, past.x2, 2);
    past = {x[i], past.x1};
  }
  unsigned order = 1, width = width_of(residuals[1]);
  if (const unsigned w = width_of(residuals[2]); w < width) order = 2, width = w;
  if (const unsigned w = width_of(residuals[0]); w < width)
    order = 0, width = w;  // one bit less pays its two bytes
  out.push_back(static_cast<std::uint8_t>(order << 5 | width));
  if (order == 0) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint16_t>(smallest)));
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint16_t>(smallest) >> 8));
  }
  put_bits(out, residuals[order], width);
}

/// The residuals of one block; the shifts are known when this is compiled, which is what makes it fast.
template <unsigned width, std::size_t... i>
void take_bits(const Words& w, Block& to, std::index_sequence<i...>) {
  constexpr std::uint64_t mask = (std::uint64_t{1} << width) - 1;
  const auto one = [&]<std::size_t k>(std::integral_constant<std::size_t, k>) {
    constexpr std::size_t bit = k * width, word = bit / 64, shift = bit % 64;
    std::uint64_t v = w[word] >> shift;
    if constexpr (shift + width > 64) v |= w[word + 1] << (64 - shift);
    to[k] = static_cast<std::uint16_t>(v & mask);
  };
  (one(std::integral_constant<std::size_t, i>{}), ...);
}

using Take = void (*)(const Words&, Block&);

template <unsigned width>
void take_block(const Words& words, Block& to) {
  if constexpr (width == 0)
    to.fill(0);
  else
    take_bits<width>(words, to, std::make_index_sequence<packed_block>{});
}

template <unsigned... width>
constexpr std::array<Take, widest + 1> takers(std::integer_sequence<unsigned, width...>) {
  return {&take_block<width>...};
}
constexpr std::array<Take, widest + 1> take = takers(std::make_integer_sequence<unsigned, widest + 1>{});

/// Residuals to values, in place.
void sum_up(Block& x, unsigned order, std::uint16_t smallest, Past& past) {
  if (order == 0) {
    for (std::uint16_t& v : x) v = static_cast<std::uint16_t>(v + smallest);
  } else if (order == 1) {
    std::uint16_t sum = past.x1;
    for (std::uint16_t& v : x) v = sum = static_cast<std::uint16_t>(sum + unfold(v));
  } else {
    std::uint16_t sum = past.x1, step = static_cast<std::uint16_t>(past.x1 - past.x2);
    for (std::uint16_t& v : x) {
      step = static_cast<std::uint16_t>(step + unfold(v));
      v = sum = static_cast<std::uint16_t>(sum + step);
    }
  }
  past = {x[packed_block - 1], x[packed_block - 2]};
}

std::uint64_t word_at(const std::uint8_t* at) {
  if constexpr (std::endian::native == std::endian::little) {
    std::uint64_t word;
    std::memcpy(&word, at, sizeof word);
    return word;
  }
  std::uint64_t word = 0;
  for (int i = 0; i < 8; ++i) word |= static_cast<std::uint64_t>(at[i]) << (8 * i);
  return word;
}

/// One channel from `bytes`, which shrink by what was read.
bool unpack_channel(std::span<const std::uint8_t>& bytes, std::span<std::int16_t> to) {
  Past past;
  Block x;
  Words words{};
  for (std::size_t first = 0; first < to.size(); first += packed_block) {
    if (bytes.empty()) return false;
    const unsigned order = bytes[0] >> 5, width = bytes[0] & 0x1FU;
    const std::size_t head = order == 0 ? 3 : 1, size = head + 8 * width;
    if (order > 2 || width > widest || bytes.size() < size) return false;
    const auto smallest = static_cast<std::uint16_t>(order == 0 ? bytes[1] | bytes[2] << 8 : 0);
    for (unsigned i = 0; i < width; ++i) words[i] = word_at(&bytes[head + 8 * i]);
    take[width](words, x);
    sum_up(x, order, smallest, past);
    std::memcpy(&to[first], x.data(), 2 * std::min(packed_block, to.size() - first));
    bytes = bytes.subspan(size);
  }
  return true;
}

}  // namespace

std::vector<std::uint8_t> pack_samples(std::span<const Samples> channels) {
  std::vector<std::uint8_t> out;
  for (const Samples& samples : channels) {
    Past past;
    for (std::size_t first = 0; first < samples.size(); first += packed_block) {
      Block x;
      const std::size_t n = std::min(packed_block, samples.size() - first);
      for (std::size_t i = 0; i < packed_block; ++i)
        x[i] = static_cast<std::uint16_t>(samples[first + std::min(i, n - 1)]);
      pack_block(out, x, past);
    }
  }
  return out;
}

bool unpack_samples(std::span<const std::uint8_t> bytes, std::span<const std::span<std::int16_t>> channels) {
  for (const auto& to : channels)
    if (!unpack_channel(bytes, to)) return false;
  return bytes.empty();
}

}  // namespace powbench::host
