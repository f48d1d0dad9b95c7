// Leaves by their values, compressed.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace kerf {

/// Leaves in the order in which they came, many of them compressed together. A leaf of pure bone takes its number only.
class LeafPack {
 public:
  static constexpr std::size_t kRun = 64;  // leaves compressed together
  static constexpr std::size_t kLeafBytes = 512 * sizeof(float);

  /// `values`: 512, null for pure bone.
  void Add(const std::array<int, 3>& index, const float* values);
  /// Compresses what waits.
  void Close();

  /// Calls visit(leaf) for those of pure bone.
  void ForEachInside(const std::function<void(const std::array<int, 3>&)>& visit) const;
  /// Calls visit(leaf, bytes) for the others, kLeafBytes of floats, in the order in which they came. Only runs of which
  /// wants(leaf) is true for a leaf are unpacked, and only those leaves visited. Throws Error when what is kept is
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
  Run waiting_;  // its values are not packed
  std::size_t count_ = 0;
  std::size_t packed_bytes_ = 0;
};

}  // namespace kerf
