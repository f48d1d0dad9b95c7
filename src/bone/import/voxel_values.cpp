#include "bone/import/voxel_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kerf/error.h"

namespace kerf {

namespace {

constexpr double kMinHu = -32768;
constexpr double kMaxHu = 32767;
constexpr double kWhole = 1e-3;  // distance from a whole number that programs with single precision leave

template <typename T>
Overflow AppendAs(const std::vector<char>& bytes, double slope, double intercept, std::vector<std::int16_t>& out,
                  std::int16_t blank) {
  const std::size_t n = bytes.size() / sizeof(T);
  Overflow overflow;
  out.reserve(out.size() + n);
  for (std::size_t i = 0; i < n; ++i) {
    T raw{};
    std::memcpy(&raw, &bytes[i * sizeof(T)], sizeof(T));
    const double value = slope * static_cast<double>(raw) + intercept;
    if (!std::isfinite(value)) {
      ++overflow.blank;
      overflow.is_blank.resize(n);
      overflow.is_blank[i] = true;
      out.push_back(blank);
      continue;
    }
    const double hu = std::clamp(value, kMinHu, kMaxHu);
    if (hu != value) overflow.Add({.count = 1, .extreme = value});
    const auto stored = static_cast<std::int16_t>(std::lround(hu));
    overflow.rounded |= std::abs(static_cast<double>(stored) - hu) > kWhole;
    out.push_back(stored);
  }
  return overflow;
}

}  // namespace

void CheckOneComponent(unsigned components, const std::string& name) {
  if (components == 1) return;
  throw Error(
      fmt::format("{}: each voxel has {} components (a colour or vector image); kerf needs one HU value per voxel",
                  name, components));
}

std::size_t CalcBytes(VoxelType type) {
  switch (type) {
    case VoxelType::kInt8:
    case VoxelType::kUint8:
      return 1;
    case VoxelType::kInt16:
    case VoxelType::kUint16:
      return 2;
    case VoxelType::kInt32:
    case VoxelType::kUint32:
    case VoxelType::kFloat:
      return 4;
    default:
      return 8;
  }
}

void Overflow::Add(const Overflow& other) {
  count += other.count;
  rounded |= other.rounded;
  blank += other.blank;
  if (std::abs(other.extreme) > std::abs(extreme)) extreme = other.extreme;
}

Overflow AppendHu(const std::vector<char>& bytes, VoxelType type, double slope, double intercept,
                  std::vector<std::int16_t>& out, std::int16_t blank) {
  switch (type) {
    case VoxelType::kInt8:
      return AppendAs<std::int8_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kUint8:
      return AppendAs<std::uint8_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kInt16:
      return AppendAs<std::int16_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kUint16:
      return AppendAs<std::uint16_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kInt32:
      return AppendAs<std::int32_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kUint32:
      return AppendAs<std::uint32_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kInt64:
      return AppendAs<std::int64_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kUint64:
      return AppendAs<std::uint64_t>(bytes, slope, intercept, out, blank);
    case VoxelType::kFloat:
      return AppendAs<float>(bytes, slope, intercept, out, blank);
    case VoxelType::kDouble:
      return AppendAs<double>(bytes, slope, intercept, out, blank);
  }
  throw Error("voxels of an unknown type");
}

std::string Describe(const Overflow& overflow, std::size_t total) {
  return fmt::format(
      "{} of {} voxels lie outside the range of HU that kerf stores, {:.0f} to {:.0f} (the most extreme has {:.4g}), "
      "and were clamped to it; such values are errors in the file or metal",
      overflow.count, total, kMinHu, kMaxHu, overflow.extreme);
}

void AddWarnings(const Overflow& overflow, std::size_t total, std::int16_t blank, std::vector<std::string>& warnings) {
  if (overflow.count > 0) warnings.push_back(Describe(overflow, total));
  if (overflow.blank == 0) return;
  warnings.push_back(fmt::format("{} of {} voxels are not finite numbers (NaN or infinite); they were taken as {}",
                                 overflow.blank, total, blank < 0 ? "air" : "background"));
}

}  // namespace kerf
