// Compressed values of leaves.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace kerf {

/// Values of leaves in the order of their addition, compressed in runs. A leaf of pure bone stores only its index.
class LeafPack {
 public:
  static constexpr std::size_t kRun = 64;  // leaves that are compressed together
  static constexpr std::size_t kLeafBytes = 512 * sizeof(float);

  /// `values`: 512, mm; null for pure bone.
  void Add(const std::array<int, 3>& index, const float* values);
  /// Compresses the leaves of the last, incomplete run.
  void Close();

  /// Calls visit(leaf) for the leaves of pure bone.
  void ForEachInside(const std::function<void(const std::array<int, 3>&)>& visit) const;
  /// Calls visit(leaf, bytes) for each other leaf for which wants(leaf) returns true, in the order of their addition.
  /// `bytes` are kLeafBytes of floats. A run without such a leaf is not unpacked. Throws Error if the stored data is
  /// damaged.
  void ForEachWanted(const std::function<bool(const std::array<int, 3>&)>& wants,
                     const std::function<void(const std::array<int, 3>&, const char*)>& visit) const;

  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  std::size_t CalcMemoryBytes() const;

 private:
  struct Run {
    std::vector<std::array<int, 3>> leaves;
    std::string packed;
  };
  std::vector<std::array<int, 3>> inside_;
  std::vector<Run> runs_;
  Run waiting_;  // incomplete run, not compressed
  std::size_t count_ = 0;
  std::size_t packed_bytes_ = 0;
};

}  // namespace kerf
