#include "pack/pack.h"

#include <zstd.h>

#include <array>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::array<std::uint32_t, 256> MakeCrcTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0x82f63b78u : crc >> 1;
    table[i] = crc;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = MakeCrcTable();

}  // namespace

std::string Pack(std::string_view bytes, int level) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(size) != 0) throw Error(std::string("can't be compressed: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

std::string Unpack(std::string_view packed, std::size_t most_bytes) {
  const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (stated == ZSTD_CONTENTSIZE_ERROR || stated == ZSTD_CONTENTSIZE_UNKNOWN) {
    throw Error("is not what Zstandard packs");
  }
  if (stated > most_bytes) throw Error("says that it is larger unpacked than it may be");
  std::string bytes(static_cast<std::size_t>(stated), '\0');
  const std::size_t size = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0) throw Error(std::string("can't be unpacked: ") + ZSTD_getErrorName(size));
  if (size != bytes.size()) throw Error("is not as long unpacked as it says");
  return bytes;
}

std::uint32_t CalcCrc32c(std::string_view bytes, std::uint32_t seed) {
  std::uint32_t crc = ~seed;
  for (const char c : bytes) crc = (crc >> 8) ^ kCrcTable[(crc ^ static_cast<unsigned char>(c)) & 0xff];
  return ~crc;
}

}  // namespace kerf
