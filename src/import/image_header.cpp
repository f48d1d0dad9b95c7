#include "import/image_header.h"

#include <fmt/format.h>
#include <itk_zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "import/image_fields.h"
#include "import/limits.h"
#include "import/nifti.h"
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
  bool exact = true;         // offset is the first voxel's, so that what follows the voxels can be counted
};

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
      // A gzip file may have several members, one after the other.
      if (state == Z_STREAM_END && z.avail_in > 0) state = inflateReset(&z);
    } while (state == Z_OK && (z.avail_out == 0 || z.avail_in > 0) && total < enough);
  }
  inflateEnd(&z);
  return total;
}

// Bytes of an NRRD's types.
double NrrdTypeBytes(const std::string& type) {
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
  const auto known = kTypes.find(type);
  return known == kTypes.end() ? 0 : known->second;
}

Promise ParseNrrd(const std::string& path, const std::string& head) {
  if (head.compare(0, 4, "NRRD") != 0) throw Error(fmt::format("{}: not an NRRD file although its name says so", path));
  const ImageFields fields = ParseNrrdFields(head);
  Promise promise;
  promise.data_file = path;
  promise.sizes = ParseNumbers(fields.Get("sizes"));
  const std::string encoding = Lower(fields.Get("encoding"));
  if (encoding == "gzip" || encoding == "gz") {
    promise.packing = Packing::kGzip;
  } else if (encoding != "raw" && !encoding.empty()) {
    promise.packing = Packing::kOther;
  }
  const std::string data_file = fields.Get("datafile");
  if (!data_file.empty()) {
    if (Lower(data_file).compare(0, 4, "list") == 0 || data_file.find('%') != std::string::npos) {
      throw Error(fmt::format("{}: the voxels are spread over several files; kerf reads NRRD with one", path));
    }
    promise.data_file = (fs::path(path).parent_path() / data_file).string();
  } else {
    if (!fields.complete) throw Error(fmt::format("{}: the NRRD header has no end (an empty line)", path));
    promise.offset = fields.end;
  }
  promise.exact = !fields.Contains("lineskip") && !fields.Contains("byteskip");
  const std::string type = Lower(fields.Get("type"));
  promise.bytes_per_voxel = NrrdTypeBytes(type);
  if (promise.bytes_per_voxel == 0) throw Error(fmt::format("{}: voxels of type '{}' are not read", path, type));
  return promise;
}

Promise ParseMeta(const std::string& path, const std::string& head) {
  static const std::map<std::string, double> kTypes = {{"MET_CHAR", 1},       {"MET_UCHAR", 1}, {"MET_SHORT", 2},
                                                       {"MET_USHORT", 2},     {"MET_INT", 4},   {"MET_UINT", 4},
                                                       {"MET_LONG", 8},       {"MET_ULONG", 8}, {"MET_LONG_LONG", 8},
                                                       {"MET_ULONG_LONG", 8}, {"MET_FLOAT", 4}, {"MET_DOUBLE", 8}};
  const ImageFields fields = ParseMetaFields(head);
  if (!fields.complete) throw Error(fmt::format("{}: not a MetaImage file although its name says so", path));
  Promise promise;
  promise.sizes = ParseNumbers(fields.Get("dimsize"));
  // ITK would count up to a negative or huge number of dimensions.
  const std::vector<double> dimensions = ParseNumbers(fields.Get("ndims"));
  if (dimensions.size() != 1 || dimensions[0] != static_cast<double>(promise.sizes.size())) {
    throw Error(fmt::format("{}: the header names {} dimensions by NDims and {} sizes by DimSize", path,
                            fields.Contains("ndims") ? fields.Get("ndims") : "no", promise.sizes.size()));
  }
  const std::vector<double> channels = ParseNumbers(fields.Get("elementnumberofchannels"));
  const std::string data_file = fields.Get("elementdatafile");
  const bool local = Lower(data_file) == "local";
  if (!local && (Lower(data_file).compare(0, 4, "list") == 0 || data_file.find('%') != std::string::npos)) {
    throw Error(fmt::format("{}: the voxels are spread over several files; kerf reads MetaImage with one", path));
  }
  promise.data_file = local ? path : (fs::path(path).parent_path() / data_file).string();
  promise.offset = local ? fields.end : 0;
  promise.exact = !fields.Contains("headersize");
  if (Lower(fields.Get("compresseddata")) == "true") promise.packing = Packing::kGzip;
  if (Lower(fields.Get("binarydata")) == "false") promise.packing = Packing::kOther;
  const std::string type = fields.Contains("elementtype") ? fields.Get("elementtype") : "?";
  const auto known = kTypes.find(type);
  if (known == kTypes.end()) throw Error(fmt::format("{}: voxels of type '{}' are not read", path, type));
  promise.bytes_per_voxel = known->second * (channels.empty() ? 1 : channels[0]);
  return promise;
}

