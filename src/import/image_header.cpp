#include "import/image_header.h"

#include <fmt/format.h>
#include <itk_zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <vector>

#include "import/limits.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

enum class Packing { kRaw, kGzip, kOther };

// What a header says of its data.
struct Promise {
  std::vector<double> sizes;
  double bytes_per_voxel = 0;
  Packing packing = Packing::kRaw;
  std::string data_file;     // where the voxels are
  std::uint64_t offset = 0;  // of the first voxel, or of the compressed stream, in data_file
  double lead = 0;           // bytes of the unpacked stream before the first voxel
};

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string Trim(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string ReadHead(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: the file can't be opened", path));
  std::string head(kMaxImageHeaderBytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

std::vector<double> Numbers(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double v = 0; in >> v;) numbers.push_back(v);
  return numbers;
}

// Bytes that a gzip or zlib stream unpacks to, counted up to `enough`.
double CountUnpackedBytes(const std::string& path, std::uint64_t offset, double enough) {
  std::ifstream in(path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(offset));
  z_stream z{};
  if (inflateInit2(&z, 15 + 32) != Z_OK) return 0;  // 32: gzip or zlib, as the stream says
  std::vector<char> packed(1 << 18);
  std::vector<unsigned char> unpacked(1 << 20);
  double total = 0;
  int state = Z_OK;
  while (total < enough && (state == Z_OK || state == Z_BUF_ERROR) && in) {
    in.read(packed.data(), static_cast<std::streamsize>(packed.size()));
    z.next_in = reinterpret_cast<unsigned char*>(packed.data());
    z.avail_in = static_cast<uInt>(in.gcount());
    if (z.avail_in == 0) break;
    do {
      z.next_out = unpacked.data();
      z.avail_out = static_cast<uInt>(unpacked.size());
      state = inflate(&z, Z_NO_FLUSH);
      total += static_cast<double>(unpacked.size() - z.avail_out);
    } while (state == Z_OK && z.avail_out == 0 && total < enough);
  }
  inflateEnd(&z);
  return total;
}

Promise ParseNrrd(const std::string& path, const std::string& head) {
  if (head.compare(0, 4, "NRRD") != 0) throw Error(fmt::format("{}: not an NRRD file although its name says so", path));
  static const std::map<std::string, double> kTypes = {{"signed char", 1},
                                                       {"int8", 1},
                                                       {"int8_t", 1},
                                                       {"uchar", 1},
                                                       {"unsigned char", 1},
                                                       {"uint8", 1},
                                                       {"uint8_t", 1},
                                                       {"short", 2},
                                                       {"short int", 2},
                                                       {"signed short", 2},
                                                       {"signed short int", 2},
                                                       {"int16", 2},
                                                       {"int16_t", 2},
                                                       {"ushort", 2},
                                                       {"unsigned short", 2},
                                                       {"unsigned short int", 2},
                                                       {"uint16", 2},
                                                       {"uint16_t", 2},
                                                       {"int", 4},
                                                       {"signed int", 4},
                                                       {"int32", 4},
                                                       {"int32_t", 4},
                                                       {"uint", 4},
                                                       {"unsigned int", 4},
                                                       {"uint32", 4},
                                                       {"uint32_t", 4},
                                                       {"float", 4},
                                                       {"double", 8},
                                                       {"longlong", 8},
                                                       {"long long", 8},
                                                       {"long long int", 8},
                                                       {"int64", 8},
                                                       {"int64_t", 8},
                                                       {"ulonglong", 8},
                                                       {"unsigned long long", 8},
                                                       {"unsigned long long int", 8},
                                                       {"uint64", 8},
                                                       {"uint64_t", 8}};
  Promise promise;
  promise.data_file = path;
  std::size_t at = 0;
  bool ended = false;
  std::string type;
  while (at < head.size()) {
    const std::size_t end = head.find('\n', at);
    if (end == std::string::npos) break;
    const std::string line = Trim(head.substr(at, end - at));
    at = end + 1;
    if (line.empty()) {
      ended = true;
      break;
    }
    const std::size_t colon = line.find(": ");
    if (line[0] == '#' || colon == std::string::npos) continue;
    const std::string key = Lower(Trim(line.substr(0, colon)));
    const std::string value = Trim(line.substr(colon + 2));
    if (key == "type") type = Lower(value);
    if (key == "sizes") promise.sizes = Numbers(value);
    if (key == "encoding") {
      const std::string encoding = Lower(value);
      promise.packing = encoding == "raw"                        ? Packing::kRaw
                        : encoding == "gzip" || encoding == "gz" ? Packing::kGzip
                                                                 : Packing::kOther;
    }
    if (key == "data file" || key == "datafile") {
      if (Lower(value).compare(0, 4, "list") == 0 || value.find('%') != std::string::npos) {
        throw Error(fmt::format("{}: the voxels are spread over several files; kerf reads NRRD with one", path));
      }
      promise.data_file = (fs::path(path).parent_path() / value).string();
    }
  }
  if (promise.data_file == path) {
    if (!ended) throw Error(fmt::format("{}: the NRRD header has no end (an empty line)", path));
    promise.offset = at;
  }
  const auto known = kTypes.find(type);
  if (known == kTypes.end()) throw Error(fmt::format("{}: voxels of type '{}' are not read", path, type));
  promise.bytes_per_voxel = known->second;
  return promise;
}

Promise ParseMeta(const std::string& path, const std::string& head) {
  static const std::map<std::string, double> kTypes = {{"MET_CHAR", 1},       {"MET_UCHAR", 1}, {"MET_SHORT", 2},
                                                       {"MET_USHORT", 2},     {"MET_INT", 4},   {"MET_UINT", 4},
                                                       {"MET_LONG", 8},       {"MET_ULONG", 8}, {"MET_LONG_LONG", 8},
                                                       {"MET_ULONG_LONG", 8}, {"MET_FLOAT", 4}, {"MET_DOUBLE", 8}};
  Promise promise;
  std::size_t at = 0;
  std::string type = "?";
  double channels = 1;
  bool local = false;
  bool binary = true;
  while (at < head.size() && promise.data_file.empty()) {
    const std::size_t end = std::min(head.find('\n', at), head.size());
    const std::string line = Trim(head.substr(at, end - at));
    at = end + 1;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string key = Trim(line.substr(0, equals));
    const std::string value = Trim(line.substr(equals + 1));
    if (key == "DimSize") promise.sizes = Numbers(value);
    if (key == "ElementType") type = value;
    if (key == "ElementNumberOfChannels" && !Numbers(value).empty()) channels = Numbers(value)[0];
    if (key == "CompressedData" && Lower(value) == "true") promise.packing = Packing::kGzip;
    if (key == "BinaryData" && Lower(value) == "false") binary = false;
    if (key == "ElementDataFile") {
      local = Lower(value) == "local";
      if (!local && (Lower(value).compare(0, 4, "list") == 0 || value.find('%') != std::string::npos)) {
        throw Error(fmt::format("{}: the voxels are spread over several files; kerf reads MetaImage with one", path));
      }
      promise.data_file = local ? path : (fs::path(path).parent_path() / value).string();
    }
  }
  if (promise.data_file.empty()) throw Error(fmt::format("{}: not a MetaImage file although its name says so", path));
  if (!binary) promise.packing = Packing::kOther;
  promise.offset = local ? at : 0;
  const auto known = kTypes.find(type);
  if (known == kTypes.end()) throw Error(fmt::format("{}: voxels of type '{}' are not read", path, type));
  promise.bytes_per_voxel = known->second * channels;
  return promise;
}

template <typename T>
T Field(const std::string& head, std::size_t offset, bool swap) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), head.data() + offset, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

// NIfTI-1: 348 bytes, sizes at 40, bits a voxel at 72, spacings at 76 (the first is no spacing), offset of the voxels
// at 108.
Promise ParseNifti(const std::string& path, std::string head) {
  const bool packed = EndsWith(Lower(path), ".gz");
  if (packed) {
    const gzFile in = gzopen(path.c_str(), "rb");
    std::string first(348, '\0');
    const int got = in == nullptr ? 0 : gzread(in, first.data(), 348);
    if (in != nullptr) gzclose(in);
    head = got == 348 ? first : std::string();
  }
  const auto refuse = [&path] { throw Error(fmt::format("{}: not a NIfTI file although its name says so", path)); };
  if (head.size() < 348) refuse();
  const bool swap = Field<std::int32_t>(head, 0, false) != 348;
  if (Field<std::int32_t>(head, 0, swap) != 348 || head.compare(344, 3, "n+1") != 0) refuse();
  Promise promise;
  const int dimensions = Field<std::int16_t>(head, 40, swap);
  if (dimensions < 1 || dimensions > 7) refuse();
  for (int a = 1; a <= dimensions; ++a) {
    promise.sizes.push_back(Field<std::int16_t>(head, 40 + 2 * static_cast<std::size_t>(a), swap));
  }
  // The library reads a spacing that is none as 1 mm and says nothing.
  for (std::size_t a = 1; a <= static_cast<std::size_t>(std::min(dimensions, 3)); ++a) {
    const float spacing = Field<float>(head, 76 + 4 * a, swap);
    if (!std::isfinite(spacing) || spacing <= 0) {
      throw Error(fmt::format("{}: the header's voxel spacing pixdim[{}] is {}; it must be a length in mm above 0",
                              path, a, spacing));
    }
  }
  promise.bytes_per_voxel = Field<std::int16_t>(head, 72, swap) / 8.0;
  const double offset = static_cast<double>(Field<float>(head, 108, swap));
  if (!(offset >= 348 && offset < 1e9)) refuse();
  promise.data_file = path;
  if (packed) {
    promise.packing = Packing::kGzip;
    promise.lead = offset;  // the stream holds the header too
  } else {
    promise.offset = static_cast<std::uint64_t>(offset);
  }
  return promise;
}

}  // namespace

