#include "bone/import/write_dicom_segments.h"

#include <fmt/format.h>
#include <gdcmUIDGenerator.h>
#include <gdcmWriter.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <glm/mat3x3.hpp>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/files/files.h"
#include "bone/import/dicom_elements.h"
#include "bone/import/limits.h"
#include "kerf/error.h"
#include "kerf/version.h"

namespace kerf {
namespace {

using gdcm::VR;

/// A data set in the making.
class DicomItem {
 public:
  DicomItem& Text(std::uint16_t group, std::uint16_t element, VR::VRType vr, std::string text) {
    if (text.size() % 2 != 0) text += vr == VR::UI ? '\0' : ' ';
    return Bytes(group, element, vr, text);
  }
  DicomItem& Numbers(std::uint16_t group, std::uint16_t element, std::initializer_list<double> numbers) {
    std::string text;
    for (const double number : numbers) text += fmt::format("{}{:.10g}", text.empty() ? "" : "\\", number);
    return Text(group, element, VR::DS, text);
  }
  DicomItem& Shorts(std::uint16_t group, std::uint16_t element, std::initializer_list<int> values,
                    VR::VRType vr = VR::US) {
    std::string bytes;
    for (const int value : values) AppendLittle(static_cast<std::uint32_t>(value), 2, bytes);
    return Bytes(group, element, vr, bytes);
  }
  DicomItem& Longs(std::uint16_t group, std::uint16_t element, std::initializer_list<std::size_t> values) {
    std::string bytes;
    for (const std::size_t value : values) AppendLittle(static_cast<std::uint32_t>(value), 4, bytes);
    return Bytes(group, element, VR::UL, bytes);
  }
  DicomItem& Bytes(std::uint16_t group, std::uint16_t element, VR::VRType vr, std::string_view bytes) {
    gdcm::DataElement one{gdcm::Tag(group, element)};
    one.SetVR(vr);
    one.SetByteValue(bytes.data(), gdcm::VL(static_cast<std::uint32_t>(bytes.size())));
    data_.Replace(one);
    return *this;
  }
  DicomItem& Sequence(std::uint16_t group, std::uint16_t element, const std::vector<DicomItem>& items) {
    const DicomSequence sequence = new gdcm::SequenceOfItems;
    sequence->SetLengthToUndefined();
    for (const DicomItem& of : items) {
      gdcm::Item item;
      item.SetVLToUndefined();
      item.SetNestedDataSet(of.data_);
      sequence->AddItem(item);
    }
    gdcm::DataElement one{gdcm::Tag(group, element)};
    one.SetVR(VR::SQ);
    one.SetValue(*sequence);
    one.SetVLToUndefined();
    data_.Replace(one);
    return *this;
  }
  const gdcm::DataSet& data() const { return data_; }

 private:
  static void AppendLittle(std::uint32_t value, int bytes, std::string& to) {
    for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> (8 * i) & 0xff);
  }
  gdcm::DataSet data_;
};

/// A text for the default character set, of up to 64 characters.
std::string Ascii(const std::string& text) {
  constexpr std::size_t kLongest = 64;
  std::string plain = text.substr(0, kLongest);
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return c < ' ' || c > '~' || c == '\\'; }, '?');
  return plain;
}

std::string MakeUid() {
  gdcm::UIDGenerator generator;
  return generator.Generate();
}

DicomItem MakeCode(const DicomCode& code) {
  DicomItem item;
  item.Text(0x0008, 0x0100, VR::SH, code.value);
  item.Text(0x0008, 0x0102, VR::SH, code.scheme);
  item.Text(0x0008, 0x0104, VR::LO, Ascii(code.meaning));
  return item;
}

