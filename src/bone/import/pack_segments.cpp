#include <fmt/format.h>
#include <gdcmReader.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/core/printable.h"
#include "bone/import/dicom_elements.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/packed_segments.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxHeaderBytes = std::size_t{256} << 20;

// Reads one data set and the sequences in it.
class Reading {
 public:
  explicit Reading(const gdcm::DataSet& data, std::string path) : data_(data), path_(std::move(path)) {}

  Json Read() {
    Json json;
    const std::string type = ReadText(data_, 0x0062, 0x0001);
    if (type != "BINARY" && type != "FRACTIONAL") {
      throw Error(fmt::format("{}: a segmentation of type '{}', which kerf doesn't read", path_, Printable(type)));
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
            {"label", Printable(ReadText(segment, 0x0062, 0x0005))},
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

}  // namespace

std::string PackSegments(const std::string& path, std::span<char> pixels) {
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
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kerf
