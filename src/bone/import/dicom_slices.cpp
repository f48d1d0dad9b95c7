#include "bone/import/dicom_slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <optional>
#include <sstream>

#include "bone/import/dicom_elements.h"
#include "bone/import/dicom_text.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {

namespace {

struct SliceTag {
  std::uint16_t group, element;
};

constexpr SliceTag kPixelMeasures{0x0028, 0x9110};  // groups of a frame
constexpr SliceTag kPlanePosition{0x0020, 0x9113};
constexpr SliceTag kPlaneOrientation{0x0020, 0x9116};
constexpr SliceTag kPixelValues{0x0028, 0x9145};
constexpr SliceTag kFrameContent{0x0020, 0x9111};

constexpr SliceTag kPosition{0x0020, 0x0032};
constexpr SliceTag kOrientation{0x0020, 0x0037};
constexpr SliceTag kPixelSpacing{0x0028, 0x0030};
constexpr SliceTag kIntercept{0x0028, 0x1052};
constexpr SliceTag kSlope{0x0028, 0x1053};

// The elements of each frame of a file: those in the frame's own groups, in the groups that all frames share, or of the
// file as a whole.
class FrameElements {
 public:
  explicit FrameElements(const gdcm::DataSet& file) : file_(file) {
    shared_ = ReadItems(file, 0x5200, 0x9229, kept_);
    own_ = ReadItems(file, 0x5200, 0x9230, kept_);
  }

  // Returns the data set that has the element, which may stand in a group; nullptr if there is none.
  const gdcm::DataSet* Find(int frame, const SliceTag& group, const SliceTag& tag) {
    if (const gdcm::DataSet* own = FindOwn(frame, group, tag); own != nullptr) return own;
    if (const gdcm::DataSet* shared = InGroup(shared_, 0, group, tag); shared != nullptr) return shared;
    return file_.FindDataElement(gdcm::Tag(tag.group, tag.element)) ? &file_ : nullptr;
  }
  const gdcm::DataSet* FindOwn(int frame, const SliceTag& group, const SliceTag& tag) {
    return InGroup(own_, static_cast<std::size_t>(frame), group, tag);
  }
  // Returns how many frames are described, as far as each should be.
  int CountFrames(int frames) const { return own_.empty() ? frames : std::min(frames, static_cast<int>(own_.size())); }
  std::vector<double> Numbers(int frame, const SliceTag& group, const SliceTag& tag) {
    const gdcm::DataSet* const data = Find(frame, group, tag);
    return data == nullptr ? std::vector<double>() : ReadNumbers(*data, tag.group, tag.element);
  }

 private:
  const gdcm::DataSet* InGroup(const std::vector<const gdcm::DataSet*>& groups, std::size_t index,
                               const SliceTag& group, const SliceTag& tag) {
    if (index >= groups.size()) return nullptr;
    const auto items = ReadItems(*groups[index], group.group, group.element, kept_);
    if (items.empty() || !items.front()->FindDataElement(gdcm::Tag(tag.group, tag.element))) return nullptr;
    return items.front();
  }

