#include "bone/import/vti.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/matrix.hpp>
#include <map>
#include <optional>
#include <utility>

#include "bone/import/image_fields.h"
#include "bone/import/patient_frame.h"
#include "bone/import/unpack.h"
#include "bone/import/voxel_values.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// A start tag of the XML text.
struct XmlTag {
  std::map<std::string, std::string> attributes;
  std::size_t end = 0;  // behind its '>'
  std::string Get(const std::string& name) const {
    const auto found = attributes.find(name);
    return found == attributes.end() ? "" : found->second;
  }
};

// Finds the tags with the name in text[from, to).
std::vector<XmlTag> FindTags(const std::string& text, const std::string& name, std::size_t from, std::size_t to) {
  std::vector<XmlTag> tags;
  for (std::size_t at = text.find("<" + name, from); at < to; at = text.find("<" + name, at + 1)) {
    std::size_t p = at + 1 + name.size();
    const std::size_t end = std::min(text.find('>', p), to);
    if (end >= to || (p < end && std::string(" \t\r\n/").find(text[p]) == std::string::npos)) continue;
    XmlTag tag;
    tag.end = end + 1;
    while (p < end) {
      const std::size_t equals = text.find('=', p);
      if (equals >= end) break;
      const std::size_t open = text.find_first_of("\"'", equals);
      if (open >= end) break;
      const std::size_t close = text.find(text[open], open + 1);
      if (close >= end) break;
      const std::size_t first = text.find_first_not_of(" \t\r\n", p);
      const std::size_t last = text.find_last_not_of(" \t\r\n", equals - 1);
      if (first < equals && last >= first) {
        tag.attributes[text.substr(first, last + 1 - first)] = text.substr(open + 1, close - open - 1);
      }
      p = close + 1;
    }
    tags.push_back(std::move(tag));
  }
  return tags;
}

// Finds the first one.
std::optional<XmlTag> FindTag(const std::string& text, const std::string& name, std::size_t from, std::size_t to) {
  const std::vector<XmlTag> tags = FindTags(text, name, from, to);
  return tags.empty() ? std::nullopt : std::optional(tags.front());
}

std::optional<VoxelType> FindVtkType(const std::string& name) {
  using enum VoxelType;
  static const std::map<std::string, VoxelType> kTypes = {
      {"Int8", kInt8},     {"UInt8", kUint8}, {"Int16", kInt16},   {"UInt16", kUint16}, {"Int32", kInt32},
      {"UInt32", kUint32}, {"Int64", kInt64}, {"UInt64", kUint64}, {"Float32", kFloat}, {"Float64", kDouble}};
  const auto known = kTypes.find(name);
  return known == kTypes.end() ? std::nullopt : std::optional(known->second);
}

// Reads numbers of an attribute; `otherwise` if it is absent.
std::vector<double> NumbersOf(const XmlTag& tag, const char* name, std::vector<double> otherwise,
                              const std::string& path) {
  if (tag.attributes.count(name) == 0) return otherwise;
  std::vector<double> numbers = ParseNumbers(tag.Get(name));
  if (numbers.size() == otherwise.size()) return numbers;
  throw Error(fmt::format("{}: the {} '{}' of the image has {} numbers instead of {}", path, name, tag.Get(name),
                          numbers.size(), otherwise.size()));
}

// The scalars of the points or of the cells.
struct VtiArray {
  XmlTag tag;
  bool of_cells = false;
};

VtiArray FindArray(const std::string& head, std::size_t from, std::size_t to, VtiHeader& header,
                   const std::string& path) {
  for (const char* kind : {"PointData", "CellData"}) {
    const std::optional<XmlTag> data = FindTag(head, kind, from, to);
    if (!data) continue;
    const std::size_t data_end = std::min(head.find("</" + std::string(kind), data->end), to);
    std::optional<XmlTag> chosen;
    std::size_t count = 0;
    for (const XmlTag& array : FindTags(head, "DataArray", data->end, data_end)) {
      const std::string components = array.Get("NumberOfComponents");
      if (!components.empty() && components != "1") continue;
      ++count;
      if (!chosen || array.Get("Name") == data->Get("Scalars")) chosen = array;
    }
    if (!chosen) continue;
    if (count > 1) {
      header.warnings.push_back(
          fmt::format("the file has {} arrays of values; '{}' was read", count, chosen->Get("Name")));
    }
    return {*chosen, kind[0] == 'C'};
  }
  throw Error(fmt::format("{}: the file has no array with one value for each point or cell", path));
}