Promise ParseNifti(const std::string& path, const std::string& head) {
  const NiftiHeader header = ReadNiftiHeader(path);
  Promise promise;
  promise.data_file = path;
  promise.sizes = header.sizes;
  promise.bytes_per_voxel = header.bits / 8.0;
  if (head.compare(0, 2, "\x1f\x8b") == 0) {
    promise.packing = Packing::kGzip;
    promise.lead = header.offset;  // the stream holds the header too
  } else {
    promise.offset = static_cast<std::uint64_t>(header.offset);
  }
  return promise;
}

// Bytes of voxels that the file holds; those of text or bzip2 are only bounded from above, the reader counts them.
double CountBytes(const Promise& promise, double file_bytes, double needed) {
  const double there = file_bytes - static_cast<double>(promise.offset);
  if (promise.packing == Packing::kRaw) return there;
  const double bound = there * kMaxUnpackRatio;
  if (promise.packing == Packing::kOther || bound < promise.lead + needed) return bound;
  // Twice what the header names is enough to see that it names too few slices.
  return CountUnpackedBytes(promise.data_file, promise.offset, promise.lead + 2 * needed) - promise.lead;
}

}  // namespace

bool HasNiftiExtension(const std::string& path) {
  const std::string lower = Lower(path);
  return EndsWith(lower, ".nii") || EndsWith(lower, ".nii.gz");
}

bool HasImageExtension(const std::string& path) {
  const std::string lower = Lower(path);
  for (const char* end : {".nrrd", ".nhdr", ".mha", ".mhd"}) {
    if (EndsWith(lower, end)) return true;
  }
  return HasNiftiExtension(path);
}

ImageCheck CheckImageHeader(const std::string& path) {
  const std::string lower = Lower(path);
  const std::string head = ReadHead(path);
  const Promise promise = EndsWith(lower, "nrrd") || EndsWith(lower, ".nhdr") ? ParseNrrd(path, head)
                          : HasNiftiExtension(path)                           ? ParseNifti(path, head)
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
        "{}: the header names {} voxels, more than the 2^31 that kerf reads; crop the scan or correct the header", path,
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
  const double there = CountBytes(promise, static_cast<double>(file_bytes), needed);
  if (there < needed) {
    throw Error(
        fmt::format("{}: the header promises {} voxels ({:.0f} bytes), but the file holds {:.0f} bytes of them; "
                    "it is cut off, or its header is wrong",
                    path, shape, needed, std::max(there, 0.0)));
  }
  ImageCheck check;
  check.bytes = static_cast<std::uint64_t>(needed);
  const double more_slices = std::floor((there - needed) / (needed / promise.sizes.back()));
  if (promise.exact && promise.packing != Packing::kOther && more_slices >= 1) {
    check.warnings.push_back(
        fmt::format("the header names {} voxels, but the file holds {} {:.0f} slices more; they were left out", shape,
                    promise.packing == Packing::kRaw ? "data of" : "data of at least", more_slices));
  }
  return check;
}

}  // namespace kerf
