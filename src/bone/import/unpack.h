// Compressed streams within image files.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace kerf {

struct Unpacked {
  double bytes = 0;      // total number of unpacked bytes
  bool damaged = false;  // the stream is inconsistent or does not match its checksum
  bool cut_off = false;  // the file ends before the stream does
};

/// Opens an image's file for reading. Throws kerf::Error for a pipe or device, which may never end. If the file does
/// not exist, the stream returned is not good().
std::ifstream OpenImageFile(const std::string& path);

/// Returns whether the file begins like a gzip file. Throws kerf::Error as OpenImageFile() does.
bool IsGzip(const std::string& path);

/// Unpacks the gzip or zlib stream that begins at `offset` in a file, until it ends or `max_bytes` bytes are unpacked.
/// The bytes after the first `skip` are appended to `out` unless it is null.
Unpacked Unpack(const std::string& path, std::uint64_t offset, double max_bytes, double skip = 0,
                std::vector<char>* out = nullptr);

/// Returns the unpacked data set of a DICOM file that is deflated as a whole (PS3.5 A.5), from the position of `in` on.
/// `path`: for messages. Throws kerf::Error if the stream is damaged, cut off, or unpacks to more than `most_bytes`.
std::string UnpackDeflated(std::istream& in, std::uint64_t most_bytes, const std::string& path);

/// The same for a bzip2 stream.
Unpacked UnpackBzip2(const std::string& path, std::uint64_t offset, double max_bytes, double skip = 0,
                     std::vector<char>* out = nullptr);

}  // namespace kerf
