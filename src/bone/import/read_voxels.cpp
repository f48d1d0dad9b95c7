#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/files/files.h"
#include "bone/import/image_header.h"
#include "bone/import/unpack.h"
#include "bone/import/vti.h"
#include "kerf/error.h"

namespace kerf {

namespace {

std::vector<char> ReadText(const ImageLayout& layout, std::size_t count, const std::string& path) {
  std::ifstream in(layout.data_file);
  in.seekg(static_cast<std::streamoff>(layout.offset));
  std::vector<char> bytes;
  std::string word;
  for (std::size_t n = 0; n < count && in >> word; ++n) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (*end != '\0') throw Error(fmt::format("{}: voxel {} is '{}', which is not a number", path, n + 1, word));
    char one[sizeof value];
    std::memcpy(one, &value, sizeof value);
    bytes.insert(bytes.end(), one, one + sizeof value);
  }
  return bytes;
}

std::vector<char> ReadRaw(const ImageLayout& layout, std::size_t size) {
  std::ifstream in(layout.data_file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(layout.offset));
  std::vector<char> bytes(size);
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  CheckReadable(in, layout.data_file);
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

// Sets where the voxels begin if they are the last bytes of the file.
void SetEnd(ImageLayout& layout, std::size_t count) {
  std::error_code failed;
  const std::uintmax_t file_bytes = std::filesystem::file_size(layout.data_file, failed);
  const std::size_t needed = count * CalcBytes(layout.type);
  if (layout.at_end && !failed && file_bytes >= needed) layout.offset = file_bytes - needed;
}

void SwapBytes(std::vector<char>& bytes, std::size_t size) {
  for (std::size_t at = 0; at + size <= bytes.size(); at += size) {
    std::reverse(&bytes[at], &bytes[at] + size);
  }
}

}  // namespace

std::vector<char> ReadVoxels(ImageLayout& layout, std::size_t count, const std::string& path) {
  std::vector<char> bytes;
  if (const std::vector<std::string> files = layout.data_files; !files.empty()) {
    VoxelType type = layout.type;
    for (const std::string& file : files) {
      ImageLayout one = layout;
      one.data_files.clear();
      one.data_file = file;
      SetEnd(one, count / files.size());
      const std::vector<char> part = ReadVoxels(one, count / files.size(), path);
      bytes.insert(bytes.end(), part.begin(), part.end());
      type = one.type;
    }
    layout.type = type;
    return bytes;
  }
  std::size_t value_bytes = CalcBytes(layout.type);
  switch (layout.packing) {
    case VoxelPacking::kRaw:
      bytes = ReadRaw(layout, count * value_bytes);
      break;
    case VoxelPacking::kGzip:
    case VoxelPacking::kBzip2:
      bytes.reserve(count * value_bytes);
      UnpackStream(layout, layout.lead + static_cast<double>(count * value_bytes), layout.lead, &bytes);
      break;
    case VoxelPacking::kText:
      bytes = ReadText(layout, count, path);
      layout.type = VoxelType::kDouble;
      value_bytes = sizeof(double);
      break;
    case VoxelPacking::kVti:
      bytes = ReadVtiValues(layout, count * value_bytes, path);
      break;
    case VoxelPacking::kUnknown:
      throw Error(fmt::format("{}: voxels with encoding '{}' are not supported; kerf reads raw, gzip, bzip2 and text",
                              path, layout.encoding));
  }
  if (bytes.size() != count * value_bytes) {
    throw Error(
        fmt::format("{}: {} voxels can be read, but the header states {}", path, bytes.size() / value_bytes, count));
  }
  if (layout.swapped && layout.packing != VoxelPacking::kText && value_bytes > 1) SwapBytes(bytes, value_bytes);
  return bytes;
}

}  // namespace kerf
