#include "base/compress/pack.h"

#include <zstd.h>

#include <array>
#include <bit>
#include <cstring>

#include "kerf/error.h"

namespace kerf {
namespace {

static_assert(std::endian::native == std::endian::little, "the checksum reads eight bytes as one number");

constexpr std::size_t kCrcSlices = 8;
/// tables[k][i]: contribution of a byte of value i to the CRC when k more bytes follow it.
using CrcTables = std::array<std::array<std::uint32_t, 256>, kCrcSlices>;

constexpr CrcTables MakeCrcTables() {
  CrcTables tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0x82f63b78u : crc >> 1;
    tables[0][i] = crc;
  }
  for (std::size_t k = 1; k < kCrcSlices; ++k) {
    for (std::size_t i = 0; i < 256; ++i) {
      const std::uint32_t before = tables[k - 1][i];
      tables[k][i] = (before >> 8) ^ tables[0][before & 0xff];
    }
  }
  return tables;
}
constexpr CrcTables kCrcTables = MakeCrcTables();

}  // namespace

std::string Pack(std::string_view bytes, int level) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(size) != 0) throw Error(std::string("can't be compressed: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

std::string Unpack(std::string_view packed, std::size_t max_bytes) {
  const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (stated == ZSTD_CONTENTSIZE_ERROR || stated == ZSTD_CONTENTSIZE_UNKNOWN) {
    throw Error("is not data compressed by Zstandard");
  }
  if (stated > max_bytes) throw Error("declares an unpacked size above the limit");
  std::string bytes(static_cast<std::size_t>(stated), '\0');
  const std::size_t size = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0) throw Error(std::string("can't be unpacked: ") + ZSTD_getErrorName(size));
  if (size != bytes.size()) throw Error("does not have the unpacked size that it declares");
  return bytes;
}

std::uint32_t CalcCrc32c(std::string_view bytes, std::uint32_t seed) {
  std::uint32_t crc = ~seed;
  // Process eight bytes per step, after Kounavis and Berry 2008.
  for (; bytes.size() >= kCrcSlices; bytes.remove_prefix(kCrcSlices)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), sizeof word);
    word ^= crc;
    crc = 0;
    for (std::size_t k = 0; k < kCrcSlices; ++k) crc ^= kCrcTables[kCrcSlices - 1 - k][(word >> (8 * k)) & 0xff];
  }
  for (const char c : bytes) crc = (crc >> 8) ^ kCrcTables[0][(crc ^ static_cast<unsigned char>(c)) & 0xff];
  return ~crc;
}

}  // namespace kerf
