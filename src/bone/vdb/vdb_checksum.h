// Checksum of kerf's own .vdb files: CRC-32C of all bytes of the file. It detects any flipped bit, in the header as
// well as in a voxel.
//
// The checksum is in the file's metadata as "kerf_checksum": 8 hexadecimal digits, a space, and the file's identity,
// the 36 characters that OpenVDB generates in the header whenever it writes a file. For the sum, the digits count as
// '0'. A program that reads and rewrites a bone copies the metadata and generates another identity: its output has no
// valid kerf checksum, and is read without the check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

namespace kerf {

inline constexpr std::string_view kVdbChecksumName = "kerf_checksum";
inline constexpr std::size_t kVdbIdentityBytes = 36;
inline constexpr std::size_t kVdbIdentityOffset = 21;  // offset in the file

/// Returns the metadata value that must be in the file before StampVdb() is called.
std::string MakeBlankVdbChecksum();
/// Replaces the blank checksum. Throws std::ios_base::failure, and kerf::Error if the file contains no blank checksum.
void StampVdb(const std::string& file);

/// An entry of a file's metadata.
struct VdbChecksumEntry {
  std::uint64_t place = 0;  // offset of the value in the file
  std::string value;
};
/// Recognises the entry by its name or by the shape of its value, so that one damaged character does not hide it.
bool IsVdbChecksum(std::string_view name, std::string_view value);
/// Throws kerf::Error if the bytes of `in`, from its beginning, are not those that were written. `path` names `in` in
/// messages. Cost: reads the file once.
void CheckVdbChecksum(std::istream& in, const std::string& path, const VdbChecksumEntry& entry,
                      std::string_view identity);

}  // namespace kerf