bool HasImageExtension(const std::string& path) {
  const std::string lower = Lower(path);
  for (const char* end : {".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd"}) {
    if (EndsWith(lower, end)) return true;
  }
  return false;
}

std::uint64_t CheckImageHeader(const std::string& path) {
  const std::string lower = Lower(path);
  const std::string head = ReadHead(path);
  const Promise promise = EndsWith(lower, "nrrd") || EndsWith(lower, ".nhdr") ? ParseNrrd(path, head)
                          : EndsWith(lower, ".nii") || EndsWith(lower, ".gz") ? ParseNifti(path, head)
                                                                              : ParseMeta(path, head);
  if (promise.sizes.empty()) throw Error(fmt::format("{}: the header names no size", path));
  double voxels = 1;
  std::string shape;
  for (const double size : promise.sizes) {
    if (!(size >= 1) || size != std::floor(size)) {
      throw Error(fmt::format("{}: the header names a size of {} voxels", path, size));
    }
    voxels *= size;
    shape += (shape.empty() ? "" : " x ") + fmt::format("{}", size);
  }
  if (voxels > static_cast<double>(kMaxVoxels)) {
    throw Error(fmt::format(
        "{}: the header names {} voxels, more than the 2^31 that kerf reads; crop the scan or mend the header", path,
        shape));
  }
  std::error_code failed;
  const auto file_bytes = fs::file_size(promise.data_file, failed);
  if (failed)
    throw Error(fmt::format("{}: the voxels should be in {}, which can't be opened", path, promise.data_file));
  if (!(promise.bytes_per_voxel >= 1 && promise.bytes_per_voxel <= kMaxVoxelBytes)) {
    throw Error(fmt::format("{}: the header says that a voxel has {} bytes; kerf reads voxels of 1 to {}", path,
                            promise.bytes_per_voxel, kMaxVoxelBytes));
  }
  const double needed = voxels * promise.bytes_per_voxel;
  double there = static_cast<double>(file_bytes) - static_cast<double>(promise.offset);
  if (promise.packing != Packing::kRaw) there *= kMaxUnpackRatio;  // only a bound; of text or bzip2 the reader counts
  if (promise.packing == Packing::kGzip && there >= promise.lead + needed) {
    there = CountUnpackedBytes(promise.data_file, promise.offset, promise.lead + needed) - promise.lead;
  }
  if (there < needed) {
    throw Error(
        fmt::format("{}: the header promises {} voxels ({:.0f} bytes), but the file holds {:.0f} bytes of them; "
                    "it is cut off, or its header is wrong",
                    path, shape, needed, std::max(there, 0.0)));
  }
  return static_cast<std::uint64_t>(needed);
}

}  // namespace kerf
