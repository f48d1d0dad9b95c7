#include "bone/import/image_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/core/number_text.h"
#include "bone/import/image_fields.h"
#include "bone/import/limits.h"
#include "bone/import/nifti.h"
#include "bone/import/unpack.h"
#include "bone/import/vti.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

// Returns the voxel type for the name of an NRRD type; empty if it is not supported.
std::optional<VoxelType> FindNrrdType(const std::string& name) {
  using enum VoxelType;
  static const std::map<std::string, VoxelType> kTypes = {{"signed char", kInt8},
                                                          {"int8", kInt8},
                                                          {"int8_t", kInt8},
                                                          {"uchar", kUint8},
                                                          {"unsigned char", kUint8},
                                                          {"uint8", kUint8},
                                                          {"uint8_t", kUint8},
                                                          {"short", kInt16},
                                                          {"short int", kInt16},
                                                          {"signed short", kInt16},
                                                          {"signed short int", kInt16},
                                                          {"int16", kInt16},
                                                          {"int16_t", kInt16},
                                                          {"ushort", kUint16},
                                                          {"unsigned short", kUint16},
                                                          {"unsigned short int", kUint16},
                                                          {"uint16", kUint16},
                                                          {"uint16_t", kUint16},
                                                          {"int", kInt32},
                                                          {"signed int", kInt32},
                                                          {"int32", kInt32},
                                                          {"int32_t", kInt32},
                                                          {"uint", kUint32},
                                                          {"unsigned int", kUint32},
                                                          {"uint32", kUint32},
                                                          {"uint32_t", kUint32},
                                                          {"float", kFloat},
                                                          {"double", kDouble},
                                                          {"longlong", kInt64},
                                                          {"long long", kInt64},
                                                          {"long long int", kInt64},
                                                          {"int64", kInt64},
                                                          {"int64_t", kInt64},
                                                          {"ulonglong", kUint64},
                                                          {"unsigned long long", kUint64},
                                                          {"unsigned long long int", kUint64},
                                                          {"uint64", kUint64},
                                                          {"uint64_t", kUint64}};
  const auto known = kTypes.find(name);
  return known == kTypes.end() ? std::nullopt : std::optional(known->second);
}

// Returns the voxel type for the name of a MetaImage type. MET_LONG has four bytes on every machine.
std::optional<VoxelType> FindMetaType(const std::string& name) {
  using enum VoxelType;
  static const std::map<std::string, VoxelType> kTypes = {
      {"MET_CHAR", kInt8},       {"MET_UCHAR", kUint8},       {"MET_SHORT", kInt16}, {"MET_USHORT", kUint16},
      {"MET_INT", kInt32},       {"MET_UINT", kUint32},       {"MET_LONG", kInt32},  {"MET_ULONG", kUint32},
      {"MET_LONG_LONG", kInt64}, {"MET_ULONG_LONG", kUint64}, {"MET_FLOAT", kFloat}, {"MET_DOUBLE", kDouble}};
  const auto known = kTypes.find(name);
  return known == kTypes.end() ? std::nullopt : std::optional(known->second);
}

bool IsStream(const ImageLayout& layout) {
  return layout.packing == VoxelPacking::kGzip || layout.packing == VoxelPacking::kBzip2;
}

void SetType(const std::optional<VoxelType>& type, const std::string& name, const std::string& path,
             ImageLayout& layout) {
  if (!type) throw Error(fmt::format("{}: voxels of type '{}' are not supported", path, name));
  layout.type = *type;
  layout.bytes_per_voxel = static_cast<double>(CalcBytes(*type)) * layout.components;
}

void CheckDimensions(const std::string& text, const char* field, const char* sizes_field, const ImageLayout& layout,
                     const std::string& path) {
  const std::vector<double> dimensions = ParseNumbers(text);
  if (dimensions.size() == 1 && dimensions[0] == static_cast<double>(layout.sizes.size())) return;
  throw Error(fmt::format("{}: the header gives {} dimensions in {} and {} sizes in {}", path,
                          text.empty() ? "no" : text, field, layout.sizes.size(), sizes_field));
}

