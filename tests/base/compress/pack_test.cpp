#include "base/compress/pack.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <random>

#include "base/compress/bytes.h"
#include "kerf/error.h"

namespace kerf {
namespace {

TEST(Pack, RoundTripKeepsEveryByte) {
  std::mt19937_64 dice(1);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{100}, std::size_t{1} << 20}) {
    std::string bytes(size, 'a');
    for (std::size_t i = 0; i < size; i += 3) bytes[i] = static_cast<char>(dice());
    EXPECT_EQ(Unpack(Pack(bytes), size), bytes);
  }
  EXPECT_LT(Pack(std::string(1 << 20, 'a')).size(), 1000);
}

TEST(Pack, UnpackAllocatesAtMostTheLimit) {
  const std::string packed = Pack(std::string(1 << 20, 'a'));
  EXPECT_THROW(Unpack(packed, (1 << 20) - 1), Error);
  // A frame of 20 bytes whose header declares a content size of 2^62.
  std::string lie = packed.substr(0, 20);
  lie[4] = static_cast<char>(0xe0);
  for (int i = 5; i < 13; ++i) lie[static_cast<std::size_t>(i)] = i == 12 ? 0x40 : 0;
  EXPECT_THROW(Unpack(lie, std::size_t{1} << 30), Error);
}

TEST(Pack, DamageIsDetected) {
  std::string bytes;
  for (int i = 0; i < 5000; ++i) bytes += static_cast<char>(i * i);
  const std::string packed = Pack(bytes);
  for (std::size_t size = 0; size < packed.size(); size += 7) {
    EXPECT_THROW(Unpack(packed.substr(0, size), bytes.size()), Error) << size;
  }
  EXPECT_THROW(Unpack("", 10), Error);
}

// The check values are those of RFC 3720, B.4.
TEST(Crc32c, KnownValues) {
  EXPECT_EQ(CalcCrc32c("123456789"), 0xe3069283u);
  EXPECT_EQ(CalcCrc32c(std::string(32, '\0')), 0x8a9136aau);
  EXPECT_EQ(CalcCrc32c(std::string(32, '\xff')), 0x62a8ab43u);
  EXPECT_EQ(CalcCrc32c("6789", CalcCrc32c("12345")), 0xe3069283u);
  // The checksum of two consecutive parts, split anywhere, equals that of the whole.
  std::string bytes;
  for (int i = 0; i < 40; ++i) bytes += static_cast<char>(37 * i);
  for (std::size_t at = 0; at <= bytes.size(); ++at) {
    EXPECT_EQ(CalcCrc32c(bytes.substr(at), CalcCrc32c(bytes.substr(0, at))), CalcCrc32c(bytes)) << at;
  }
}

RC_GTEST_PROP(Bytes, NumbersComeBack, (std::vector<std::int64_t> numbers, const std::string& text)) {
  numbers.insert(numbers.end(),
                 {0, -1, 1, std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()});
  ByteWriter out;
  for (const std::int64_t x : numbers) out.PutSigned(x);
  out.PutText(text);
  out.Put(0.1);
  ByteReader in(out.bytes());
  for (const std::int64_t x : numbers) RC_ASSERT(in.GetSigned() == x);
  RC_ASSERT(in.GetText() == text);
  RC_ASSERT(in.Get<double>() == 0.1);
  RC_ASSERT(in.left() == 0u);
  RC_ASSERT_THROWS_AS(in.GetNumber(), Error);
}

TEST(Bytes, InvalidLengthsAreDetected) {
  EXPECT_THROW(ByteReader(std::string(10, '\xff')).GetNumber(), Error);  // more than 64 bits
  ByteWriter out;
  out.PutNumber(1'000'000'000'000);
  EXPECT_THROW(ByteReader(out.bytes()).GetText(), Error);
  EXPECT_THROW(ByteReader(out.bytes()).GetCount(1), Error);
}

}  // namespace
}  // namespace kerf
