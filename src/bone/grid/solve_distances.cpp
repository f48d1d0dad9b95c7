#include "bone/grid/solve_distances.h"

#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "bone/grid/dilate.h"
#include "bone/grid/grids.h"
#include "bone/grid/leaf_mask.h"

namespace kerf {
namespace {

using openvdb::Coord;
using openvdb::Index;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr float kUnsolved = std::numeric_limits<float>::max();
constexpr float kKnown = 1000;  // as in OpenVDB: a neighbour with a larger value has no distance yet

/// The values of a leaf and of the six layers that adjoin it.
class HaloBlock {
 public:
  static constexpr int kWide = kLeafEdge + 2;
  static constexpr std::array<int, 3> kStride{kWide * kWide, kWide, 1};
  static constexpr int At(int x, int y, int z) { return (x + 1) * kStride[0] + (y + 1) * kStride[1] + z + 1; }

  float& operator[](int at) { return values_[static_cast<std::size_t>(at)]; }
  float operator[](int at) const { return values_[static_cast<std::size_t>(at)]; }
  /// The neighbour in direction `i`: -x, +x, -y, +y, -z, +z.
  float Beside(int at, int i) const {
    return (*this)[at + (i % 2 == 0 ? -1 : 1) * kStride[static_cast<std::size_t>(i / 2)]];
  }

 private:
  std::array<float, kWide * kWide * kWide> values_{};
};

template <typename Visit>
void ForEachVoxel(Visit&& visit) {
  for (int x = 0; x < kLeafEdge; ++x) {
    for (int y = 0; y < kLeafEdge; ++y) {
      for (int z = 0; z < kLeafEdge; ++z)
        visit(static_cast<Index>((x * kLeafEdge + y) * kLeafEdge + z), HaloBlock::At(x, y, z));
    }
  }
}

/// The leaves of a tree with the neighbours of each.
class FieldLeaves {
 public:
  explicit FieldLeaves(FloatTree& tree) {
    tree.getNodes(leaves_);
    around_.resize(leaves_.size());
    std::vector<std::pair<Coord, int>> places;
    places.reserve(leaves_.size());
    for (std::size_t n = 0; n < leaves_.size(); ++n) places.emplace_back(leaves_[n]->origin(), static_cast<int>(n));
    std::sort(places.begin(), places.end());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves_.size(), 256), [&](const auto& range) {
      const openvdb::tree::ValueAccessor<const FloatTree> value(tree);
      for (std::size_t n = range.begin(); n < range.end(); ++n) {
        for (std::size_t i = 0; i < 6; ++i) {
          Coord origin = leaves_[n]->origin();
          origin[static_cast<int>(i / 2)] += i % 2 == 0 ? -kLeafEdge : kLeafEdge;
          const auto found = std::lower_bound(places.begin(), places.end(), std::pair(origin, 0));
          const bool is_leaf = found != places.end() && found->first == origin;
          around_[n][i] = {is_leaf ? found->second : -1, is_leaf ? 0 : value.getValue(origin)};
        }
      }
    });
  }

  std::size_t size() const { return leaves_.size(); }
  FloatLeaf& leaf(std::size_t n) const { return *leaves_[n]; }
  /// The leaf beside a leaf in direction `i`, as in HaloBlock; -1: none.
  int Beside(std::size_t n, std::size_t i) const { return around_[n][i].leaf; }