// Returns a count of bytes or lines from the header; 0 if it is absent, -1 if the data are at the end of the file.
double ParseSkip(const ImageFields& fields, const char* field, const char* name, const std::string& path) {
  if (!fields.Contains(field)) return 0;
  const std::vector<double> number = ParseNumbers(fields.Get(field));
  if (number.size() == 1 && number[0] >= -1 && number[0] < 1e15 && number[0] == std::floor(number[0])) return number[0];
  throw Error(fmt::format("{}: the header's {} is '{}'; it must be a whole number of at least -1", path, name,
                          fields.Get(field)));
}

std::uint64_t SkipLines(const std::string& path, std::uint64_t offset, double lines) {
  if (lines < 0) throw Error(fmt::format("{}: the NRRD header's 'line skip' is {}, below 0", path, lines));
  std::ifstream in = OpenImageFile(path);
  in.seekg(static_cast<std::streamoff>(offset));
  for (double n = 0; n < lines && in; ++n) {
    in.ignore(kMaxSkippedLine + 1, '\n');
    if (in.gcount() > kMaxSkippedLine) {
      throw Error(
          fmt::format("{}: a line skipped by the header's 'line skip' is longer than the {} bytes that kerf reads",
                      path, kMaxSkippedLine));
    }
  }
  if (!in) throw Error(fmt::format("{}: the file has fewer lines than the header's 'line skip' requires", path));
  return static_cast<std::uint64_t>(in.tellg());
}

void TakeDataFiles(const ImageFields& fields, const std::string& data_file, const std::string& path,
                   ImageLayout& layout) {
  layout.data_files = ListDataFiles(data_file, fields.files, layout.sizes, path);
  if (!layout.data_files.empty()) layout.data_file = layout.data_files.front();
}

void SetNrrdPacking(const ImageFields& fields, const std::string& path, ImageLayout& layout) {
  layout.encoding = Lower(fields.Get("encoding"));
  if (layout.encoding.empty()) throw Error(fmt::format("{}: the NRRD header does not name an encoding", path));
  if (layout.encoding == "gzip" || layout.encoding == "gz") {
    layout.packing = VoxelPacking::kGzip;
  } else if (layout.encoding == "bzip2" || layout.encoding == "bz2") {
    layout.packing = VoxelPacking::kBzip2;
  } else if (layout.encoding == "text" || layout.encoding == "txt" || layout.encoding == "ascii") {
    layout.packing = VoxelPacking::kText;
  } else if (layout.encoding != "raw") {
    layout.packing = VoxelPacking::kUnknown;
  }
  const double lines = ParseSkip(fields, "lineskip", "'line skip'", path);
  if (lines != 0 && !layout.data_files.empty()) {
    throw Error(fmt::format("{}: the NRRD header's 'line skip' is not supported for several data files", path));
  }
  if (lines != 0) layout.offset = SkipLines(layout.data_file, layout.offset, lines);
  const double bytes = ParseSkip(fields, "byteskip", "'byte skip'", path);
  layout.at_end = bytes < 0;
  if (layout.at_end && layout.packing != VoxelPacking::kRaw) {
    throw Error(fmt::format("{}: the NRRD header's 'byte skip: -1' is for raw voxels, and these are {}", path,
                            layout.encoding));
  }
  // The bytes to skip are those of the unpacked stream.
  if (IsStream(layout)) {
    layout.lead = bytes;
  } else if (!layout.at_end) {
    layout.offset += static_cast<std::uint64_t>(bytes);
  }
}

