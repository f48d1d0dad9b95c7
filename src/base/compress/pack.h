// Bytes made small, and told from damaged ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kerf {

/// Compressed by Zstandard. `level`: 1 (fast) to 19.
std::string Pack(std::string_view bytes, int level = 1);
/// What was packed. No more memory than `most_bytes` is asked for, whatever `packed` says of itself. Throws Error when
/// it is damaged or would come out larger.
std::string Unpack(std::string_view packed, std::size_t most_bytes);

/// CRC-32C (Castagnoli), as in iSCSI, RFC 3720: finds every burst of up to 32 wrong bits. `seed`: the sum of what goes
/// before. Tick-safe.
std::uint32_t CalcCrc32c(std::string_view bytes, std::uint32_t seed = 0);

}  // namespace kerf
