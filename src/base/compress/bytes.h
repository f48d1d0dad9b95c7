// Numbers to bytes and back: little-endian, and whole numbers in as few bytes as they need.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "kerf/error.h"

namespace kerf {

static_assert(std::endian::native == std::endian::little, "what is stored is little-endian");

/// Small numbers of either sign to small ones without, and back.
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
  /// Seven bits a byte, lowest first (LEB128).
  void PutNumber(std::uint64_t x) {
    for (; x >= 0x80; x >>= 7) bytes_ += static_cast<char>(x | 0x80);
    bytes_ += static_cast<char>(x);
  }
  void PutSigned(std::int64_t x) { PutNumber(ZigZag(x)); }
  /// With its length before it.
  void PutText(std::string_view text) {
    PutNumber(text.size());
    bytes_ += text;
  }
  const std::string& bytes() const { return bytes_; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Throws Error where the bytes end too early or a number is none; never reads beyond them.
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
    throw Error("holds a number of more than 64 bits");
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
  /// A count that stands before so many things of at least `bytes_each` bytes: nothing is set aside for more than there
  /// can be.
  std::size_t GetCount(std::size_t bytes_each) {
    const std::uint64_t count = GetNumber();
    if (count > left() / bytes_each) throw Error("says that it holds more than it can");
    return static_cast<std::size_t>(count);
  }

 private:
  std::string_view bytes_;
};

}  // namespace kerf
