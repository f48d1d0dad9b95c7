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
  double extreme = 0;    // the value farthest from 0
  bool rounded = false;  // other values were not within 1e-3 of integers and were rounded
  void Add(const Overflow& other);
};

/// Appends slope * value + intercept, rounded, of each value in `bytes` (in this machine's byte order) to `out`. Throws
/// kerf::Error, with `name` in the message, if values are not finite numbers.
Overflow AppendHu(const std::vector<char>& bytes, VoxelType type, double slope, double intercept,
                  const std::string& name, std::vector<std::int16_t>& out);

/// Returns one sentence for a report. `total`: number of values read.
std::string Describe(const Overflow& overflow, std::size_t total);

}  // namespace kerf
