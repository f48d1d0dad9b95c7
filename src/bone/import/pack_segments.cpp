#include <fmt/format.h>
#include <gdcmBitmap.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfFragments.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/core/printable.h"
#include "bone/import/dicom_charset.h"
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
    if (type != "BINARY" && type != "FRACTIONAL" && type != "LABELMAP") {
      throw Error(fmt::format("{}: a segmentation of type '{}', which kerf doesn't read", path_, Printable(type)));
    }
    if (ReadText(data_, 0x0020, 0x9311).compare(0, 5, "TILED") == 0) {
      throw Error(
          fmt::format("{}: the segmentation is of a microscope's slide: its frames are tiles of one image, not slices "
                      "of a scan",
                      path_));
    }
    json["label_map"] = is_label_map_ = type == "LABELMAP";
    json["padding"] = ReadShort(data_, 0x0028, 0x0120);
    json["fraction"] = type == "FRACTIONAL" ? ReadShort(data_, 0x0062, 0x000e) : 0;
    if (type == "FRACTIONAL" && json["fraction"] == 0) {
      throw Error(fmt::format("{}: the segmentation's maximum fractional value is missing or 0", path_));
    }
    json["bits"] = ReadShort(data_, 0x0028, 0x0100);
    json["size"] = {ReadShort(data_, 0x0028, 0x0011), ReadShort(data_, 0x0028, 0x0010)};
    json["frame"] = ReadText(data_, 0x0020, 0x0052);
    for (const gdcm::DataSet* series : List(data_, 0x0008, 0x1115)) json["series"] = ReadText(*series, 0x0020, 0x000e);
    json["segments"] = Json::array();
    for (const gdcm::DataSet* segment : List(data_, 0x0062, 0x0002)) {
      Json described = ReadSegment(*segment);
      const bool is_background = is_label_map_ && (described["number"] == 0 || described["number"] == json["padding"]);
      if (!is_background) json["segments"].push_back(std::move(described));
    }
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
            {"label", DecodeDicomText(ReadText(segment, 0x0062, 0x0005), ReadText(data_, 0x0008, 0x0005))},
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
      shared_segment_ = ReadNumber(*shared, 0);
      shared_position_ = ReadPosition(*shared, {});
    }
  }
  void ReadFrames(Json& json) {
    json["frames"] = Json::array();
    for (const gdcm::DataSet* frame : List(data_, 0x5200, 0x9230)) {
      TakeGeometry(*frame, json);
      json["frames"].push_back({{"segment", is_label_map_ ? 0 : ReadNumber(*frame, shared_segment_)},
                                {"position", ReadPosition(*frame, shared_position_)}});
    }
  }
  int ReadNumber(const gdcm::DataSet& group, int otherwise) {
    for (const gdcm::DataSet* id : List(group, 0x0062, 0x000a)) otherwise = ReadShort(*id, 0x0062, 0x000b);
    return otherwise;
  }
  std::vector<double> ReadPosition(const gdcm::DataSet& group, std::vector<double> otherwise) {
    for (const gdcm::DataSet* plane : List(group, 0x0020, 0x9113)) otherwise = ReadNumbers(*plane, 0x0020, 0x0032);
    return otherwise;
  }

  const gdcm::DataSet& data_;
  std::string path_;
  bool is_label_map_ = false;
  int shared_segment_ = 0;
  std::vector<double> shared_position_;
  std::vector<DicomSequence> kept_;  // owners of the items
};

// Returns how many of the `length` bytes that the element of the pixels states are in the file. The reader fills the
// rest with zeros if the file is cut off there.
std::size_t CountBytesInFile(std::istream& in, std::size_t length, const gdcm::TransferSyntax& syntax) {
  const bool implicit = syntax == gdcm::TransferSyntax::ImplicitVRLittleEndian;
  const bool big_endian = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
  const std::string_view tag(big_endian ? "\x7f\xe0\0\x10" : "\xe0\x7f\x10\0", 4);
  in.clear();
  in.seekg(0, std::ios::end);
  const auto size = static_cast<std::size_t>(std::max<std::streamoff>(0, in.tellg()));
  std::string head(std::min(size, kMaxHeaderBytes), '\0');
  in.seekg(0);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  const std::size_t length_at = implicit ? 4 : 8;
  for (std::size_t at = 0; (at = head.find(tag, at)) != std::string::npos; ++at) {
    const std::size_t from = at + length_at + 4;
    if (from > head.size()) break;
    std::size_t stated = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      stated = 256 * stated + static_cast<unsigned char>(head[at + length_at + (big_endian ? i : 3 - i)]);
    }
    if (stated + stated % 2 == length + length % 2) return std::min(length, size - from);
  }
  return std::min(length, size);
}

