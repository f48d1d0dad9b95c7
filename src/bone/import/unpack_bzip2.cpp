#include <bzlib.h>

#include <algorithm>
#include <cstddef>
#include <fstream>

#include "base/files/files.h"
#include "bone/import/unpack.h"

namespace kerf {

Unpacked UnpackBzip2(const std::string& path, std::uint64_t offset, double max_bytes, double skip,
                     std::vector<char>* out) {
  constexpr double kChunkBytes = 1 << 20;
  std::ifstream in = OpenImageFile(path);
  in.seekg(static_cast<std::streamoff>(offset));
  Unpacked result;
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return result;
  std::vector<char> packed(1 << 18);
  std::vector<char> chunk(static_cast<std::size_t>(kChunkBytes));
  bool within_stream = true;
  int state = BZ_OK;
  while (result.bytes < max_bytes && state == BZ_OK && in) {
    in.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    if (in.bad()) break;
    stream.next_in = packed.data();
    stream.avail_in = static_cast<unsigned>(in.gcount());
    if (stream.avail_in == 0) break;
    do {
      stream.next_out = chunk.data();
      stream.avail_out = static_cast<unsigned>(std::clamp(max_bytes - result.bytes, 1.0, kChunkBytes));
      const unsigned room = stream.avail_out;
      state = BZ2_bzDecompress(&stream);
      const unsigned got = room - stream.avail_out;
      const auto skipped = static_cast<std::size_t>(std::clamp(skip - result.bytes, 0.0, static_cast<double>(got)));
      if (out != nullptr) out->insert(out->end(), chunk.data() + skipped, chunk.data() + got);
      result.bytes += got;
      within_stream = within_stream || got > 0;
      if (state != BZ_STREAM_END) continue;
      within_stream = false;
      const bz_stream rest = stream;  // a file may have several consecutive streams
      BZ2_bzDecompressEnd(&stream);
      stream = bz_stream{};
      if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return result;
      stream.next_in = rest.next_in;
      stream.avail_in = rest.avail_in;
      state = BZ_OK;
    } while (state == BZ_OK && (stream.avail_out == 0 || stream.avail_in > 0) && result.bytes < max_bytes);
  }
  BZ2_bzDecompressEnd(&stream);
  CheckReadable(in, path);
  result.damaged = within_stream && state < 0;
  result.cut_off = within_stream && !result.damaged && result.bytes < max_bytes;
  return result;
}

}  // namespace kerf
