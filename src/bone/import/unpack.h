// Compressed streams within image files.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace kerf {

struct Unpacked {
  double bytes = 0;      // that were unpacked, all in all
  bool damaged = false;  // the stream contradicts itself or its checksum
  bool cut_off = false;  // the file ends before the stream does
};

/// Opens a file of an image for reading. Throws Error for a pipe or device, which could be read for ever; a file that
/// is not there gives a stream that is not good.
std::ifstream OpenImageFile(const std::string& path);

/// Whether the file begins as gzip does. Throws Error as OpenImageFile() does.
bool IsGzip(const std::string& path);

/// Unpacks the gzip or zlib stream that begins at `offset` of a file until it ends or has given `most` bytes. What
/// comes after its first `skip` bytes is appended to `out`, if there is one.
Unpacked Unpack(const std::string& path, std::uint64_t offset, double most, double skip = 0,
                std::vector<char>* out = nullptr);

}  // namespace kerf