  const gdcm::DataSet& file_;
  std::vector<DicomSequence> kept_;
  std::vector<const gdcm::DataSet*> shared_, own_;
};

std::optional<double> ReadDecimal(const std::string& text) {
  std::istringstream in(text);
  double value = 0;
  if (!(in >> value) || !std::isfinite(value) || !(in >> std::ws).eof()) return std::nullopt;
  return value;
}

void ReadRescale(FrameElements& elements, DicomSlice& slice) {
  const auto read = [&](const SliceTag& tag, const char* name, int bit, double& value) {
    const bool zero_allowed = bit == DicomSlice::kHasIntercept;
    const gdcm::DataSet* const data = elements.Find(slice.frame, kPixelValues, tag);
    if (data == nullptr) return;
    slice.rescale |= bit;
    const std::string text = ReadText(*data, tag.group, tag.element);
    const std::optional<double> number = ReadDecimal(text);
    if (!number || (*number == 0 && !zero_allowed)) {
      slice.fault = fmt::format("its {} ({:04x},{:04x}) is {}, not a number{}", name, tag.group, tag.element,
                                text.empty() ? "empty" : "'" + text + "'", zero_allowed ? "" : " other than 0");
      return;
    }
    value = *number;
  };
  read(kIntercept, "RescaleIntercept", DicomSlice::kHasIntercept, slice.intercept);
  read(kSlope, "RescaleSlope", DicomSlice::kHasSlope, slice.slope);
}

// Reads how values are stored: in which bits, and which value is padding.
void ReadPixelFormat(const gdcm::DataSet& data, gdcm::StringFilter& filter, DicomSlice& slice) {
  slice.samples = GetInteger(filter, 0x0028, 0x0002, 1);
  slice.bits = GetInteger(filter, 0x0028, 0x0100, 0);
  slice.bits_stored = GetInteger(filter, 0x0028, 0x0101, slice.bits);
  slice.is_signed = GetInteger(filter, 0x0028, 0x0103, 0) != 0;
  const int high_bit = GetInteger(filter, 0x0028, 0x0102, slice.bits_stored - 1);
  const bool is_lowest = high_bit == slice.bits_stored - 1 && slice.bits_stored >= 1 && slice.bits_stored <= slice.bits;
  if (!is_lowest && slice.bits > 0) {
    slice.fault = fmt::format(
        "its HighBit (0028,0102) is {}, but {} of {} bits are stored (0028,0101); kerf reads values whose highest bit "
        "is the one below BitsStored",
        high_bit, slice.bits_stored, slice.bits);
  }
  slice.inverted = GetText(filter, 0x0028, 0x0004) == "MONOCHROME1";
  // The type of the value may be US or SS, whatever that of the pixels is.
  const auto padding = [&](std::uint16_t element) {
    const int value = ReadShort(data, 0x0028, element) & (slice.bits <= 8 ? 0xff : 0xffff);
    const int beyond = slice.bits <= 8 ? 0x100 : 0x10000;
    return slice.is_signed && 2 * value >= beyond ? value - beyond : value;
  };
  slice.has_padding = data.FindDataElement(gdcm::Tag(0x0028, 0x0120));
  if (!slice.has_padding) return;
  const int value = padding(0x0120);
  const int limit = data.FindDataElement(gdcm::Tag(0x0028, 0x0121)) ? padding(0x0121) : value;
  slice.padding = {std::min(value, limit), std::max(value, limit)};
}

// Reads the size of a pixel and the directions of rows and columns. Returns false if they are missing or invalid.
bool ReadPlane(FrameElements& elements, DicomSlice& slice) {
  std::vector<double> spacing = elements.Numbers(slice.frame, kPixelMeasures, kPixelSpacing);
  if (spacing.size() != 2 && slice.frames > 1)
    spacing = elements.Numbers(slice.frame, kPixelMeasures, {0x0018, 0x1164});
  if (spacing.size() != 2) return false;
  slice.pixel_mm = {spacing[1], spacing[0]};  // the distance between rows comes first
  if (!(spacing[0] > 0 && spacing[1] > 0)) {
    slice.fault =
        fmt::format("its PixelSpacing (0028,0030) is {:g} and {:g}, not two lengths above 0", spacing[0], spacing[1]);
    return false;
  }
  std::vector<double> orientation = elements.Numbers(slice.frame, kPlaneOrientation, kOrientation);
  if (orientation.empty() && slice.frames > 1) {
    slice.has_orientation = false;
    orientation = {1, 0, 0, 0, 1, 0};
  }
  if (orientation.size() != 6) return false;
  slice.row_W = {orientation[0], orientation[1], orientation[2]};
  slice.column_W = {orientation[3], orientation[4], orientation[5]};
  const double row = glm::length(slice.row_W);
  const double column = glm::length(slice.column_W);
  if (!(std::abs(row - 1) < 1e-2 && std::abs(column - 1) < 1e-2 &&
        std::abs(glm::dot(slice.row_W, slice.column_W)) < 1e-2)) {
    return false;
  }
  slice.row_W /= row;
  slice.column_W /= column;
  return true;
}

// Sets the position of a frame that has none of its own, by its number.
void PlaceFrame(FrameElements& elements, DicomSlice& slice) {
  const auto one = [&](const SliceTag& tag) {
    const std::vector<double> values = elements.Numbers(slice.frame, kPixelMeasures, tag);
    return values.size() == 1 ? values[0] : 0;
  };
  const std::vector<double> offsets = elements.Numbers(0, kPixelMeasures, {0x3004, 0x000c});
  const Vec3 normal = CalcNormal(slice);
  if (offsets.size() == static_cast<std::size_t>(slice.frames)) {
    // Offsets that begin with the first frame's own place are places along the patient's axis.
    const bool absolute = offsets[0] != 0 && offsets[0] == slice.origin_W.z;
    const double sign = absolute && normal.z < 0 ? -1 : 1;
    slice.origin_W += normal * (sign * (offsets[static_cast<std::size_t>(slice.frame)] - offsets[0]));
    if (!slice.has_orientation) slice.spacing_from = "GridFrameOffsetVector (3004,000c)";
    return;
  }
  double step = one({0x0018, 0x0088});
  slice.thickness_mm = std::max(0.0, one({0x0018, 0x0050}));
  slice.spacing_from = "SpacingBetweenSlices (0018,0088)";
  if (step == 0) {
    step = slice.thickness_mm;
    slice.spacing_from = "SliceThickness (0018,0050)";
  }
  if (step == 0) {
    step = 1;
    slice.has_spacing = false;
  }
  slice.origin_W += normal * (step * slice.frame);
}

void ReadGeometry(FrameElements& elements, DicomSlice& slice) {
  slice.has_geometry = ReadPlane(elements, slice);
  const std::vector<double> position = elements.Numbers(slice.frame, kPlanePosition, kPosition);
  if (position.size() == 3) slice.origin_W = {position[0], position[1], position[2]};
  const bool placed = slice.frames == 1 || elements.FindOwn(slice.frame, kPlanePosition, kPosition) != nullptr;
  if (position.size() != 3 && (placed || !position.empty())) slice.has_geometry = false;
  if (slice.has_geometry && !placed) PlaceFrame(elements, slice);
}

// Sets the stack of each frame. A file with one stack need not call it as the next file of its series does.
void ReadStacks(FrameElements& elements, std::vector<DicomSlice>& slices) {
  constexpr SliceTag kStack{0x0020, 0x9056}, kTime{0x0020, 0x9128};
  bool several = false;
  for (DicomSlice& slice : slices) {
    const gdcm::DataSet* const data = elements.FindOwn(slice.frame, kFrameContent, kStack);
    if (data != nullptr) slice.stack = ReadText(*data, kStack.group, kStack.element);
    several = several || slice.stack != slices.front().stack;
  }
  for (DicomSlice& slice : slices) {
    if (!several) slice.stack.clear();
    const gdcm::DataSet* const data = elements.FindOwn(slice.frame, kFrameContent, kTime);
    const int time = data == nullptr ? 0 : ReadShort(*data, kTime.group, kTime.element);
    if (time > 0) slice.stack += fmt::format("{}time {}", several ? " at " : "", time);
  }
}

// Throws kerf::Error unless the file can contain its frames.
void CheckFrames(const DicomSlice& slice) {
  if (slice.frames == 1) return;
  std::error_code failed;
  const std::uint64_t bytes = std::filesystem::file_size(slice.path, failed);
  const double pixels = static_cast<double>(slice.frames) * slice.size[0] * slice.size[1];
  if (slice.frames > kMaxFrames || failed ||
      pixels * ((slice.bits + 7) / 8) > (slice.compressed ? kMaxUnpackRatio : 1) * static_cast<double>(bytes)) {
    throw Error(fmt::format("{}: its header states {} frames of {} x {} pixels, {}", slice.path, slice.frames,
                            slice.size[0], slice.size[1],
                            slice.frames > kMaxFrames ? fmt::format("more than the {} that kerf reads", kMaxFrames)
                                                      : "but not all are present; the file is cut off"));
  }
}

}  // namespace

