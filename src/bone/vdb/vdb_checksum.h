// The checksum that kerf's own .vdb files carry: CRC-32C of all bytes of the file, so that whatever bit of it is
// flipped, in the header as in a voxel, is found.
//
// It stands in the file's metadata, as "kerf_checksum": 8 hexadecimal digits, a space, and the file's identity, the 36
// characters which OpenVDB makes up in the header whenever it writes a file. For the sum the digits count as '0'. A
// program that reads a bone and writes it again carries the metadata over and makes up another identity: what it wrote
// has no checksum of kerf's, and is read without.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

namespace kerf {

inline constexpr std::string_view kVdbChecksumName = "kerf_checksum";
inline constexpr std::size_t kVdbIdentityBytes = 36;
inline constexpr std::size_t kVdbIdentityPlace = 21;  // in the file

/// What the metadata holds until StampVdb().
std::string MakeBlankVdbChecksum();
/// Writes the checksum over the blank one. Throws std::ios_base::failure, and Error where the file holds no blank one.
void StampVdb(const std::string& file);

/// An entry of a file's metadata.
struct VdbChecksumEntry {
  std::uint64_t place = 0;  // of the value in the file
  std::string value;
};
/// By its name or by its value's shape, so that one damaged character does not make it another entry.
bool IsVdbChecksum(std::string_view name, std::string_view value);
/// Throws Error when the bytes of `in`, from its first, are not those that were written. `path` names it in messages.
/// Cost: one reading of the file.
void CheckVdbChecksum(std::istream& in, const std::string& path, const VdbChecksumEntry& entry,
                      std::string_view identity);

}  // namespace kerf
