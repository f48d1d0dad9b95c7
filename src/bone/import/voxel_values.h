// The numbers of an image file as HU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

enum class VoxelType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };

/// Throws Error naming `name` when a voxel has more than one value.
void CheckOneComponent(unsigned components, const std::string& name);

/// Bytes of one value.
std::size_t CalcBytes(VoxelType type);

/// Values that do not fit into the 16 bits that a volume has for HU, and were held to their range.
struct Overflow {
  std::size_t count = 0;
  double extreme = 0;  // the one farthest from 0
  void Add(const Overflow& other);
};

/// Appends slope * value + intercept, rounded, of each value in `bytes` (in this machine's byte order) to `out`. Throws
/// Error naming `name` when values are not finite numbers.
Overflow AppendHu(const std::vector<char>& bytes, VoxelType type, double slope, double intercept,
                  const std::string& name, std::vector<std::int16_t>& out);

/// One sentence for a report; `total` values were read.
std::string Describe(const Overflow& overflow, std::size_t total);

}  // namespace kerf
