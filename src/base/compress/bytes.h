// Conversion of numbers to little-endian bytes and back, with a variable-length format for integers.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "kerf/error.h"

namespace kerf {

static_assert(std::endian::native == std::endian::little, "stored data is little-endian");

/// Map signed integers of small magnitude to small unsigned integers, and back.
constexpr std::uint64_t ZigZag(std::int64_t x) {
  return (static_cast<std::uint64_t>(x) << 1) ^ static_cast<std::uint64_t>(x >> 63);
}
constexpr std::int64_t UnZigZag(std::uint64_t x) {
  return static_cast<std::int64_t>((x >> 1) ^ (~(x & 1) + 1));
}

class ByteWriter {
 public:
  template <typename T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
  }
  /// Appends `x` with seven bits per byte, lowest first (LEB128).
  void PutNumber(std::uint64_t x) {
    for (; x >= 0x80; x >>= 7) bytes_ += static_cast<char>(x | 0x80);
    bytes_ += static_cast<char>(x);
  }
  void PutSigned(std::int64_t x) { PutNumber(ZigZag(x)); }
  /// Appends the length and then the text.
  void PutText(std::string_view text) {
    PutNumber(text.size());
    bytes_ += text;
  }
  const std::string& bytes() const { return bytes_; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what ByteWriter wrote. Throws kerf::Error if the bytes end too early or do not form a number. Never reads
/// beyond the end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T Get() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, GetBytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::uint64_t GetNumber() {
    std::uint64_t x = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<unsigned char>(GetBytes(1)[0]);
      if (shift == 63 && byte > 1) break;
      x |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return x;
    }
    throw Error("contains a number of more than 64 bits");
  }
  std::int64_t GetSigned() { return UnZigZag(GetNumber()); }
  std::string_view GetText() {
    const std::uint64_t size = GetNumber();
    if (size > left()) throw Error("ends too early");
    return GetBytes(static_cast<std::size_t>(size));
  }
  std::string_view GetBytes(std::size_t count) {
    if (count > left()) throw Error("ends too early");
    const std::string_view bytes = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return bytes;
  }
  std::size_t left() const { return bytes_.size(); }
  /// Reads the number of items that follow, each of at least `bytes_each` bytes. Throws kerf::Error if the remaining
  /// bytes are too few for them, so that a caller never reserves memory for items that cannot exist.
  std::size_t GetCount(std::size_t bytes_each) {
    const std::uint64_t count = GetNumber();
    if (count > left() / bytes_each) throw Error("declares more items than its bytes can hold");
    return static_cast<std::size_t>(count);
  }

 private:
  std::string_view bytes_;
};

}  // namespace kerf
