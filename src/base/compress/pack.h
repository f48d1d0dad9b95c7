// Compression of bytes, and detection of damaged data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kerf {

/// Returns the bytes compressed by Zstandard. `level`: 1 (fast) to 19.
std::string Pack(std::string_view bytes, int level = 1);
/// Returns the uncompressed bytes. Allocates at most `max_bytes`, regardless of the size stated in `packed`. Throws
/// kerf::Error if the data is damaged or larger than that.
std::string Unpack(std::string_view packed, std::size_t max_bytes);

/// Computes the CRC-32C (Castagnoli) as in iSCSI, RFC 3720. It detects every error burst of up to 32 bits. `seed`: the
/// CRC of the preceding bytes. Tick-safe.
std::uint32_t CalcCrc32c(std::string_view bytes, std::uint32_t seed = 0);

}  // namespace kerf