ImageLayout ParseNrrd(const std::string& path, const std::string& head) {
  if (head.compare(0, 4, "NRRD") != 0) throw Error(fmt::format("{}: not an NRRD file despite its name", path));
  const ImageFields fields = ParseNrrdFields(head);
  ImageLayout layout;
  layout.data_file = path;
  layout.sizes = ParseNumbers(fields.Get("sizes"));
  CheckDimensions(fields.Get("dimension"), "'dimension'", "'sizes'", layout, path);
  const std::string data_file = fields.Get("datafile");
  if (!data_file.empty()) {
    layout.data_file = (fs::path(path).parent_path() / data_file).string();
    TakeDataFiles(fields, data_file, path, layout);
  } else {
    if (!fields.complete) throw Error(fmt::format("{}: the NRRD header has no end (an empty line)", path));
    layout.offset = fields.end;
  }
  SetNrrdPacking(fields, path, layout);
  const std::string type = Lower(fields.Get("type"));
  SetType(FindNrrdType(type), type, path, layout);
  const std::string endian = Lower(fields.Get("endian"));
  const bool needs_order = layout.bytes_per_voxel > 1 && layout.packing != VoxelPacking::kText;
  if (needs_order && endian != "little" && endian != "big") {
    throw Error(
        fmt::format("{}: the NRRD header does not give the byte order of its voxels as 'endian: little' or "
                    "'endian: big'{}",
                    path, endian.empty() ? "" : fmt::format(", but as '{}'", fields.Get("endian"))));
  }
  layout.swapped = endian == "big";
  return layout;
}

bool IsTrue(const ImageFields& fields, const char* name, bool otherwise) {
  const std::string value = Lower(fields.Get(name));
  return value.empty() ? otherwise : value[0] == 't' || value[0] == '1';
}

// HeaderSize counts from the beginning of the file that holds the voxels, local or not.
void SetMetaPacking(const ImageFields& fields, const std::string& path, bool local, ImageLayout& layout) {
  if (!IsTrue(fields, "binarydata", true)) {
    layout.packing = VoxelPacking::kText;
  } else if (IsTrue(fields, "compresseddata", false)) {
    layout.packing = VoxelPacking::kGzip;
  }
  layout.swapped = IsTrue(fields, "elementbyteordermsb", IsTrue(fields, "binarydatabyteordermsb", false));
  layout.offset = local ? fields.end : 0;
  const double header_bytes = ParseSkip(fields, "headersize", "HeaderSize", path);
  layout.at_end = header_bytes < 0;
  if (layout.at_end && layout.packing != VoxelPacking::kRaw) {
    throw Error(
        fmt::format("{}: the MetaImage header's HeaderSize of -1 is for voxels that are neither compressed nor "
                    "text",
                    path));
  }
  if (header_bytes <= 0) return;
  if (header_bytes < static_cast<double>(layout.offset)) {
    throw Error(fmt::format("{}: the MetaImage header's HeaderSize is {:.0f}, but the header itself has {} bytes", path,
                            header_bytes, layout.offset));
  }
  layout.offset = static_cast<std::uint64_t>(header_bytes);
}

ImageLayout ParseMeta(const std::string& path, const std::string& head) {
  const ImageFields fields = ParseMetaFields(head);
  if (!fields.complete) throw Error(fmt::format("{}: not a MetaImage file despite its name", path));
  ImageLayout layout;
  layout.sizes = ParseNumbers(fields.Get("dimsize"));
  CheckDimensions(fields.Get("ndims"), "NDims", "DimSize", layout, path);
  const std::vector<double> channels = ParseNumbers(fields.Get("elementnumberofchannels"));
  if (!channels.empty()) layout.components = channels[0];
  const std::string data_file = fields.Get("elementdatafile");
  const bool local = Lower(data_file) == "local";
  layout.data_file = local ? path : (fs::path(path).parent_path() / data_file).string();
  if (!local) TakeDataFiles(fields, data_file, path, layout);
  SetMetaPacking(fields, path, local, layout);
  const std::string type = fields.Contains("elementtype") ? fields.Get("elementtype") : "?";
  SetType(FindMetaType(type), type, path, layout);
  return layout;
}

ImageLayout ParseNifti(const std::string& path) {
  const NiftiHeader header = ReadNiftiHeader(path);
  ImageLayout layout;
  layout.data_file = header.data_file;
  layout.sizes = header.sizes;
  layout.bytes_per_voxel = header.bits / 8.0;
  if (IsGzip(header.data_file)) {
    layout.packing = VoxelPacking::kGzip;
    layout.lead = header.offset;  // the stream also contains the header
  } else {
    layout.offset = static_cast<std::uint64_t>(header.offset);
  }
  return layout;
}

