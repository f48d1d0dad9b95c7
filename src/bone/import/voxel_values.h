// Conversion of the values of an image file to HU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

enum class VoxelType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };

/// Throws kerf::Error, with `name` in the message, if a voxel has more than one value.
void CheckOneComponent(unsigned components, const std::string& name);

/// Returns the number of bytes of one value.
std::size_t CalcBytes(VoxelType type);

/// Values that did not fit into a volume's 16 bits and were clamped.
struct Overflow {
  std::size_t count = 0;
  double extreme = 0;               // the value farthest from 0
  bool rounded = false;             // other values were not integers and were rounded
  std::size_t blank = 0;            // values that are not finite numbers
  std::vector<bool> is_blank = {};  // of each value; empty if none is
  void Add(const Overflow& other);
};

/// CT number of what was not scanned.
inline constexpr std::int16_t kBlankHu = -1024;

/// Appends slope * value + intercept, rounded, of each value in `bytes` (in this machine's byte order) to `out`. Values
/// that are not finite numbers become `blank`.
Overflow AppendHu(const std::vector<char>& bytes, VoxelType type, double slope, double intercept,
                  std::vector<std::int16_t>& out, std::int16_t blank = kBlankHu);

/// Returns one sentence for a report. `total`: number of values read.
std::string Describe(const Overflow& overflow, std::size_t total);

/// Adds a sentence for values that were clamped, and one for those that became `blank`.
void AddWarnings(const Overflow& overflow, std::size_t total, std::int16_t blank, std::vector<std::string>& warnings);

}  // namespace kerf
