#include "session/link/igtl_bone.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/import/patient_frame.h"
#include "kerf/error.h"
#include "session/link/igtl_bytes.h"

namespace kerf {
namespace {

constexpr const char* kImage = "the image kerf_bone";
constexpr const char* kSurface = "the surface kerf_bone";

/// Bytes of an IMAGE before its voxels: where its fields begin.
constexpr std::size_t kComponentsAt = 2, kScalarAt = 3, kEndianAt = 4, kFrameAt = 5, kSizeAt = 6, kStepsAt = 12,
                      kCentreAt = 48, kPartAt = 60, kImageBytes = 72;
constexpr std::uint8_t kBig = 1, kLittle = 2;
constexpr std::uint8_t kRas = 1, kLps = 2;

/// Returns the bytes of a whole number of that type of IMAGE.
std::size_t CountScalarBytes(std::uint8_t type) {
  switch (type) {
    case 2:
    case 3:
      return 1;
    case 4:
    case 5:
      return 2;
    case 6:
    case 7:
      return 4;
    case 10:
    case 11:
      throw Error(fmt::format("{} has values with decimals; send a label map", kImage));
    default:
      throw Error(fmt::format("{} has values of the unknown type {}", kImage, type));
  }
}

std::array<int, 3> ReadSize(std::span<const std::uint8_t> content, std::size_t at) {
  std::array<int, 3> size{};
  for (std::size_t a = 0; a < 3; ++a) size[a] = ReadBig<std::uint16_t>(content, at + 2 * a);
  return size;
}

Vec3 ReadVector(std::span<const std::uint8_t> content, std::size_t at, const char* what) {
  const Vec3 v(ReadBigFloat(content, at), ReadBigFloat(content, at + 4), ReadBigFloat(content, at + 8));
  for (int a = 0; a < 3; ++a) {
    if (!std::isfinite(v[a])) throw Error(fmt::format("{} has a number that is not finite", what));
  }
  return v;
}

/// Sets the lattice. The message gives the steps from voxel to voxel, and the middle between the first and the last
/// one.
void Place(std::span<const std::uint8_t> content, Volume& volume) {
  glm::dmat3 steps(0);
  for (int a = 0; a < 3; ++a) {
    steps[a] = ReadVector(content, kStepsAt + 12 * static_cast<std::size_t>(a), kImage);
    if (!(glm::length(steps[a]) > 0))
      throw Error(fmt::format("{} has voxels without size along axis {}", kImage, a + 1));
  }
  Vec3 first = ReadVector(content, kCentreAt, kImage);
  for (int a = 0; a < 3; ++a) first -= 0.5 * (volume.size[static_cast<std::size_t>(a)] - 1) * steps[a];
  const std::uint8_t frame = content[kFrameAt];
  if (frame != kRas && frame != kLps) throw Error(fmt::format("{} is neither in RAS nor in LPS", kImage));
  volume.frame = frame == kRas ? "RAS" : "LPS";
  PlaceLattice(first, steps, 1, volume);
  volume.frame = "LPS";
  CheckLattice(volume, kImage);
}

/// Reads the voxels: 1 for the label, which is the only value other than 0.
std::vector<std::int16_t> ReadLabels(std::span<const std::uint8_t> voxels, std::size_t bytes, bool little) {
  std::vector<std::int16_t> labels(voxels.size() / bytes);
  std::optional<std::uint32_t> label;
  for (std::size_t v = 0; v < labels.size(); ++v) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      value = value << 8 | voxels[v * bytes + (little ? bytes - 1 - i : i)];
    }
    if (value == 0) continue;
    if (!label) label = value;
    if (value != *label) {
      throw Error(fmt::format("{} has several labels; send a label map with the bone alone", kImage));
    }
    labels[v] = 1;
  }
  if (!label) throw Error(fmt::format("{} is empty: all its voxels are 0", kImage));
  return labels;
}

/// Reads lists of indices of points: their number, then the indices.
class IndexLists {
 public:
  IndexLists(std::span<const std::uint8_t> bytes, std::uint32_t points) : bytes_(bytes), points_(points) {}

  bool is_at_end() const { return at_ == bytes_.size(); }
  std::vector<std::uint32_t> Next() {
    std::vector<std::uint32_t> list(ReadNumber());
    for (std::uint32_t& index : list) {
      index = ReadBig<std::uint32_t>(bytes_, at_);
      at_ += 4;
      if (index >= points_) {
        throw Error(fmt::format("{} refers to point {}, but has {} points", kSurface, index, points_));
      }
    }
    return list;
  }

 private:
  std::uint32_t ReadNumber() {
    const std::size_t left = (bytes_.size() - at_) / 4;
    const std::uint32_t count = left == 0 ? 0 : ReadBig<std::uint32_t>(bytes_, at_);
    if (left == 0 || count > left - 1) throw Error(fmt::format("{} is cut off", kSurface));
    at_ += 4;
    return count;
  }

