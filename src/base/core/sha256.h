// SHA-256 (FIPS 180-4), to name a file by what is in it.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kerf {

/// 64 small hexadecimal digits.
std::string CalcSha256(std::span<const std::uint8_t> bytes);

}  // namespace kerf
