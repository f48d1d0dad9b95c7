#include "cut/proximity/leaf_boxes.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr int kEdge = 8;              // edge of a leaf, in voxels
constexpr double kLargeBox_mm = 1.2;  // the faces of a larger box would be too far from the surface inside it

/// Adds a box for the bone in a part of a leaf: voxels `first` to `first` + edge - 1 along each axis.
void AddShrunkBox(const float* values, const LeafIndex& leaf, const LeafIndex& first, int edge, double h,
                  std::vector<Box3>& boxes) {
  Box3 voxels;
  for (int x = first.x; x < first.x + edge; ++x) {
    for (int y = first.y; y < first.y + edge; ++y) {
      for (int z = first.z; z < first.z + edge; ++z) {
        if (values[(x * kEdge + y) * kEdge + z] < 0) voxels.Include(Vec3(x, y, z));
      }
    }
  }
  if (voxels.empty()) return;
  // The surface lies less than one voxel from the centre of an inside voxel.
  const Vec3 origin(kEdge * leaf.x, kEdge * leaf.y, kEdge * leaf.z);
  boxes.push_back({h * (origin + voxels.lower - 1.0), h * (origin + voxels.upper + 1.0)});
}

/// Set of the leaves of a range that are not yet in a box.
class LeafSet {
 public:
  LeafSet(const LeafIndex& lowest, const LeafIndex& highest)
      : lowest_(lowest),
        size_{highest.x - lowest.x + 1, highest.y - lowest.y + 1, highest.z - lowest.z + 1},
        in_(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(size_.z)) {
  }

  void Put(const LeafIndex& leaf, bool in) { in_[At(leaf)] = in; }
  bool Has(const LeafIndex& leaf) const { return in_[At(leaf)]; }
  /// Returns true if all leaves from a to b are in the set.
  bool HasAll(const LeafIndex& a, const LeafIndex& b) const {
    if (b.x >= lowest_.x + size_.x || b.y >= lowest_.y + size_.y || b.z >= lowest_.z + size_.z) return false;
    for (int x = a.x; x <= b.x; ++x) {
      for (int y = a.y; y <= b.y; ++y) {
        for (int z = a.z; z <= b.z; ++z) {
          if (!Has({x, y, z})) return false;
        }
      }
    }
    return true;
  }

 private:
  std::size_t At(const LeafIndex& leaf) const {
    return (static_cast<std::size_t>(leaf.x - lowest_.x) * static_cast<std::size_t>(size_.y) +
            static_cast<std::size_t>(leaf.y - lowest_.y)) *
               static_cast<std::size_t>(size_.z) +
           static_cast<std::size_t>(leaf.z - lowest_.z);
  }

  LeafIndex lowest_;
  LeafIndex size_;
  std::vector<bool> in_;
};

/// Calls visit(leaf) for each leaf from a to b.
template <typename Visit>
void ForEachLeaf(const LeafIndex& a, const LeafIndex& b, Visit&& visit) {
  for (int x = a.x; x <= b.x; ++x) {
    for (int y = a.y; y <= b.y; ++y) {
      for (int z = a.z; z <= b.z; ++z) visit(LeafIndex{x, y, z});
    }
  }
}

}  // namespace

std::vector<Box3> MakeLeafBoxes(const BoneField& field) {
  std::vector<Box3> boxes;
  const LeafIndex lowest = field.lowest();
  const LeafIndex highest = field.highest();
  if (highest.x < lowest.x || highest.y < lowest.y || highest.z < lowest.z) return boxes;
  const double h = field.voxel_mm();
  const int part = kEdge * h > kLargeBox_mm ? kEdge / 2 : kEdge;
  LeafSet inside(lowest, highest);
  ForEachLeaf(lowest, highest, [&](const LeafIndex& leaf) {
    const BoneField::LeafKind kind = field.kind(leaf);
    inside.Put(leaf, kind == BoneField::LeafKind::kInside);
    if (kind != BoneField::LeafKind::kOwn) return;
    for (int x = 0; x < kEdge; x += part) {
      for (int y = 0; y < kEdge; y += part) {
        for (int z = 0; z < kEdge; z += part) AddShrunkBox(field.Read(leaf), leaf, {x, y, z}, part, h, boxes);
      }
    }
  });
  ForEachLeaf(lowest, highest, [&](const LeafIndex& leaf) {
    if (!inside.Has(leaf)) return;
    LeafIndex last = leaf;
    while (inside.HasAll({leaf.x, leaf.y, last.z + 1}, {leaf.x, leaf.y, last.z + 1})) ++last.z;
    while (inside.HasAll({leaf.x, last.y + 1, leaf.z}, {leaf.x, last.y + 1, last.z})) ++last.y;
    while (inside.HasAll({last.x + 1, leaf.y, leaf.z}, {last.x + 1, last.y, last.z})) ++last.x;
    ForEachLeaf(leaf, last, [&](const LeafIndex& joined) { inside.Put(joined, false); });
    const Vec3 a(leaf.x, leaf.y, leaf.z);
    const Vec3 b(last.x, last.y, last.z);
    boxes.push_back({h * (double{kEdge} * a - 1.0), h * (double{kEdge} * (b + 1.0))});
  });
  return boxes;
}

}  // namespace kerf