// Returns an upper bound of the number of bytes of voxels that the file holds; exact for raw voxels.
double BoundBytes(const ImageLayout& layout, double file_bytes) {
  const double available = file_bytes - static_cast<double>(layout.offset);
  return layout.packing == VoxelPacking::kRaw     ? available
         : layout.packing == VoxelPacking::kBzip2 ? available * kMaxBzip2Ratio
                                                  : available * kMaxUnpackRatio;
}

// Throws kerf::Error if reading the image would take more memory than its content and its file justify: a few
// megabytes can unpack to gigabytes.
void CheckMemory(const ImageLayout& layout, double voxels, double file_bytes, ImageContent content,
                 const std::string& path) {
  const bool labels = content == ImageContent::kLabels;
  if (!labels && !IsStream(layout) && layout.packing != VoxelPacking::kVti) return;
  const double bytes = voxels * (layout.bytes_per_voxel + sizeof(std::int16_t) * layout.components);
  const double limit = labels ? kMaxUnpackedBytes : std::max(kMaxUnpackedBytes, kMaxMemoryRatio * file_bytes);
  if (bytes <= limit) return;
  throw Error(
      fmt::format("{}: the {} has {:.0f} values, which take {:.1f} GiB of memory; kerf reads up to {:.3g} GiB{}; {}",
                  path, labels ? "label map" : "compressed image", voxels * layout.components, bytes / (1 << 30),
                  limit / (1 << 30), labels ? "" : " from a compressed file of this size",
                  labels ? "crop it to the bone, or resample it" : "crop it to the bone, or save it uncompressed"));
}

// Returns the number of bytes of voxels that a compressed stream holds.
double CountUnpacked(const ImageLayout& layout, double needed, const std::string& path) {
  // Twice the stated bytes are enough to detect that the header gives too few slices.
  const Unpacked unpacked = UnpackStream(layout, layout.lead + 2 * needed);
  const double voxels = std::max(unpacked.bytes - layout.lead, 0.0);
  if (unpacked.damaged || (unpacked.cut_off && voxels >= needed)) {
    throw Error(fmt::format("{}: the compressed voxels are damaged: {}; copy or export the file again", path,
                            voxels < needed ? fmt::format("only {:.0f} of {:.0f} bytes can be unpacked", voxels, needed)
                            : unpacked.damaged ? std::string("they do not match their checksum")
                                               : std::string("the end of their stream is missing")));
  }
  return unpacked.bytes - layout.lead;
}

}  // namespace

bool HasNiftiExtension(const std::string& path) {
  const std::string lower = Lower(path);
  return std::any_of(kNiftiExtensions.begin(), kNiftiExtensions.end(),
                     [&](const char* end) { return EndsWith(lower, end); });
}

bool HasImageExtension(const std::string& path) {
  const std::string lower = Lower(path);
  return HasNiftiExtension(path) || std::any_of(kOtherImageExtensions.begin(), kOtherImageExtensions.end(),
                                                [&](const char* end) { return EndsWith(lower, end); });
}

std::string ListImageExtensions() {
  std::string list;
  for (const char* end : kOtherImageExtensions) list += std::string(end) + " ";
  for (const char* end : kNiftiExtensions) list += std::string(end) + " ";
  list.pop_back();
  return list;
}

namespace {

// Returns the number of voxels that the header states, as a number and as "a x b x c".
std::pair<double, std::string> CountVoxels(const ImageLayout& layout, const std::string& path) {
  if (layout.sizes.empty()) throw Error(fmt::format("{}: the header gives no size", path));
  double voxels = 1;
  std::string shape;
  for (const double size : layout.sizes) {
    if (!(size >= 1) || size != std::floor(size)) {
      throw Error(fmt::format("{}: the header gives a size of {} voxels", path, size));
    }
    voxels *= size;
    shape += (shape.empty() ? "" : " x ") + fmt::format("{}", size);
  }
  if (voxels > static_cast<double>(kMaxVoxels)) {
    throw Error(fmt::format(
        "{}: the header gives {} voxels, more than the 2^31 that kerf reads; crop the scan or correct the header", path,
        shape));
  }
  return {voxels, shape};
}

}  // namespace