void SetLattice(const XmlTag& image, bool of_cells, VtiHeader& header, const std::string& path) {
  const std::vector<double> extent = NumbersOf(image, "WholeExtent", std::vector<double>(6, 0), path);
  const std::vector<double> origin = NumbersOf(image, "Origin", {0, 0, 0}, path);
  const std::vector<double> spacing = NumbersOf(image, "Spacing", {0, 0, 0}, path);
  const std::vector<double> direction = NumbersOf(image, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1}, path);
  Vec3 first;
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    header.layout.sizes.push_back(extent[2 * a + 1] - extent[2 * a] + (of_cells ? 0 : 1));
    first[axis] = extent[2 * a] + (of_cells ? 0.5 : 0);
    if (!(spacing[a] > 0)) {
      throw Error(fmt::format("{}: the image's Spacing is '{}'; it must be three lengths in mm above 0", path,
                              image.Get("Spacing")));
    }
    for (std::size_t row = 0; row < 3; ++row) {
      header.steps[axis][static_cast<int>(row)] = direction[3 * row + a] * spacing[a];
    }
    const Vec3 column(direction[a], direction[3 + a], direction[6 + a]);
    if (std::abs(std::sqrt(glm::dot(column, column)) - 1) > 1e-3)
      throw Error(fmt::format("{}: the image's Direction '{}' has an axis whose length is not 1", path,
                              image.Get("Direction")));
  }
  header.origin = Vec3(origin[0], origin[1], origin[2]) + header.steps * first;
}

// Bytes of a file from a position on, as they are or in base64, in which each part may have its own padding.
class VtiBytes {
 public:
  explicit VtiBytes(const ImageLayout& layout) : in_(OpenImageFile(layout.data_file)), base64_(layout.base64) {
    in_.seekg(static_cast<std::streamoff>(layout.offset));
  }
  // Appends up to `count` bytes.
  void Read(std::size_t count, std::string& to) {
    while (count > 0 && !base64_) {
      const std::size_t part = std::min(count, kPart), was = to.size();
      to.resize(was + part);
      in_.read(&to[was], static_cast<std::streamsize>(part));
      to.resize(was + static_cast<std::size_t>(in_.gcount()));
      if (static_cast<std::size_t>(in_.gcount()) < part) return;
      count -= part;
    }
    while (count > 0) {
      if (at_ == quad_.size() && !ReadQuad()) return;
      const std::size_t part = std::min(count, quad_.size() - at_);
      to.append(quad_, at_, part);
      at_ += part;
      count -= part;
    }
  }

 private:
  bool ReadQuad() {
    unsigned bits = 0;
    int characters = 0, bytes = 3;
    while (characters < 4) {
      const int c = in_.get();
      if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
      const int value = ValueOf(c);
      if (c == '=') --bytes;
      if (value < 0 && c != '=') return false;
      bits = bits << 6 | static_cast<unsigned>(std::max(value, 0));
      ++characters;
    }
    if (bytes < 1) return false;
    quad_.clear();
    for (int n = 0; n < bytes; ++n) quad_ += static_cast<char>(bits >> (16 - 8 * n) & 0xff);
    at_ = 0;
    return true;
  }
  static int ValueOf(int c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  }
  static constexpr std::size_t kPart = 1 << 20;
  std::ifstream in_;
  bool base64_;
  std::string quad_;
  std::size_t at_ = 0;
};

[[noreturn]] void RefuseValues(const std::string& path) {
  throw Error(fmt::format("{}: the values are cut off or damaged; copy or export the file again", path));
}

// Reads a number of the header before the values.
std::uint64_t ReadCount(VtiBytes& in, const ImageLayout& layout, const std::string& path) {
  std::string bytes;
  const std::size_t size = layout.wide_counts ? 8 : 4;
  in.Read(size, bytes);
  if (bytes.size() != size) RefuseValues(path);
  if (layout.swapped) std::reverse(bytes.begin(), bytes.end());
  std::uint64_t count = 0;
  std::memcpy(&count, bytes.data(), size);
  return count;
}

}  // namespace

bool IsVtiPath(const std::string& path) {
  return EndsWith(Lower(path), ".vti");
}