  /// Loads the values of the leaf and beside it.
  void Load(std::size_t n, HaloBlock& block) const {
    Load(
        n, block, [](float value) { return value; }, [](float tile) { return tile; });
  }
  /// Loads of(value) for each of them; of_tile(value) where there is no leaf.
  template <typename Of, typename OfTile>
  void Load(std::size_t n, HaloBlock& block, Of&& of, OfTile&& of_tile) const {
    const float* const own = leaves_[n]->buffer().data();
    ForEachVoxel([&](Index i, int at) { block[at] = of(own[i]); });
    for (std::size_t i = 0; i < 6; ++i) {
      const LeafBeside& around = around_[n][i];
      const float* const values =
          around.leaf < 0 ? nullptr : leaves_[static_cast<std::size_t>(around.leaf)]->buffer().data();
      const std::size_t axis = i / 2;
      const int u = HaloBlock::kStride[(axis + 1) % 3], v = HaloBlock::kStride[(axis + 2) % 3];
      constexpr std::array<int, 3> kLeafStride{kLeafEdge * kLeafEdge, kLeafEdge, 1};
      const int from_u = kLeafStride[(axis + 1) % 3], from_v = kLeafStride[(axis + 2) % 3];
      const int from = i % 2 == 0 ? (kLeafEdge - 1) * kLeafStride[axis] : 0;
      const int to = HaloBlock::At(0, 0, 0) + (i % 2 == 0 ? -1 : kLeafEdge) * HaloBlock::kStride[axis];
      for (int a = 0; a < kLeafEdge; ++a) {
        for (int b = 0; b < kLeafEdge; ++b) {
          block[to + a * u + b * v] =
              values == nullptr ? of_tile(around.tile) : of(values[from + a * from_u + b * from_v]);
        }
      }
    }
  }

 private:
  struct LeafBeside {
    int leaf;    // -1: none
    float tile;  // value there if there is no leaf
  };

  std::vector<FloatLeaf*> leaves_;
  std::vector<std::array<LeafBeside, 6>> around_;
};

/// Returns the distance of a voxel to the zero level if it is beside a change of sign.
bool FindDistance(const HaloBlock& block, int at, float voxel_mm, float& distance) {
  const float value = block[at];
  bool is_beside = false;
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float d = kUnsolved;
    for (int i = 2 * axis; i < 2 * axis + 2; ++i) {
      const float other = block.Beside(at, i);
      if ((value < 0) == (other < 0)) continue;
      is_beside = true;
      d = std::min(d, std::abs(value / (value - other)));
    }
    if (d < kUnsolved) sum += 1 / (d * d);
  }
  if (!is_beside) return false;
  distance = voxel_mm / std::sqrt(sum);
  if (openvdb::math::isApproxZero(value)) {
    distance = 0;
  } else if (!(value > 0)) {
    distance = -distance;
  }
  return true;
}

/// Sets the values beside a change of sign, whose voxels become inactive, and all others to +-kUnsolved.
bool SetFirstDistances(const FieldLeaves& leaves, float voxel_mm) {
  std::vector<std::array<float, FloatLeaf::SIZE>> values(leaves.size());
  std::vector<openvdb::util::NodeMask<3>> to_solve(leaves.size());
  std::atomic<bool> any = false;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 16), [&](const auto& range) {
    HaloBlock block;
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      leaves.Load(n, block);
      to_solve[n] = leaves.leaf(n).getValueMask();
      ForEachVoxel([&](Index i, int at) {
        values[n][i] = block[at] > 0 ? kUnsolved : -kUnsolved;
        if (!to_solve[n].isOn(i) || !FindDistance(block, at, voxel_mm, values[n][i])) return;
        to_solve[n].setOff(i);
        any = true;
      });
    }
  });
  if (!any) return false;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 64), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      std::copy(values[n].begin(), values[n].end(), leaves.leaf(n).buffer().data());
      leaves.leaf(n).setValueMask(to_solve[n]);
    }
  });
  return true;
}

/// Returns the solution x of [x - a]^2 + [x - b]^2 + [x - c]^2 = h^2, where [y] = max(y, 0) (Godunov's scheme);
/// kUnsolved if there is none. Operations as in OpenVDB.
float SolveGodunov(float a, float b, float c, float h, float sqrt2h) {
  if (b < a) std::swap(a, b);
  if (c < b) std::swap(b, c);
  if (b < a) std::swap(a, b);
  if (a + h <= b) return a + h;
  if (b <= sqrt2h + a) {
    const float x = 0.5f * (a + b + std::sqrt(2.0f * h * h - (a - b) * (a - b)));
    if (x > b && x <= c) return x;
  }
  const float sum = a + b + c;
  const float d = sum * sum - 3.0f * (a * a + b * b + c * c - h * h);
  return d >= 0 ? static_cast<float>(1.0 / 3.0) * (sum + std::sqrt(d)) : kUnsolved;
}

