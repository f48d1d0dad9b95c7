#include "bone/import/unpack.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {

std::ifstream OpenImageFile(const std::string& path) {
  std::error_code unknown;
  const std::filesystem::file_status status = std::filesystem::status(path, unknown);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    CheckIsRegularFile(path);  // throws
  }
  return std::ifstream(path, std::ios::binary);
}

bool IsGzip(const std::string& path) {
  std::ifstream in = OpenImageFile(path);
  return in.get() == 0x1f && in.get() == 0x8b;
}

Unpacked Unpack(const std::string& path, std::uint64_t offset, double max_bytes, double skip, std::vector<char>* out) {
  constexpr double kChunkBytes = 1 << 20;
  std::ifstream in = OpenImageFile(path);
  in.seekg(static_cast<std::streamoff>(offset));
  Unpacked result;
  z_stream z{};
  if (inflateInit2(&z, 15 + 32) != Z_OK) return result;  // 32: detects gzip or zlib
  std::vector<char> packed(1 << 18);
  std::vector<char> chunk(static_cast<std::size_t>(kChunkBytes));
  bool within_member = true;
  int state = Z_OK;
  while (result.bytes < max_bytes && (state == Z_OK || state == Z_BUF_ERROR) && in) {
    in.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    if (in.bad()) break;
    z.next_in = reinterpret_cast<unsigned char*>(packed.data());
    z.avail_in = static_cast<uInt>(in.gcount());
    if (z.avail_in == 0) break;
    do {
      z.next_out = reinterpret_cast<unsigned char*>(chunk.data());
      z.avail_out = static_cast<uInt>(std::clamp(max_bytes - result.bytes, 1.0, kChunkBytes));
      const uInt room = z.avail_out;
      state = inflate(&z, Z_NO_FLUSH);
      const uInt got = room - z.avail_out;
      const auto skipped = static_cast<std::size_t>(std::clamp(skip - result.bytes, 0.0, static_cast<double>(got)));
      if (out != nullptr) out->insert(out->end(), chunk.data() + skipped, chunk.data() + got);
      result.bytes += got;
      within_member = within_member || got > 0;
      if (state != Z_STREAM_END) continue;
      within_member = false;
      state = inflateReset(&z);  // a gzip file may have several consecutive members
    } while (state == Z_OK && (z.avail_out == 0 || z.avail_in > 0) && result.bytes < max_bytes);
  }
  inflateEnd(&z);
  CheckReadable(in, path);
  // Bytes after a complete member that are not another member do not belong to the stream.
  result.damaged = within_member && (state == Z_DATA_ERROR || state == Z_NEED_DICT);
  result.cut_off = within_member && !result.damaged && result.bytes < max_bytes;
  return result;
}

}  // namespace kerf
