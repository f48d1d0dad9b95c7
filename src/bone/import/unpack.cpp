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

std::string UnpackDeflated(std::istream& in, std::uint64_t most_bytes, const std::string& path) {
  std::string unpacked;
  z_stream z{};
  if (inflateInit2(&z, -MAX_WBITS) != Z_OK) throw Error(path + ": not enough memory to unpack the data set");
  std::vector<char> packed(1 << 16), chunk(1 << 18);
  int state = Z_OK;
  while (state == Z_OK && unpacked.size() <= most_bytes && in) {
    in.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    z.next_in = reinterpret_cast<unsigned char*>(packed.data());
    z.avail_in = static_cast<uInt>(in.gcount());
    if (z.avail_in == 0) break;
    do {
      z.next_out = reinterpret_cast<unsigned char*>(chunk.data());
      z.avail_out = static_cast<uInt>(chunk.size());
      state = inflate(&z, Z_NO_FLUSH);
      unpacked.append(chunk.data(), chunk.size() - z.avail_out);
    } while (state == Z_OK && z.avail_out == 0 && unpacked.size() <= most_bytes);
    if (state == Z_BUF_ERROR) state = Z_OK;  // it needs more bytes
  }
  inflateEnd(&z);
  if (unpacked.size() > most_bytes)
    throw Error(fmt::format("{}: the file unpacks to more than {} MiB", path, most_bytes >> 20));
  if (state != Z_STREAM_END) {
    throw Error(
        fmt::format("{}: the file is {}: its deflated data set does not unpack to its end; copy or export it "
                    "again",
                    path, state == Z_OK ? "cut off" : "damaged"));
  }
  return unpacked;
}

}  // namespace kerf
