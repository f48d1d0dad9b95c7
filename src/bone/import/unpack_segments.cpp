#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "bone/import/limits.h"
#include "bone/import/packed_segments.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxShort = 65535;

// The child process may have returned anything, if a damaged file changed what the library does. Throws
// std::out_of_range for anything but a whole number from 0 to `max`.
std::uint64_t TakeCount(const Json& json, std::uint64_t max) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > max) throw std::out_of_range("a number");
  return json.get<std::uint64_t>();
}
int TakeShort(const Json& json) {
  return static_cast<int>(TakeCount(json, kMaxShort));
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
  read.size = {TakeShort(json.at("size").at(0)), TakeShort(json.at("size").at(1))};
  const std::vector<double> spacing = numbers("spacing", 2);
  if (!(spacing[0] > 0 && spacing[1] > 0)) {
    throw Error(
        fmt::format("{}: the distances between the segmentation's pixels are {:g} and {:g} mm; they must be "
                    "larger than 0",
                    path, spacing[0], spacing[1]));
  }
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
  const bool label_map = json.value("label_map", false);
  std::set<int> numbers;
  for (const Json& item : json.at("segments")) {
    DicomSegment& segment = read.segments.emplace_back();
    segment.number = TakeShort(item.at("number"));
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
    const int number = TakeShort(item.at("segment"));
    const std::size_t nth = read.frames.size() + 1;
    if (position.size() != 3 || !IsInWorld(ToVec3(position))) {
      throw Error(fmt::format("{}: frame {} of the segmentation has no valid position", path, nth));
    }
    if (!label_map && numbers.count(number) == 0) {
      throw Error(
          fmt::format("{}: frame {} belongs to segment {}, which the file does not describe", path, nth, number));
    }
    read.frames.push_back({number, ToVec3(position)});
  }
}

// Throws kerf::Error unless `bytes` bytes are enough for the pixels of all frames, with `bits` bits each.
void CheckPixels(const DicomSegments& read, std::uint64_t bytes, int bits, bool fractional, bool label_map,
                 const std::string& path) {
  const bool known = bits == 8 || (label_map && bits == 16) || (!label_map && !fractional && bits == 1);
  if (!known) {
    throw Error(fmt::format("{}: the segmentation's pixels have {} bits; kerf reads {}", path, bits,
                            label_map    ? "label maps with 8 or 16 bits"
                            : fractional ? "fractional segmentations with 8 bits"
                                         : "binary segmentations with 1 or 8 bits"));
  }
  const std::uint64_t pixels = std::uint64_t{read.frames.size()} * static_cast<std::uint64_t>(read.size[0]) *
                               static_cast<std::uint64_t>(read.size[1]);
  if (pixels == 0) throw Error(fmt::format("{}: the segmentation has no pixels", path));
  if (pixels > kMaxVoxels) throw Error(fmt::format("{}: the segmentation has more than 2^31 pixels", path));
  const std::uint64_t needed = (pixels * static_cast<unsigned>(bits) + 7) / 8;
  if (bytes < needed) {
    throw Error(
        fmt::format("{}: the file is cut off or damaged: its {} frames of {} x {} pixels need {} bytes, but it "
                    "has {}",
                    path, read.frames.size(), read.size[0], read.size[1], needed, bytes));
  }
}

// Sets the pixels of a segmentation with frames for each segment. A `fraction` of 0: it is binary.
void TakePixels(std::span<const char> bytes, int bits, int fraction, double threshold, DicomSegments& read) {
  const auto* raw = reinterpret_cast<const unsigned char*>(bytes.data());
  const double least = threshold * fraction;
  bool is_soft = false;
  for (std::size_t i = 0; i < read.pixels.size(); ++i) {
    if (bits == 1) {
      read.pixels[i] = raw[i / 8] >> (i % 8) & 1;
      continue;
    }
    read.pixels[i] = raw[i] > 0 && raw[i] >= least ? 1 : 0;
    is_soft |= fraction > 0 && raw[i] > 0 && raw[i] < fraction;
  }
  if (is_soft) {
    read.warnings.push_back(
        fmt::format("the segmentation is fractional: the voxels of its segments are those from {:g} of its range on; "
                    "to change this, use --mask-threshold",
                    threshold));
  }
}

DicomSegments Unpack(const Json& json, std::span<const char> pixels, double threshold, const std::string& path) {
  DicomSegments read;
  TakeLattice(json, path, read);
  TakeFrames(json, path, read);
  if (const auto series = json.find("series"); series != json.end()) series->get_to(read.series_uid);
  read.frame_uid = json.value("frame", "");
  const int bits = TakeShort(json.at("bits")), fraction = TakeShort(json.at("fraction"));
  const bool label_map = json.value("label_map", false);
  const std::uint64_t bytes = TakeCount(json.at("bytes"), pixels.size());
  CheckPixels(read, bytes, bits, fraction > 0, label_map, path);
  const std::size_t count =
      read.frames.size() * static_cast<std::size_t>(read.size[0]) * static_cast<std::size_t>(read.size[1]);
  if (!label_map) {
    read.pixels.resize(count);
    TakePixels(pixels, bits, fraction, threshold, read);
    return read;
  }
  const int background = json.contains("padding") ? TakeShort(json.at("padding")) : 0;
  const auto* raw = reinterpret_cast<const unsigned char*>(pixels.data());
  read.labels.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int label = bits == 8 ? raw[i] : raw[2 * i] + 256 * raw[2 * i + 1];
    read.labels[i] = static_cast<std::uint16_t>(label == background ? 0 : label);
  }
  return read;
}

}  // namespace

DicomSegments UnpackSegments(const std::string& packed, std::span<const char> pixels, double threshold,
                             const std::string& path) {
  const auto refuse = [&path] {
    return Error(fmt::format("{}: the file is damaged: the library that reads it returned no segmentation", path));
  };
  try {
    return Unpack(Json::parse(packed), pixels, threshold, path);
  } catch (const Json::exception&) {
    throw refuse();
  } catch (const std::out_of_range&) {
    throw refuse();
  }
}

}  // namespace kerf