Unpacked UnpackStream(const ImageLayout& layout, double max_bytes, double skip, std::vector<char>* out) {
  return layout.packing == VoxelPacking::kBzip2 ? UnpackBzip2(layout.data_file, layout.offset, max_bytes, skip, out)
                                                : Unpack(layout.data_file, layout.offset, max_bytes, skip, out);
}

namespace {

// Checks that the layout's data file holds `voxels` voxels, described by `shape`. Sets its offset if they are at the
// end. Returns the number of slices of `slice_bytes` beyond them.
double CheckDataFile(ImageLayout& layout, double voxels, const std::string& shape, double slice_bytes,
                     ImageContent content, const std::string& path) {
  std::error_code failed;
  const auto file_bytes = static_cast<double>(fs::file_size(layout.data_file, failed));
  if (failed) {
    throw Error(fmt::format("{}: the voxels should be in {}, which can't be opened", path, layout.data_file));
  }
  const double needed = voxels * layout.bytes_per_voxel;
  double available = BoundBytes(layout, file_bytes);
  if (available >= layout.lead + needed) {
    CheckMemory(layout, voxels, file_bytes, content, path);
    if (IsStream(layout)) available = CountUnpacked(layout, needed, path);
  }
  if (available < needed) {
    throw Error(fmt::format(
        "{}: the header states {} voxels ({:.0f} bytes){}, but the file contains {:.0f} bytes of them; "
        "it is cut off, or its header is wrong",
        path, shape, needed, layout.data_files.empty() ? "" : " in " + layout.data_file, std::max(available, 0.0)));
  }
  if (layout.at_end) {
    layout.offset = static_cast<std::uint64_t>(file_bytes - needed);
    return 0;
  }
  const bool is_counted = layout.packing == VoxelPacking::kRaw || IsStream(layout);
  return is_counted ? std::floor((available - needed) / slice_bytes) : 0;
}

}  // namespace

ImageCheck CheckImageHeader(const std::string& path, ImageContent content) {
  const std::string lower = Lower(path);
  const std::string head = ReadHead(path);
  ImageCheck check;
  ImageLayout& layout = check.layout;
  layout = EndsWith(lower, "nrrd") || EndsWith(lower, ".nhdr") ? ParseNrrd(path, head)
           : HasNiftiExtension(path)                           ? ParseNifti(path)
           : IsVtiPath(path)                                   ? ReadVtiHeader(path).layout
                                                               : ParseMeta(path, head);
  const auto [voxels, shape] = CountVoxels(layout, path);
  while (layout.sizes.size() > 3 && layout.sizes.back() == 1) layout.sizes.pop_back();
  if (!(layout.bytes_per_voxel >= 1 && layout.bytes_per_voxel <= kMaxVoxelBytes)) {
    throw Error(fmt::format("{}: the header states that a voxel has {} bytes; kerf reads voxels of 1 to {}", path,
                            layout.bytes_per_voxel, kMaxVoxelBytes));
  }
  const double slice_bytes = voxels * layout.bytes_per_voxel / layout.sizes.back();
  if (!layout.data_files.empty()) {
    const auto parts = static_cast<double>(layout.data_files.size());
    double all_bytes = 0;
    for (const std::string& file : layout.data_files) {
      std::error_code failed;
      const std::uintmax_t bytes = fs::file_size(file, failed);
      if (!failed) all_bytes += static_cast<double>(bytes);
    }
    CheckMemory(layout, voxels, all_bytes, content, path);
    for (const std::string& file : layout.data_files) {
      ImageLayout one = layout;
      one.data_file = file;
      CheckDataFile(one, voxels / parts, fmt::format("{:.0f}", voxels / parts), slice_bytes, content, path);
    }
    return check;
  }
  const double more_slices = CheckDataFile(layout, voxels, shape, slice_bytes, content, path);
  if (more_slices >= 1) {
    check.warnings.push_back(fmt::format("the header gives {} voxels, but the file contains {}{} more; {} left out",
                                         shape, layout.packing == VoxelPacking::kRaw ? "" : "at least ",
                                         FormatCount(static_cast<std::size_t>(more_slices), "slice", "slices"),
                                         more_slices == 1 ? "it was" : "they were"));
  }
  return check;
}

}  // namespace kerf