/// Returns a colour as CIELab of the profile connection space, whose white is D50 (PS3.3 C.10.7.1.1).
std::array<int, 3> ToLab(const std::array<std::uint8_t, 3>& colour) {
  const auto to_linear = [](std::uint8_t value) {
    const double c = value / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  // sRGB (IEC 61966-2-1), adapted from D65 to D50 after Bradford; columns: red, green, blue.
  const glm::dmat3 kFromRgb(0.4360747, 0.2225045, 0.0139322, 0.3850649, 0.7168786, 0.0971045, 0.1430804, 0.0606169,
                            0.7141733);
  const Vec3 white(0.96422, 1, 0.82521);
  const Vec3 xyz = kFromRgb * Vec3(to_linear(colour[0]), to_linear(colour[1]), to_linear(colour[2])) / white;
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  const double lightness = 116 * f(xyz.y) - 16, a = 500 * (f(xyz.x) - f(xyz.y)), b = 200 * (f(xyz.y) - f(xyz.z));
  const auto scale = [](double value, double lower, double upper) {
    return static_cast<int>(std::lround(65535 * std::clamp((value - lower) / (upper - lower), 0.0, 1.0)));
  };
  return {scale(lightness, 0, 100), scale(a, -128, 127), scale(b, -128, 127)};
}

/// Returns references to the slices of the CT.
std::vector<DicomItem> MakeInstances(const DicomStudy& study) {
  std::vector<DicomItem> instances(study.instance_uids.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    instances[i].Text(0x0008, 0x1150, VR::UI, study.class_uid).Text(0x0008, 0x1155, VR::UI, study.instance_uids[i]);
  }
  return instances;
}

void AddGeneral(const DicomStudy& study, const std::string& instance_uid, DicomItem& to) {
  static const std::map<std::pair<int, int>, VR::VRType> kTypes{
      {{0x0008, 0x0005}, VR::CS}, {{0x0008, 0x0020}, VR::DA}, {{0x0008, 0x0030}, VR::TM}, {{0x0008, 0x0050}, VR::SH},
      {{0x0008, 0x0090}, VR::PN}, {{0x0010, 0x0010}, VR::PN}, {{0x0010, 0x0020}, VR::LO}, {{0x0010, 0x0030}, VR::DA},
      {{0x0010, 0x0040}, VR::CS}, {{0x0020, 0x000d}, VR::UI}, {{0x0020, 0x0010}, VR::SH}, {{0x0020, 0x0052}, VR::UI},
      {{0x0020, 0x1040}, VR::LO}};
  for (const DicomStudy::Element& element : study.elements) {
    const bool is_character_set = element.group == 0x0008 && element.element == 0x0005;
    if (is_character_set && element.value.empty()) continue;
    to.Text(element.group, element.element, kTypes.at({element.group, element.element}), element.value);
  }
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 16> date{}, time{};
  std::strftime(date.data(), date.size(), "%Y%m%d", &local);
  std::strftime(time.data(), time.size(), "%H%M%S", &local);
  to.Text(0x0008, 0x0008, VR::CS, "DERIVED\\PRIMARY");
  to.Text(0x0008, 0x0016, VR::UI, kSegmentationStorage).Text(0x0008, 0x0018, VR::UI, instance_uid);
  to.Text(0x0008, 0x0023, VR::DA, date.data()).Text(0x0008, 0x0033, VR::TM, time.data());
  to.Text(0x0008, 0x0060, VR::CS, "SEG").Text(0x0008, 0x103e, VR::LO, "Cut by kerf");
  to.Text(0x0008, 0x0070, VR::LO, "kerf").Text(0x0008, 0x1090, VR::LO, "kerf");
  to.Text(0x0018, 0x1000, VR::LO, CommitString()).Text(0x0018, 0x1020, VR::LO, VersionString());
  to.Text(0x0020, 0x000e, VR::UI, MakeUid());
  to.Text(0x0020, 0x0011, VR::IS, "300").Text(0x0020, 0x0013, VR::IS, "1");
  to.Text(0x0070, 0x0080, VR::CS, "SEGMENTATION").Text(0x0070, 0x0081, VR::LO, "Bone and cut");
  to.Text(0x0070, 0x0084, VR::PN, "kerf");
  DicomItem series;
  series.Text(0x0020, 0x000e, VR::UI, study.series_uid).Sequence(0x0008, 0x114a, MakeInstances(study));
  to.Sequence(0x0008, 0x1115, {series});
}

void AddSegments(const DicomWriting& writing, DicomItem& to) {
  std::vector<DicomItem> segments;
  for (const DicomWrittenSegment& segment : writing.segments) {
    const std::array<int, 3> lab = ToLab(segment.colour);
    DicomItem item;
    item.Shorts(0x0062, 0x0004, {static_cast<int>(segments.size()) + 1});
    item.Text(0x0062, 0x0005, VR::LO, Ascii(segment.label)).Text(0x0062, 0x0008, VR::CS, "SEMIAUTOMATIC");
    item.Text(0x0062, 0x0009, VR::LO, "kerf").Shorts(0x0062, 0x000d, {lab[0], lab[1], lab[2]});
    item.Sequence(0x0062, 0x0003, {MakeCode(segment.category)}).Sequence(0x0062, 0x000f, {MakeCode(segment.type)});
    segments.push_back(item);
  }
  to.Text(0x0062, 0x0001, VR::CS, "BINARY").Sequence(0x0062, 0x0002, segments);
}

/// Returns how the frames were derived: by segmentation of all slices of the CT (PS3.3 C.7.6.16.2.6).
DicomItem MakeDerivation(const DicomStudy& study) {
  DicomItem purpose = MakeCode({"121322", "DCM", "Source image for image processing operation"});
  std::vector<DicomItem> sources = MakeInstances(study);
  for (DicomItem& source : sources) {
    source.Text(0x0028, 0x135a, VR::CS, "NO");  // the voxels lie elsewhere
    source.Sequence(0x0040, 0xa170, {purpose});
  }
  DicomItem derivation;
  derivation.Sequence(0x0008, 0x9215, {MakeCode({"113076", "DCM", "Segmentation"})}).Sequence(0x0008, 0x2112, sources);
  return derivation;
}

// The frames are ordered by two dimensions: the segment, and the place of the slice.
void AddDimensions(DicomItem& to) {
  const std::string uid = MakeUid();
  DicomItem organization, segment, place;
  organization.Text(0x0020, 0x9164, VR::UI, uid);
  segment.Text(0x0020, 0x9164, VR::UI, uid).Text(0x0020, 0x9421, VR::LO, "Segment");
  segment.Shorts(0x0020, 0x9165, {0x0062, 0x000b}, VR::AT).Shorts(0x0020, 0x9167, {0x0062, 0x000a}, VR::AT);
  place.Text(0x0020, 0x9164, VR::UI, uid).Text(0x0020, 0x9421, VR::LO, "Slice");
  place.Shorts(0x0020, 0x9165, {0x0020, 0x0032}, VR::AT).Shorts(0x0020, 0x9167, {0x0020, 0x9113}, VR::AT);
  to.Sequence(0x0020, 0x9221, {organization}).Sequence(0x0020, 0x9222, {segment, place});
}

void AddFrames(const DicomWriting& writing, const DicomStudy& study, DicomItem& to) {
  DicomItem measures, orientation, shared;
  measures.Numbers(0x0028, 0x0030, {writing.voxel_mm, writing.voxel_mm});
  measures.Numbers(0x0018, 0x0050, {writing.voxel_mm}).Numbers(0x0018, 0x0088, {writing.voxel_mm});
  const glm::dmat3& turn = study.file_from_lps;
  orientation.Numbers(0x0020, 0x0037, {turn[0].x, turn[0].y, turn[0].z, turn[1].x, turn[1].y, turn[1].z});
  shared.Sequence(0x0028, 0x9110, {measures}).Sequence(0x0020, 0x9116, {orientation});
  shared.Sequence(0x0008, 0x9124, {MakeDerivation(study)});
  to.Sequence(0x5200, 0x9229, {shared});
  double lowest_mm = writing.frames.front().origin_W.z;
  for (const DicomSegmentFrame& frame : writing.frames) lowest_mm = std::min(lowest_mm, frame.origin_W.z);
  std::vector<DicomItem> frames;
  for (const DicomSegmentFrame& frame : writing.frames) {
    const auto slice = std::lround((frame.origin_W.z - lowest_mm) / writing.voxel_mm);
    DicomItem content, plane, segment, item;
    content.Longs(0x0020, 0x9157, {static_cast<std::size_t>(frame.segment), static_cast<std::size_t>(slice) + 1});
    const Vec3 origin = turn * frame.origin_W;
    plane.Numbers(0x0020, 0x0032, {origin.x, origin.y, origin.z});
    segment.Shorts(0x0062, 0x000b, {frame.segment});
    item.Sequence(0x0020, 0x9111, {content}).Sequence(0x0020, 0x9113, {plane}).Sequence(0x0062, 0x000a, {segment});
    frames.push_back(item);
  }
  to.Sequence(0x5200, 0x9230, frames).Text(0x0028, 0x0008, VR::IS, fmt::format("{}", frames.size()));
}

void AddPixels(const DicomWriting& writing, DicomItem& to) {
  to.Shorts(0x0028, 0x0002, {1}).Text(0x0028, 0x0004, VR::CS, "MONOCHROME2");
  to.Shorts(0x0028, 0x0010, {writing.size[1]}).Shorts(0x0028, 0x0011, {writing.size[0]});
  to.Shorts(0x0028, 0x0100, {1}).Shorts(0x0028, 0x0101, {1}).Shorts(0x0028, 0x0102, {0}).Shorts(0x0028, 0x0103, {0});
  to.Text(0x0028, 0x2110, VR::CS, "00");  // without loss
  std::string pixels(reinterpret_cast<const char*>(writing.pixels.data()), writing.pixels.size());
  if (pixels.size() % 2 != 0) pixels += '\0';
  to.Bytes(0x7fe0, 0x0010, VR::OB, pixels);
}

}  // namespace

void WriteDicomSegments(const DicomWriting& writing, const DicomStudy& study, const std::string& path) {
  if (writing.frames.empty()) throw Error("there is no bone to write as a segmentation");
  if (8.0 * static_cast<double>(writing.pixels.size()) > static_cast<double>(kMaxVoxels)) {
    throw Error("a DICOM segmentation of these voxels would have more than 2^31 pixels; choose larger voxels");
  }
  const std::string instance_uid = MakeUid();
  DicomItem all;
  AddGeneral(study, instance_uid, all);
  AddSegments(writing, all);
  AddDimensions(all);
  AddFrames(writing, study, all);
  AddPixels(writing, all);
  std::ostringstream stream;
  gdcm::Writer writer;
  writer.SetStream(stream);
  writer.GetFile().SetDataSet(all.data());
  writer.GetFile().GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  if (!writer.Write()) throw Error(fmt::format("{}: the segmentation can't be written as DICOM", path));
  WriteTextFile(path, stream.str());
}

}  // namespace kerf
