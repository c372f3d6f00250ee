#pragma once

#include <cstdint>
#include <span>
#include <vector>

/// Lossless packing of converter counts: what a store keeps in place of bare samples.
///
/// One channel after the other, in blocks of 64 samples (the last one filled up with its last value). A block is a byte
/// `order << 5 | width`, then for order 0 the block's smallest count as little-endian int16, then 64 residuals of
/// `width` bits (0..16), bit 0 of the first residual first, in `width` little-endian 64-bit words. Residuals, modulo
/// 2^16:
///   order 0: x[i] - smallest;   order 1: z(x[i] - x[i-1]);   order 2: z(x[i] - 2 x[i-1] + x[i-2]);
/// z(d) = 2 d for d >= 0, -2 d - 1 for d < 0 (small for small |d|); x before the channel's first sample is 0. The
/// order of a block is the one that takes the fewest bytes.

namespace powbench::host {

/// Samples of a block.
inline constexpr std::size_t packed_block = 64;

using Samples = std::span<const std::int16_t>;

/// All channels have the same number of samples. Never more than 1 + 1/8 of the bare bytes, plus 131 bytes a channel.
std::vector<std::uint8_t> pack_samples(std::span<const Samples> channels);

/// Fills `channels` (each with as many samples as were packed). False where the bytes are not a packing of just that
/// many samples: `channels` then hold anything. Reads nothing beyond `bytes`.
bool unpack_samples(std::span<const std::uint8_t> bytes, std::span<const std::span<std::int16_t>> channels);

}  // namespace powbench::host