  std::span<const std::uint8_t> bytes_;
  std::uint32_t points_;
  std::size_t at_ = 0;
};

void AddTriangle(const std::array<std::uint32_t, 3>& triangle, TriangleMesh& mesh) {
  if (mesh.triangles.size() >= kMaxBoneTriangles) {
    throw Error(fmt::format("{} has more than {} triangles; simplify it", kSurface, kMaxBoneTriangles));
  }
  mesh.triangles.push_back(triangle);
}

}  // namespace

Volume ReadIgtlLabelMap(std::span<const std::uint8_t> content) {
  if (content.size() < kImageBytes) throw Error(fmt::format("{} is cut off", kImage));
  if (content[kComponentsAt] != 1) {
    throw Error(fmt::format("{} has {} values per voxel; a label map has one", kImage, content[kComponentsAt]));
  }
  const std::size_t scalar_bytes = CountScalarBytes(content[kScalarAt]);
  const std::uint8_t endian = content[kEndianAt];
  if (endian != kBig && endian != kLittle) throw Error(fmt::format("{} has the unknown byte order {}", kImage, endian));
  Volume volume;
  volume.size = ReadSize(content, kSizeAt);
  const std::size_t count = volume.count();
  if (count == 0 || count > kMaxBoneVoxels) {
    throw Error(fmt::format("{} has {} x {} x {} voxels; the limits are 1 and {} in all", kImage, volume.size[0],
                            volume.size[1], volume.size[2], kMaxBoneVoxels));
  }
  if (ReadSize(content, kPartAt) != std::array{0, 0, 0} || ReadSize(content, kPartAt + 6) != volume.size) {
    throw Error(fmt::format("{} is a part of a larger one; send it as a whole", kImage));
  }
  if (content.size() != kImageBytes + count * scalar_bytes) {
    throw Error(fmt::format("{} has {} bytes of voxels instead of {}", kImage, content.size() - kImageBytes,
                            count * scalar_bytes));
  }
  Place(content, volume);
  volume.hu = ReadLabels(content.subspan(kImageBytes), scalar_bytes, endian == kLittle);
  return volume;
}

TriangleMesh ReadIgtlSurface(std::span<const std::uint8_t> content) {
  constexpr std::size_t kHeadBytes = 40;
  constexpr std::size_t kPointBytes = 12;
  constexpr std::size_t kAttributeBytes = 6;  // at least
  if (content.size() < kHeadBytes) throw Error(fmt::format("{} is cut off", kSurface));
  // Number of points; number and bytes of vertices, lines, polygons and strips; number of attributes.
  const auto number = [&](std::size_t i) { return ReadBig<std::uint32_t>(content, 4 * i); };
  std::uint64_t bytes = kHeadBytes + std::uint64_t{kPointBytes} * number(0);
  const auto take = [&](std::uint64_t more) { return std::exchange(bytes, bytes + more); };
  take(number(2));
  take(number(4));
  const std::uint64_t polygons_at = take(number(6)), strips_at = take(number(8));
  take(std::uint64_t{kAttributeBytes} * number(9));
  if (bytes > content.size()) throw Error(fmt::format("{} is cut off", kSurface));
  if (number(9) == 0 && bytes < content.size()) {
    throw Error(fmt::format("{} has {} bytes too many", kSurface, content.size() - bytes));
  }
  if (number(0) > 3 * kMaxBoneTriangles) throw Error(fmt::format("{} has {} points; simplify it", kSurface, number(0)));
  TriangleMesh mesh;
  mesh.points.reserve(number(0));
  for (std::size_t i = 0; i < number(0); ++i) {
    mesh.points.push_back(TurnRas(ReadVector(content, kHeadBytes + kPointBytes * i, kSurface)));
  }
  for (IndexLists lists(content.subspan(polygons_at, number(6)), number(0)); !lists.is_at_end();) {
    const std::vector<std::uint32_t> polygon = lists.Next();
    for (std::size_t i = 2; i < polygon.size(); ++i) AddTriangle({polygon[0], polygon[i - 1], polygon[i]}, mesh);
  }
  for (IndexLists lists(content.subspan(strips_at, number(8)), number(0)); !lists.is_at_end();) {
    const std::vector<std::uint32_t> strip = lists.Next();
    for (std::size_t i = 2; i < strip.size(); ++i) {
      const bool odd = i % 2 == 1;
      AddTriangle({strip[i - (odd ? 1 : 2)], strip[i - (odd ? 2 : 1)], strip[i]}, mesh);
    }
  }
  if (mesh.triangles.empty()) throw Error(fmt::format("{} has no polygons", kSurface));
  return mesh;
}

}  // namespace kerf
