// Leaves near the tool's edge, searched again only after the tool has moved some distance.
#pragma once

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "bone/grid/field.h"
#include "cut/removal/sweep.h"

namespace kerf {

/// List of leaves and their middles, arranged so that several leaves can be tested against a zone at a time.
class LeafList {
 public:
  void Reserve(std::size_t leaves);
  void Clear(const Vec3& origin_W);
  void Add(const LeafIndex& leaf, const Vec3& middle_W);
  std::size_t size() const { return leaves_.size(); }
  std::size_t capacity() const { return leaves_.capacity(); }
  const Vec3& origin_W() const { return origin_W_; }

  /// Calls visit(leaf) for the leaves that may have a voxel in the zone, in the list's order. `cull` must have been
  /// made with this list's origin_W(). Tick-safe.
  template <typename Visit>
  void ForEachNear(const LeafCull& cull, Visit&& visit) {
    FindLeaves(cull, {x_.data(), y_.data(), z_.data()}, static_cast<int>(leaves_.size()), near_.data());
    for (std::size_t word = 0; 64 * word < leaves_.size(); ++word) {
      for (std::uint64_t bits = near_[word]; bits != 0; bits &= bits - 1) {
        visit(leaves_[64 * word + static_cast<std::size_t>(std::countr_zero(bits))]);
      }
    }
  }
  /// Removes the leaves that are not near. Tick-safe.
  void KeepNear(const LeafCull& cull);
  std::size_t CalcMemoryBytes() const;

 private:
  struct alignas(64) Sixteen {
    float values[16];
  };
  struct Floats {
    std::vector<Sixteen> blocks;
    const float* data() const { return blocks.empty() ? nullptr : blocks[0].values; }
    float& operator[](std::size_t i) { return blocks[i / 16].values[i % 16]; }
  };

  Vec3 origin_W_{0};
  std::vector<LeafIndex> leaves_;
  Floats x_;
  Floats y_;
  Floats z_;
  std::vector<std::uint64_t> near_;
};

/// Neighbour lists with slack, like Verlet lists in molecular dynamics. A list of all leaves within `slack` of the zone
/// about the edge stays valid until the tool has moved by that distance. The next list is made in small parts, one in
/// each step before then, so that no single step bears the whole cost.
class EdgeLeaves {
 public:
  /// `zone`: the zone outside of which the edge changes nothing. Allocates.
  EdgeLeaves(const BoneField& field, const EdgeZone& zone);

  /// Makes the list valid for a step to X_WT of length `length_mm` <= slack_mm() / 4. `inner`: also include the leaves
  /// further inside the tool. Returns true if the list is a new one. Tick-safe.
  bool Update(const Pose& X_WT, double length_mm, bool inner);

  /// Invalidates the lists, because leaves may contain bone again. Tick-safe.
  void Forget() { now_.begun = next_.begun = false; }

  double slack_mm() const { return slack_mm_; }
  /// Room for leaves in a list.
  std::size_t capacity() const { return now_.list.capacity(); }
  /// Leaves near the edge that contain bone, or did when the list was made.
  LeafList& list() { return now_.list; }
  std::size_t CalcMemoryBytes() const { return now_.list.CalcMemoryBytes() + next_.list.CalcMemoryBytes(); }

 private:
  struct Search {
    bool begun = false;
    bool inner = false;
    bool inner_requested = false;  // requested since the search began
    Pose X_WT;                     // pose for which the list is made
    int thin = 2;                  // axis along which the tool is searched
    int row = 0;                   // next row to search
    LeafList list;
  };
  bool Covers(const Search& search, const Pose& X_WT, double length_mm, bool inner, double fraction) const;
  void Begin(const Pose& X_WT, bool inner, Search& search) const;
  bool Advance(Search& search, int rows) const;
  void AddRow(Search& search, int i) const;
  std::pair<int, int> Stretch(const Search& search, int axis) const;
  std::pair<int, int> Clip(int axis, double middle_mm, double half_mm) const;

  const BoneField& field_;
  EdgeZone zone_;
  double slack_mm_;
  Search now_;
  Search next_;
};

}  // namespace kerf
