#include "bone/vdb/vdb_checksum.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "base/compress/pack.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kDigits = 8;
constexpr std::size_t kChecksumBytes = kDigits + 1 + kVdbIdentityBytes;
constexpr std::size_t kBlock = std::size_t{1} << 18;
constexpr std::size_t kSearched = 4096;  // bytes searched from the file's beginning; the entry is the second one
/// Independently generated identities differ in about 30 of their characters, damaged ones in a few.
constexpr std::size_t kOtherIdentity = 12;

bool IsHex(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

bool HasShape(std::string_view value) {
  if (value.size() != kChecksumBytes || value[kDigits] != ' ') return false;
  const auto identity = value.substr(kDigits + 1);
  return std::all_of(value.begin(), value.begin() + kDigits, IsHex) &&
         std::all_of(identity.begin(), identity.end(), [](char c) { return IsHex(c) || c == '-'; });
}

/// Returns the sum of the rest of the stream; the digits at `place` count as '0'.
std::uint32_t CalcSum(std::istream& in, std::uint64_t place) {
  std::vector<char> block(kBlock);
  std::uint32_t sum = 0;
  std::uint64_t begin = 0;
  while (true) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    const auto count = static_cast<std::uint64_t>(in.gcount());
    for (std::uint64_t at = std::max(place, begin); at < std::min(place + kDigits, begin + count); ++at) {
      block[static_cast<std::size_t>(at - begin)] = '0';
    }
    sum = CalcCrc32c({block.data(), static_cast<std::size_t>(count)}, sum);
    begin += count;
    if (count < block.size()) return sum;
  }
}

}  // namespace

std::string MakeBlankVdbChecksum() {
  return fmt::format("{:0>{}} {:0>{}}", "", kDigits, "", kVdbIdentityBytes);
}

void StampVdb(const std::string& file) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.exceptions(std::ios::badbit);
  std::string head(kSearched, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  const std::size_t place = head.find(MakeBlankVdbChecksum());
  if (place == std::string::npos) throw Error(fmt::format("{}: can't be written: no place for its checksum", file));
  stream.clear();
  stream.seekp(static_cast<std::streamoff>(place + kDigits + 1));
  stream.write(head.data() + kVdbIdentityOffset, kVdbIdentityBytes);
  stream.flush();
  stream.seekg(0);
  const std::string digits = fmt::format("{:08x}", CalcSum(stream, place));
  stream.clear();
  stream.exceptions(std::ios::badbit | std::ios::failbit);  // a write that fails in close() sets failbit
  stream.seekp(static_cast<std::streamoff>(place));
  stream.write(digits.data(), static_cast<std::streamsize>(digits.size()));
  stream.close();
}

bool IsVdbChecksum(std::string_view name, std::string_view value) {
  return name == kVdbChecksumName || HasShape(value);
}

void CheckVdbChecksum(std::istream& in, const std::string& path, const VdbChecksumEntry& entry,
                      std::string_view identity) {
  bool fits = HasShape(entry.value);
  if (fits) {
    const std::string_view own = std::string_view(entry.value).substr(kDigits + 1);
    std::size_t other = 0;
    for (std::size_t i = 0; i < own.size() && i < identity.size(); ++i) other += own[i] == identity[i] ? 0 : 1;
    if (other >= kOtherIdentity) return;
    in.clear();
    in.seekg(0);
    fits = fmt::format("{:08x}", CalcSum(in, entry.place)) == entry.value.substr(0, kDigits);
  }
  CheckReadable(in, path);
  if (fits) return;
  throw Error(fmt::format(
      "{}: is damaged: its bytes do not match the checksum that kerf wrote; use another copy of the file, or make the "
      "bone again",
      path));
}

}  // namespace kerf
