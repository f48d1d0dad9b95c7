// SHA-256 (FIPS 180-4), to identify a file by its content.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kerf {

/// Returns the hash as 64 lower-case hexadecimal digits.
std::string CalcSha256(std::span<const std::uint8_t> bytes);

}  // namespace kerf
