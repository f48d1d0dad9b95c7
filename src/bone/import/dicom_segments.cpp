#include "bone/import/dicom_segments.h"

#include <fmt/format.h>
#include <gdcmReader.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "base/files/child.h"
#include "bone/import/dicom_elements.h"
#include "bone/import/dicom_header.h"
#include "bone/import/limits.h"
#include "bone/import/unpack.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

// Memory of the child: GDCM allocates what a length states, also if the file is shorter.
constexpr std::uint64_t kMaxMemory = std::uint64_t{5} << 30;
constexpr std::uint64_t kLeastMemory = std::uint64_t{512} << 20;
constexpr std::uint64_t kMemoryPerByte = 64;  // of the file: elements of a few bytes take a hundred
constexpr double kSilent_s = 120;
constexpr std::uint64_t kMaxBytes = std::uint64_t{2} << 30;
constexpr std::size_t kMaxHeaderBytes = std::size_t{256} << 20;
constexpr double kHalf = 0.5;  // of the range of a fraction

// Reads one data set and the sequences in it.
class Reading {
 public:
  explicit Reading(const gdcm::DataSet& data, std::string path) : data_(data), path_(std::move(path)) {}

  Json Read() {
    Json json;
    const std::string type = ReadText(data_, 0x0062, 0x0001);
    if (type != "BINARY" && type != "FRACTIONAL") {
      throw Error(fmt::format("{}: a segmentation of type '{}', which kerf doesn't read", path_, type));
    }
    json["fraction"] = type == "FRACTIONAL" ? ReadShort(data_, 0x0062, 0x000e) : 0;
    if (type == "FRACTIONAL" && json["fraction"] == 0) {
      throw Error(fmt::format("{}: the segmentation's maximum fractional value is missing or 0", path_));
    }
    json["bits"] = ReadShort(data_, 0x0028, 0x0100);
    json["size"] = {ReadShort(data_, 0x0028, 0x0011), ReadShort(data_, 0x0028, 0x0010)};
    for (const gdcm::DataSet* series : List(data_, 0x0008, 0x1115)) json["series"] = ReadText(*series, 0x0020, 0x000e);
    json["segments"] = Json::array();
    for (const gdcm::DataSet* segment : List(data_, 0x0062, 0x0002)) json["segments"].push_back(ReadSegment(*segment));
    ReadShared(json);
    ReadFrames(json);
    const std::vector<double> stated = ReadNumbers(data_, 0x0028, 0x0008);
    if (!stated.empty() && stated[0] != static_cast<double>(json["frames"].size())) {
      throw Error(fmt::format("{}: the segmentation states {} frames, but describes {}", path_, stated[0],
                              json["frames"].size()));
    }
    return json;
  }

 private:
  std::vector<const gdcm::DataSet*> List(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
    return ReadItems(data, group, element, kept_);
  }
  Json Codes(const gdcm::DataSet& data, std::uint16_t element) {
    Json codes = Json::array();
    for (const gdcm::DataSet* code : List(data, 0x0062, element)) {
      if (ReadText(*code, 0x0008, 0x0102) == "SCT") codes.push_back(ReadText(*code, 0x0008, 0x0100));
    }
    return codes;
  }
  Json ReadSegment(const gdcm::DataSet& segment) {
    Json modifiers = Json::array();
    for (const gdcm::DataSet* type : List(segment, 0x0062, 0x000f)) {
      for (const Json& modifier : Codes(*type, 0x0011)) modifiers.push_back(modifier);
    }
    return {{"number", ReadShort(segment, 0x0062, 0x0004)},
            {"label", ReadText(segment, 0x0062, 0x0005)},
            {"category", Codes(segment, 0x0003)},
            {"codes", Codes(segment, 0x000f)},
            {"modifiers", modifiers}};
  }
  // Takes measures and orientation from a group that has them.
  void TakeGeometry(const gdcm::DataSet& group, Json& json) {
    for (const gdcm::DataSet* measures : List(group, 0x0028, 0x9110)) {
      Take("spacing", ReadNumbers(*measures, 0x0028, 0x0030), json);
      const std::vector<double> between = ReadNumbers(*measures, 0x0018, 0x0088);
      Take("slice", between.empty() ? ReadNumbers(*measures, 0x0018, 0x0050) : between, json);
    }
    for (const gdcm::DataSet* plane : List(group, 0x0020, 0x9116)) {
      Take("orientation", ReadNumbers(*plane, 0x0020, 0x0037), json);
    }
  }
  void Take(const char* key, const std::vector<double>& numbers, Json& json) const {
    if (numbers.empty()) return;
    if (json.contains(key)) {
      const std::vector<double> known = json[key].get<std::vector<double>>();
      for (std::size_t i = 0; i < std::max(known.size(), numbers.size()); ++i) {
        if (known.size() == numbers.size() && std::abs(known[i] - numbers[i]) < 1e-4) continue;
        throw Error(
            fmt::format("{}: the frames have different spacings or orientations, which kerf doesn't read", path_));
      }
      return;
    }
    json[key] = numbers;
  }
  void ReadShared(Json& json) {
    for (const gdcm::DataSet* shared : List(data_, 0x5200, 0x9229)) {
      TakeGeometry(*shared, json);
      for (const gdcm::DataSet* id : List(*shared, 0x0062, 0x000a)) shared_segment_ = ReadShort(*id, 0x0062, 0x000b);
    }
  }
  void ReadFrames(Json& json) {
    json["frames"] = Json::array();
    for (const gdcm::DataSet* frame : List(data_, 0x5200, 0x9230)) {
      TakeGeometry(*frame, json);
      int segment = shared_segment_;
      for (const gdcm::DataSet* id : List(*frame, 0x0062, 0x000a)) segment = ReadShort(*id, 0x0062, 0x000b);
      std::vector<double> position;
      for (const gdcm::DataSet* plane : List(*frame, 0x0020, 0x9113)) position = ReadNumbers(*plane, 0x0020, 0x0032);
      json["frames"].push_back({{"segment", segment}, {"position", position}});
    }
  }