/// The voxels of each leaf that are to be solved and whose neighbours have changed since that was last done. Solving
/// the others would give the distance that they have.
class DueVoxels {
 public:
  explicit DueVoxels(const FieldLeaves& leaves) : leaves_(leaves), due_(leaves.size()) {
    for (std::size_t n = 0; n < due_.size(); ++n) {
      for (std::size_t x = 0; x < 8; ++x) due_[n][x] = ToSolve(n, x);
    }
  }

  /// Moves the due voxels of a leaf, none of whose neighbours is being swept, to `due`. Returns whether there are any.
  bool Take(std::size_t n, LeafMask& due) {
    for (std::size_t x = 0; x < 8; ++x) due[x] = due_[n][x].exchange(0, std::memory_order_relaxed);
    return !IsEmpty(due);
  }
  /// Adds voxels; may be called for one leaf by several threads.
  void Add(std::size_t n, const LeafMask& due) {
    for (std::size_t x = 0; x < 8; ++x) {
      if (const std::uint64_t added = due[x] & ToSolve(n, x)) due_[n][x].fetch_or(added, std::memory_order_relaxed);
    }
  }

 private:
  std::uint64_t ToSolve(std::size_t n, std::size_t x) const {
    return leaves_.leaf(n).getValueMask().getWord<std::uint64_t>(static_cast<Index>(x));
  }

  const FieldLeaves& leaves_;
  std::vector<std::array<std::atomic<std::uint64_t>, 8>> due_;
};

/// Sweeps the due voxels of one leaf along the diagonal: by increasing `side[i]` times the i-th coordinate.
void SweepLeaf(const FieldLeaves& leaves, DueVoxels& all_due, std::size_t n, const std::array<int, 3>& side, float h) {
  LeafMask due;
  if (!all_due.Take(n, due)) return;
  FloatLeaf& leaf = leaves.leaf(n);
  LeafMask changed{};
  const float sqrt2h = std::sqrt(2.0f) * h;
  HaloBlock block;
  leaves.Load(
      n, block, [](float value) { return std::abs(value); }, [](float) { return kUnsolved; });
  float* const values = leaf.buffer().data();
  const auto& to_solve = leaf.getValueMask();
  const auto ordered = [&](std::size_t axis, int i) { return side[axis] > 0 ? i : kLeafEdge - 1 - i; };
  for (int i = 0; i < kLeafEdge; ++i) {
    const int x = ordered(0, i);
    for (int j = 0; j < kLeafEdge; ++j) {
      const int y = ordered(1, j);
      std::uint64_t& layer = due[static_cast<std::size_t>(x)];
      if ((layer >> 8 * y & 0xff) == 0) continue;
      for (int k = 0; k < kLeafEdge; ++k) {
        const int z = ordered(2, k);
        const auto own = static_cast<Index>((x * kLeafEdge + y) * kLeafEdge + z);
        const std::uint64_t bit = std::uint64_t{1} << own % 64;
        if ((layer & bit) == 0) continue;
        layer &= ~bit;
        const int at = HaloBlock::At(x, y, z);
        const float a = std::min(block.Beside(at, 0), block.Beside(at, 1));
        const float b = std::min(block.Beside(at, 2), block.Beside(at, 3));
        const float c = std::min(block.Beside(at, 4), block.Beside(at, 5));
        if (!(a < kKnown || b < kKnown || c < kKnown)) continue;
        const float distance = SolveGodunov(a, b, c, h, sqrt2h);
        if (!(distance < block[at])) continue;
        block[at] = distance;
        values[own] = values[own] >= 0 ? distance : -distance;
        changed[static_cast<std::size_t>(x)] |= bit;
        layer |= GrownInLayer(bit) & ~bit & to_solve.getWord<std::uint64_t>(static_cast<Index>(x));
        for (const int beside : {x - 1, x + 1}) {
          if (beside < 0 || beside >= kLeafEdge || !to_solve.isOn(static_cast<Index>(64 * beside) + own % 64)) continue;
          due[static_cast<std::size_t>(beside)] |= bit;
        }
      }
    }
  }
  all_due.Add(n, due);
  for (std::size_t i = 0; i < 6; ++i) {
    if (const int beside = leaves.Beside(n, i); beside >= 0)
      all_due.Add(static_cast<std::size_t>(beside), Across(changed, i));
  }
}