// Unpacks frames that are each deflated, in a fragment of their own. Returns false if they can't be unpacked.
bool InflateFrames(const gdcm::DataElement& element, std::size_t frames, std::size_t bytes, std::span<char> to) {
  const gdcm::SequenceOfFragments* fragments = element.GetSequenceOfFragments();
  if (fragments == nullptr || fragments->GetNumberOfFragments() != frames) return false;
  for (std::size_t f = 0; f < frames; ++f) {
    const gdcm::ByteValue* packed = fragments->GetFragment(static_cast<unsigned>(f)).GetByteValue();
    z_stream z{};
    if (packed == nullptr || inflateInit2(&z, -MAX_WBITS) != Z_OK) return false;
    std::string in(packed->GetPointer(), packed->GetLength());
    z.next_in = reinterpret_cast<unsigned char*>(in.data());
    z.avail_in = static_cast<uInt>(in.size());
    z.next_out = reinterpret_cast<unsigned char*>(&to[f * bytes]);
    z.avail_out = static_cast<uInt>(bytes);
    const int state = inflate(&z, Z_FINISH);
    inflateEnd(&z);
    if (z.avail_out != 0 || (state != Z_STREAM_END && state != Z_BUF_ERROR)) return false;
  }
  return true;
}

// Unpacks compressed pixels. Returns the number of bytes; `json` then states how they are stored.
std::size_t DecodeFrames(const gdcm::File& file, const gdcm::DataElement& element, SegmentPacking packing,
                         std::span<char> pixels, const std::string& path, Json& json) {
  const auto columns = json["size"][0].get<unsigned>(), rows = json["size"][1].get<unsigned>();
  const auto frames = json["frames"].size();
  const int bits = json["bits"].get<int>();
  const bool single_bits = bits == 1;
  const std::uint64_t frame_pixels = std::uint64_t{columns} * rows;
  const std::uint64_t frame_bytes = (frame_pixels * static_cast<unsigned>(bits) + 7) / 8;
  const std::uint64_t unpacked = frames * (single_bits ? frame_pixels : frame_bytes);
  if (frames == 0 || unpacked == 0 || unpacked > pixels.size()) {
    throw Error(fmt::format("{}: the file is damaged: {} frames of {} x {} pixels can't be in it", path, frames,
                            columns, rows));
  }
  bool good = false;
  if (packing == SegmentPacking::kDeflatedFrames) {
    good = InflateFrames(element, frames, frame_bytes, pixels);
    if (good && single_bits) {
      const std::string packed(pixels.data(), frames * frame_bytes);
      for (std::size_t i = 0; i < unpacked; ++i) {
        const std::size_t bit = i % frame_pixels;
        pixels[i] = static_cast<char>(packed[i / frame_pixels * frame_bytes + bit / 8] >> (bit % 8) & 1);
      }
      json["bits"] = 8;
    }
  } else {
    gdcm::Bitmap bitmap;
    bitmap.SetNumberOfDimensions(3);
    bitmap.SetDimension(0, columns);
    bitmap.SetDimension(1, rows);
    bitmap.SetDimension(2, static_cast<unsigned>(frames));
    const auto bits_of = static_cast<unsigned short>(bits);
    bitmap.SetPixelFormat(gdcm::PixelFormat(1, bits_of, bits_of, static_cast<unsigned short>(bits_of - 1), 0));
    bitmap.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    bitmap.SetTransferSyntax(file.GetHeader().GetDataSetTransferSyntax());
    bitmap.SetDataElement(element);
    good = !single_bits && bitmap.GetBufferLength() == unpacked && bitmap.GetBuffer(pixels.data());
  }
  if (good) return unpacked;
  throw Error(fmt::format("{}: the segmentation's compressed pixels ({}) can't be unpacked; export it uncompressed",
                          path,
                          packing == SegmentPacking::kDeflatedFrames
                              ? "deflated"
                              : gdcm::TransferSyntax::GetTSString(file.GetHeader().GetDataSetTransferSyntax())));
}

}  // namespace

std::string PackSegments(std::istream& in, SegmentPacking packing, std::span<char> pixels, const std::string& path) {
  gdcm::Reader reader;
  reader.SetStream(in);
  if (!reader.Read()) throw Error(fmt::format("{}: the DICOM file can't be read; it is damaged or cut off", path));
  const gdcm::File& file = reader.GetFile();
  const std::string storage = ReadText(file.GetHeader(), 0x0002, 0x0002);
  if (storage != kSegmentationStorage && storage != kLabelMapStorage) {
    throw Error(fmt::format("{}: a DICOM file, but not a segmentation", path));
  }
  Json json = Reading(file.GetDataSet(), path).Read();
  const gdcm::Tag tag(0x7fe0, 0x0010);
  if (!file.GetDataSet().FindDataElement(tag)) {
    throw Error(fmt::format("{}: the file is cut off or damaged: it has no pixels", path));
  }
  const gdcm::DataElement& element = file.GetDataSet().GetDataElement(tag);
  if (packing == SegmentPacking::kNative) {
    const gdcm::ByteValue* bytes = element.GetByteValue();
    const std::size_t length = bytes == nullptr ? 0 : std::size_t{bytes->GetLength()};
    if (bytes != nullptr && length > 0)
      std::memcpy(pixels.data(), bytes->GetPointer(), std::min(length, pixels.size()));
    json["bytes"] = CountBytesInFile(in, length, file.GetHeader().GetDataSetTransferSyntax());
  } else {
    json["bytes"] = DecodeFrames(file, element, packing, pixels, path, json);
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kerf