  const gdcm::DataSet& data_;
  std::string path_;
  int shared_segment_ = 0;
  std::vector<DicomSequence> kept_;  // owners of the items
};

// Returns how many of the `length` bytes that the element of the pixels states are in the file. The reader fills the
// rest with zeros if the file is cut off there.
std::size_t CountBytesInFile(const std::string& path, std::size_t length, bool implicit) {
  const std::size_t size = std::filesystem::file_size(path);
  std::string head(std::min(size, kMaxHeaderBytes), '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  const std::size_t length_at = implicit ? 4 : 8;
  for (std::size_t at = 0; (at = head.find(std::string_view("\xe0\x7f\x10\0", 4), at)) != std::string::npos; ++at) {
    const std::size_t from = at + length_at + 4;
    if (from > head.size()) break;
    std::size_t stated = 0;
    for (std::size_t i = 4; i-- > 0;) stated = 256 * stated + static_cast<unsigned char>(head[at + length_at + i]);
    if (stated + stated % 2 == length + length % 2) return std::min(length, size - from);
  }
  return std::min(length, size);
}

// Reads the header, and copies the bytes of the pixels. For a child process.
Json ReadInChild(const std::string& path, const SharedMemory& pixels) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) throw Error(fmt::format("{}: the DICOM file can't be read; it is damaged or cut off", path));
  const gdcm::File& file = reader.GetFile();
  if (ReadText(file.GetHeader(), 0x0002, 0x0002) != kSegmentationStorage) {
    throw Error(fmt::format("{}: a DICOM file, but not a segmentation", path));
  }
  const gdcm::TransferSyntax& syntax = file.GetHeader().GetDataSetTransferSyntax();
  const bool plain =
      syntax == gdcm::TransferSyntax::ImplicitVRLittleEndian || syntax == gdcm::TransferSyntax::ExplicitVRLittleEndian;
  if (!plain) {
    throw Error(
        fmt::format("{}: the segmentation is compressed or big-endian, which kerf doesn't read; export it "
                    "uncompressed",
                    path));
  }
  Json json = Reading(file.GetDataSet(), path).Read();
  const gdcm::Tag tag(0x7fe0, 0x0010);
  const gdcm::ByteValue* bytes =
      file.GetDataSet().FindDataElement(tag) ? file.GetDataSet().GetDataElement(tag).GetByteValue() : nullptr;
  const std::size_t length = bytes == nullptr ? 0 : std::min<std::size_t>(bytes->GetLength(), pixels.size());
  if (length > 0) std::memcpy(pixels.data(), bytes->GetPointer(), length);
  json["bytes"] = CountBytesInFile(path, bytes == nullptr ? std::size_t{0} : std::size_t{bytes->GetLength()},
                                   syntax == gdcm::TransferSyntax::ImplicitVRLittleEndian);
  return json;
}

Vec3 ToVec3(const std::vector<double>& numbers, std::size_t from = 0) {
  return {numbers[from], numbers[from + 1], numbers[from + 2]};
}

// Takes size, spacing and orientation. Throws kerf::Error if one is missing or not finite.
void TakeLattice(const Json& json, const std::string& path, DicomSegments& read) {
  const auto numbers = [&](const char* key, std::size_t count) {
    std::vector<double> found = json.value(key, std::vector<double>());
    const bool finite = std::all_of(found.begin(), found.end(), [](double v) { return std::abs(v) < 1e6; });
    if (found.size() != count || !finite) throw Error(fmt::format("{}: the segmentation lacks its {}", path, key));
    return found;
  };
  json.at("size").get_to(read.size);
  const std::vector<double> spacing = numbers("spacing", 2);
  read.pixel_mm = {spacing[1], spacing[0]};  // the distance between rows comes first
  if (json.contains("slice")) read.slice_mm = numbers("slice", 1)[0];
  const std::vector<double> orientation = numbers("orientation", 6);
  read.row_W = ToVec3(orientation);
  read.column_W = ToVec3(orientation, 3);
  if (std::abs(glm::length(read.row_W) - 1) > 1e-2 || std::abs(glm::length(read.column_W) - 1) > 1e-2 ||
      std::abs(glm::dot(read.row_W, read.column_W)) > 1e-2) {
    throw Error(fmt::format("{}: the segmentation's rows and columns are not at right angles", path));
  }
  read.row_W = glm::normalize(read.row_W);
  read.column_W = glm::normalize(read.column_W);
}