VtiHeader ReadVtiHeader(const std::string& path) {
  const std::string head = ReadHead(path);
  const std::size_t appended = head.find("<AppendedData");
  const std::size_t to = std::min(appended, head.size());
  const std::optional<XmlTag> file = FindTag(head, "VTKFile", 0, to);
  const std::optional<XmlTag> image = file ? FindTag(head, "ImageData", file->end, to) : std::nullopt;
  if (!image) throw Error(fmt::format("{}: not a VTK image (.vti) despite its name", path));
  const std::optional<XmlTag> piece = FindTag(head, "Piece", image->end, to);
  if (!piece || FindTag(head, "Piece", piece->end, to) ||
      ParseNumbers(piece->Get("Extent")) != ParseNumbers(image->Get("WholeExtent"))) {
    throw Error(fmt::format("{}: the image is not in one piece; export it as one", path));
  }
  VtiHeader header;
  const VtiArray array = FindArray(head, piece->end, to, header, path);
  SetLattice(*image, array.of_cells, header, path);
  ImageLayout& layout = header.layout;
  layout.data_file = path;
  const std::optional<VoxelType> type = FindVtkType(array.tag.Get("type"));
  if (!type) throw Error(fmt::format("{}: voxels of type '{}' are not supported", path, array.tag.Get("type")));
  layout.type = *type;
  layout.bytes_per_voxel = static_cast<double>(CalcBytes(*type));
  layout.swapped = file->Get("byte_order") == "BigEndian";
  layout.wide_counts = file->Get("header_type") == "UInt64";
  const std::string compressor = file->Get("compressor");
  layout.zlib_blocks = compressor == "vtkZLibDataCompressor";
  if (!compressor.empty() && !layout.zlib_blocks) {
    throw Error(
        fmt::format("{}: the values are compressed by {}; kerf reads vtkZLibDataCompressor or none", path, compressor));
  }
  const std::string format = array.tag.Get("format");
  layout.offset = array.tag.end;
  layout.packing = format == "ascii" ? VoxelPacking::kText : VoxelPacking::kVti;
  layout.base64 = true;
  if (format == "appended") {
    const std::optional<XmlTag> data = FindTag(head, "AppendedData", to, head.size());
    const std::size_t begin = data ? head.find('_', data->end) : std::string::npos;
    const std::vector<double> offset = ParseNumbers(array.tag.Get("offset"));
    if (begin == std::string::npos || offset.size() != 1 || !(offset[0] >= 0 && offset[0] < 1e15)) {
      throw Error(fmt::format("{}: the place of the appended values is not given", path));
    }
    layout.offset = begin + 1 + static_cast<std::uint64_t>(offset[0]);
    layout.base64 = data->Get("encoding") == "base64";
    if (!layout.base64 && !layout.zlib_blocks) {
      layout.packing = VoxelPacking::kRaw;
      layout.offset += layout.wide_counts ? 8 : 4;
    }
  } else if (format != "ascii" && format != "binary") {
    throw Error(fmt::format("{}: values in the format '{}' are not supported", path, format));
  }
  return header;
}

std::vector<char> ReadVtiValues(const ImageLayout& layout, std::size_t bytes, const std::string& path) {
  VtiBytes in(layout);
  std::vector<char> values;
  if (!layout.zlib_blocks) {
    if (ReadCount(in, layout, path) < bytes) RefuseValues(path);
    std::string text;
    in.Read(bytes, text);
    if (text.size() != bytes) RefuseValues(path);
    return {text.begin(), text.end()};
  }
  std::error_code failed;
  const std::uint64_t file_bytes = std::filesystem::file_size(layout.data_file, failed);
  const std::uint64_t blocks = ReadCount(in, layout, path);
  const std::uint64_t block_bytes = ReadCount(in, layout, path);
  const std::uint64_t last_bytes = ReadCount(in, layout, path);
  if (failed || blocks == 0 || blocks > file_bytes || block_bytes == 0 || last_bytes > block_bytes) RefuseValues(path);
  std::vector<std::uint64_t> packed_bytes;
  for (std::uint64_t n = 0; n < blocks; ++n) {
    packed_bytes.push_back(ReadCount(in, layout, path));
    if (packed_bytes.back() > file_bytes) RefuseValues(path);
  }
  for (std::uint64_t n = 0; n < blocks && values.size() < bytes; ++n) {
    const std::uint64_t stated = n + 1 == blocks && last_bytes > 0 ? last_bytes : block_bytes;
    if (stated > bytes - values.size()) RefuseValues(path);
    std::string packed;
    in.Read(packed_bytes[n], packed);
    std::vector<char> block(stated);
    auto size = static_cast<uLongf>(stated);
    const int state = uncompress(reinterpret_cast<Bytef*>(block.data()), &size,
                                 reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
    if (state != Z_OK || size != stated) RefuseValues(path);
    values.insert(values.end(), block.begin(), block.end());
  }
  if (values.size() != bytes) RefuseValues(path);
  return values;
}

Volume ReadVti(const std::string& path, const std::string& frame, double scale, std::int16_t blank) {
  VtiHeader header = ReadVtiHeader(path);
  Volume volume;
  volume.frame = frame.empty() ? "LPS" : frame;
  volume.warnings = std::move(header.warnings);
  if (frame.empty()) {
    volume.warnings.emplace_back(
        "a .vti does not say how the scan lies in the patient; its coordinates were taken as LPS (left, back, head); "
        "check that left is left, and set them with --frame");
  }
  for (std::size_t a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(header.layout.sizes[a]);
  PlaceLattice(header.origin, header.steps, 1, volume);
  CheckLattice(volume, path);
  const std::vector<char> values = ReadVoxels(header.layout, volume.count(), path);
  const Overflow overflow = AppendHu(values, header.layout.type, scale, 0, volume.hu, blank);
  volume.padding = overflow.is_blank;
  volume.exact = overflow.count == 0 && !overflow.rounded;
  AddWarnings(overflow, volume.count(), blank, volume.warnings);
  return volume;
}

}  // namespace kerf