std::vector<DicomSlice> ListSlices(const gdcm::Reader& reader, gdcm::StringFilter& filter, const std::string& path) {
  const int rows = GetInteger(filter, 0x0028, 0x0010, 0);
  const int columns = GetInteger(filter, 0x0028, 0x0011, 0);
  if (static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns) > kMaxSlicePixels) {
    throw Error(fmt::format("{}: a slice of {} x {} pixels, more than the 2^26 that kerf reads", path, columns, rows));
  }
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  DicomSlice file;
  file.path = path;
  file.size = {columns, rows};
  file.frames = std::max(1, GetInteger(filter, 0x0028, 0x0008, 1));
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  file.compressed = syntax.IsEncapsulated() || syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  const char* name = gdcm::TransferSyntax::GetTSString(syntax);
  file.transfer_syntax = name == nullptr ? "unknown" : name;
  ReadPixelFormat(data, filter, file);
  CheckFrames(file);

  std::vector<DicomSlice> slices;
  FrameElements elements(data);
  for (int frame = 0; frame < elements.CountFrames(file.frames); ++frame) {
    DicomSlice& slice = slices.emplace_back(file);
    slice.frame = frame;
    ReadRescale(elements, slice);
    ReadGeometry(elements, slice);
  }
  ReadStacks(elements, slices);
  return slices;
}

}  // namespace kerf