void TakeFrames(const Json& json, const std::string& path, DicomSegments& read) {
  std::set<int> numbers;
  for (const Json& item : json.at("segments")) {
    DicomSegment& segment = read.segments.emplace_back();
    segment.number = item.at("number").get<int>();
    segment.label = item.at("label").get<std::string>();
    item.at("codes").get_to(segment.codes);
    item.at("modifiers").get_to(segment.modifiers);
    if (segment.number < 1 || segment.number > 32767) {
      throw Error(fmt::format("{}: the segment '{}' has the number {}, which is not from 1 to 32767", path,
                              segment.label, segment.number));
    }
    if (!numbers.insert(segment.number).second) {
      throw Error(fmt::format("{}: more than one segment has the number {}", path, segment.number));
    }
    if (!item.at("category").empty()) segment.category = item.at("category").at(0).get<std::string>();
  }
  for (const Json& item : json.at("frames")) {
    const std::vector<double> position = item.at("position").get<std::vector<double>>();
    const int number = item.at("segment").get<int>();
    const std::size_t nth = read.frames.size() + 1;
    if (position.size() != 3 || !IsInWorld(ToVec3(position))) {
      throw Error(fmt::format("{}: frame {} of the segmentation has no valid position", path, nth));
    }
    if (numbers.count(number) == 0) {
      throw Error(
          fmt::format("{}: frame {} belongs to segment {}, which the file does not describe", path, nth, number));
    }
    read.frames.push_back({number, ToVec3(position)});
  }
}

// Throws kerf::Error unless `bytes` bytes are enough for the pixels of all frames, with `bits` bits each.
void CheckPixels(const DicomSegments& read, std::uint64_t bytes, int bits, bool binary, const std::string& path) {
  if (bits != (binary ? 1 : 8)) {
    throw Error(fmt::format("{}: the segmentation's pixels have {} bits; kerf reads {}", path, bits,
                            binary ? "binary segmentations with 1 bit" : "fractional segmentations with 8 bits"));
  }
  const std::uint64_t pixels = std::uint64_t{read.frames.size()} * static_cast<std::uint64_t>(read.size[0]) *
                               static_cast<std::uint64_t>(read.size[1]);
  if (pixels == 0) throw Error(fmt::format("{}: the segmentation has no pixels", path));
  if (pixels > kMaxVoxels) throw Error(fmt::format("{}: the segmentation has more than 2^31 pixels", path));
  const std::uint64_t needed = binary ? (pixels + 7) / 8 : pixels;
  if (bytes < needed) {
    throw Error(
        fmt::format("{}: the file is cut off or damaged: its {} frames of {} x {} pixels need {} bytes, but it "
                    "has {}",
                    path, read.frames.size(), read.size[0], read.size[1], needed, bytes));
  }
}

}  // namespace

bool IsDicomFile(const std::string& path) {
  std::ifstream in = OpenImageFile(path);
  std::array<char, 132> head{};
  in.read(head.data(), head.size());
  return in.gcount() == static_cast<std::streamsize>(head.size()) && std::string(&head[128], 4) == "DICM";
}

DicomSegments ReadDicomSegments(const std::string& path) {
  CheckDicomHeader(path);
  std::error_code failed;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, failed);
  if (failed || file_bytes > kMaxBytes) throw Error(fmt::format("{}: is larger than 2 GiB or can't be read", path));
  const SharedMemory bytes(static_cast<std::size_t>(file_bytes));
  const auto read_in_child = [&](ChildReport&) {
    std::string cbor;
    Json::to_cbor(ReadInChild(path, bytes), cbor);
    return cbor;
  };
  const ChildLimits limits{std::min(kMaxMemory, kLeastMemory + kMemoryPerByte * file_bytes), kSilent_s};
  const std::string packed = RunInChild(path, limits, read_in_child, {});
  DicomSegments read;
  const Json json = Json::from_cbor(packed);
  TakeLattice(json, path, read);
  TakeFrames(json, path, read);
  read.series_uid = json.value("series", "");
  const int bits = json.at("bits").get<int>(), fraction = json.at("fraction").get<int>();
  CheckPixels(read, json.at("bytes").get<std::uint64_t>(), bits, fraction == 0, path);
  read.pixels.resize(read.frames.size() * static_cast<std::size_t>(read.size[0]) *
                     static_cast<std::size_t>(read.size[1]));
  const auto* raw = reinterpret_cast<const unsigned char*>(bytes.data());
  for (std::size_t i = 0; i < read.pixels.size(); ++i) {
    read.pixels[i] = bits == 1 ? raw[i / 8] >> (i % 8) & 1 : raw[i] >= kHalf * fraction ? 1 : 0;
  }
  return read;
}

}  // namespace kerf