/// Sweeps all leaves along the diagonal, there and back. A voxel needs the values of this sweep on its near side and
/// those of the last on its far side, so that leaves of one diagonal plane do not depend on each other.
void SweepBothWays(const FieldLeaves& leaves, DueVoxels& due, const std::array<int, 3>& side, float h) {
  std::vector<std::pair<int, std::size_t>> order;
  order.reserve(leaves.size());
  for (std::size_t n = 0; n < leaves.size(); ++n) {
    const Coord& origin = leaves.leaf(n).origin();
    order.emplace_back((side[0] * origin.x() + side[1] * origin.y() + side[2] * origin.z()) / kLeafEdge, n);
  }
  for (const int way : {1, -1}) {
    if (way < 0) {
      for (auto& [plane, n] : order) plane = -plane;
    }
    std::sort(order.begin(), order.end());
    for (std::size_t first = 0; first < order.size();) {
      const auto end = static_cast<std::size_t>(
          std::upper_bound(order.begin(), order.end(), std::pair(order[first].first, leaves.size())) - order.begin());
      tbb::parallel_for(tbb::blocked_range<std::size_t>(first, end, 4), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          SweepLeaf(leaves, due, order[i].second, {way * side[0], way * side[1], way * side[2]}, h);
        }
      });
      first = end;
    }
  }
}

}  // namespace

bool SolveDistances(FloatTree& field, float voxel_mm) {
  const FieldLeaves leaves(field);
  if (!SetFirstDistances(leaves, voxel_mm)) return false;
  DueVoxels due(leaves);
  for (const std::array<int, 3>& side : {std::array{1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {1, -1, -1}}) {
    SweepBothWays(leaves, due, side, voxel_mm);
  }
  return true;
}

void KeepNearSurface(FloatTree& field, int voxels) {
  openvdb::MaskTree near(field, false, openvdb::TopologyCopy());
  {
    const FieldLeaves leaves(field);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 16), [&](const auto& range) {
      openvdb::tree::ValueAccessor<openvdb::MaskTree> mask(near);
      HaloBlock block;
      for (std::size_t n = range.begin(); n < range.end(); ++n) {
        leaves.Load(n, block);
        auto* const leaf = mask.probeLeaf(leaves.leaf(n).origin());
        if (leaf == nullptr) continue;
        leaf->setValuesOff();
        ForEachVoxel([&](Index i, int at) {
          for (int side = 0; side < 6; ++side) {
            if ((block[at] < 0) != (block.Beside(at, side) < 0)) leaf->setValueOn(i);
          }
        });
      }
    });
  }
  // FieldLeaves whose voxels all become active may turn into tiles.
  Dilate(near, voxels, openvdb::tools::NN_FACE_EDGE);
  openvdb::tree::LeafManager<FloatTree> leaves(field);
  leaves.foreach ([&near](FloatLeaf& leaf, std::size_t) {
    const auto* mask = near.probeConstLeaf(leaf.origin());
    if (mask == nullptr) {
      if (!near.isValueOn(leaf.origin())) leaf.setValuesOff();
      return;
    }
    leaf.setValueMask(mask->getValueMask());
  });
}

}  // namespace kerf
