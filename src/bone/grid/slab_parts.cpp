#include "bone/grid/slab_parts.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>

#include "bone/grid/cell_block.h"
#include "bone/grid/cell_volume.h"
#include "bone/grid/dilate.h"
#include "bone/grid/grids.h"
#include "bone/grid/slab_section.h"
#include "bone/grid/slice_surface.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;
using SliceLeaves = std::vector<std::unique_ptr<FloatLeaf>>;

constexpr std::size_t kMaxSliceBlocks = std::size_t{3} << 19;  // 3 GB

/// Half the diagonal of a block, between the centres of its outermost voxels, in voxels.
const double kBlockRadius_vox = 0.5 * std::sqrt(3.0) * (kLeafEdge - 1);

Vec3 BlockCentre_vox(const Coord& origin) {
  return Vec3(origin.x(), origin.y(), origin.z()) + 0.5 * (kLeafEdge - 1);
}

/// Replaces the inside tiles within `reach_mm` of the plane with leaves.
void OpenTiles(FloatTree& tree, const PlaneDistance& distance, double reach_mm) {
  const double beyond_mm = reach_mm + (kBlockRadius_vox + 1) * distance.voxel_mm;
  std::vector<Coord> origins;
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (*tile >= 0 || !tile.getBoundingBox(box)) continue;
    for (int x = box.min().x(); x <= box.max().x(); x += kLeafEdge) {
      for (int y = box.min().y(); y <= box.max().y(); y += kLeafEdge) {
        for (int z = box.min().z(); z <= box.max().z(); z += kLeafEdge) {
          if (std::abs(distance.At(BlockCentre_vox({x, y, z}))) <= beyond_mm) origins.emplace_back(x, y, z);
        }
      }
    }
  }
  for (const Coord& origin : origins) tree.touchLeaf(origin);
}

void CheckInWorld(const Vec3& p_W, const char* what) {
  if (IsInWorld(p_W)) return;
  throw Error(fmt::format("{} ({:g}, {:g}, {:g}) lies outside the world; coordinates go from {} to {} mm", what, p_W.x,
                          p_W.y, p_W.z, -kWorldReach_mm, kWorldReach_mm));
}

void CheckCut(const Bone& bone, const SlabCut& cut) {
  CheckParameters(cut, "slice");
  const Vec3& p = cut.plane.p_W;
  const Vec3& n = cut.plane.normal_W;
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  CheckInWorld(p, "the plane's point");
  if (!(std::abs(length - 1) < 1e-6)) throw Error("the plane must have a normal of unit length");
  if (cut.near_W) CheckInWorld(*cut.near_W, "the point at which to cut");
  if (bone.empty()) throw Error("the bone is empty, so there is nothing to cut");
}

/// Returns the bone's extent along the normal, from the plane's point, by its inside voxels.
std::pair<double, double> CalcExtent(const Labels& labels, const PlaneDistance& distance) {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -lower;
  for (const LabelledBlock& block : labels.blocks) {
    for (int i = 0; i < 512; ++i) {
      if (block.part[i] == kNoPart) continue;
      const double s = distance(block.origin.offsetBy(i >> 6, (i >> 3) & 7, i & 7));
      lower = std::min(lower, s);
      upper = std::max(upper, s);
    }
  }
  return {lower, upper};
}

class Cutter {
 public:
  Cutter(const Bone& bone, const SlabCut& cut)
      : bone_(bone),
        phi_(GridsOf(bone).phi->deepCopy()),
        h_(bone.voxel_mm()),
        distance_{cut.plane.p_W, cut.plane.normal_W, h_},
        half_(0.5 * cut.thickness_mm),
        // Beyond this distance from the plane, the plane is outside the band, and every voxel is entirely left or
        // right.
        reach_(half_ + (kHalfBandVoxels + 2) * h_) {
    OpenTiles(phi_->tree(), distance_, reach_);
    labels_ = LabelInside(phi_->constTree(),
                          [this](const Coord& c) { return static_cast<int>(SideOf(distance_(c), reach_)); });
    section_ = ChooseSection(labels_, distance_, reach_, half_, cut.near_W.value_or(cut.plane.p_W));
    CheckMet(cut.everywhere);
    if (cut.everywhere || section_.everywhere) {
      section_.cut_places = section_.places;
      CutEverywhere();
    } else {
      MarkCutPlaces();
    }
  }

  SlabParts Make() {
    SlabParts parts;
    parts.left = MakeSegment(1, PartFate::kLeft);
    parts.right = MakeSegment(-1, PartFate::kRight);
    const FloatTree::Ptr masked = everywhere_ ? nullptr : MaskUncut();
    const FloatTree& source = masked ? *masked : phi_->constTree();
    parts.slice = MakeSlice(source);
    parts.slice_surface_W =
        MakeSliceSurface(source, h_, FindSliceBlocks(), {distance_.p_W, distance_.normal_W}, 2 * half_);
    for (const auto& [part, name] : {std::pair{&parts.left, "left segment"}, std::pair{&parts.slice, "slice"},
                                     std::pair{&parts.right, "right segment"}}) {
      if (part->empty()) throw Error(fmt::format("the plane leaves no bone for the {}; move it into the bone", name));
    }
    parts.places = section_.places;
    parts.cut_places = section_.cut_places;
    parts.distance_mm = section_.distance_mm;
    return parts;
  }

 private:
  void CheckMet(bool everywhere) const {
    const auto [lower, upper] = CalcExtent(labels_, distance_);
    if (lower > half_ || upper < -half_) {
      throw Error(
          fmt::format("the plane misses the bone: along its normal the bone lies {:.2f} to {:.2f} mm from the plane",
                      lower, upper));
    }
    if (lower > -half_ || upper < half_) {
      throw Error(fmt::format(
          "the plane leaves no bone on one of its sides: along its normal the bone lies {:.2f} to {:.2f} mm "
          "from the plane, and the slice takes {:g} mm on either side",
          lower, upper, half_));
    }
    if (!everywhere && section_.places == 0) {
      throw Error(
          "the plane divides no piece of the bone: it passes between separate pieces, or only grazes a face; move it "
          "into the bone");
    }
  }

  void CutEverywhere() {
    everywhere_ = true;
    section_.fates.assign(labels_.node_count, PartFate::kCut);
  }

  /// Marks the voxels around the cut places, inside and outside, as far as the band reaches.
  void MarkCutPlaces() {
    for (const LabelledBlock& block : labels_.blocks) {
      if (!block.leaf) continue;
      for (openvdb::Index i = 0; i < 512; ++i) {
        if (block.part[i] != kNoPart && section_.fates[block.first_node + block.part[i]] == PartFate::kCut) {
          cut_zone_.setValueOn(block.leaf->offsetToGlobalCoord(i));
        }
      }
    }
    Dilate(cut_zone_, kHalfBandVoxels, openvdb::tools::NN_FACE_EDGE_VERTEX);
  }

  bool IsInside(const LabelledBlock& block, PartFate fate) const {
    for (std::uint16_t part = 0; part < block.part_count; ++part) {
      const PartFate its = section_.fates[block.first_node + part];
      if (its == fate || its == PartFate::kCut) return true;
    }
    return false;
  }

  /// Finds the blocks with inside voxels that may be assigned to `fate`, and adjacent blocks for the outer side of the
  /// band.
  std::vector<char> FindBlocks(PartFate fate) const {
    std::vector<char> keep(labels_.blocks.size(), 0);
    for (const LabelledBlock& block : labels_.blocks) {
      if (!IsInside(block, fate)) continue;
      for (int beside = 0; beside < 27; ++beside) {
        const Coord at = block.origin.offsetBy(kLeafEdge * (beside / 9 - 1), kLeafEdge * (beside / 3 % 3 - 1),
                                               kLeafEdge * (beside % 3 - 1));
        const auto found = labels_.index.find(at);
        if (found != labels_.index.end()) keep[found->second] = 1;
      }
    }
    return keep;
  }

  /// Makes the segment where sign * s < -t/2.
  Bone MakeSegment(double sign, PartFate fate) const {
    Bone segment = MakeEmptyCopy(h_);
    FloatTree& tree = GridsOf(segment).phi->tree();
    const float band = tree.background();
    const std::vector<char> keep = FindBlocks(fate);
    SliceLeaves leaves(labels_.blocks.size());
    tbb::parallel_for(std::size_t{0}, labels_.blocks.size(), [&](std::size_t n) {
      const LabelledBlock& block = labels_.blocks[n];
      if (!keep[n] || !block.leaf) return;
      openvdb::tree::ValueAccessor<const openvdb::MaskTree> zone(cut_zone_);
      leaves[n] = std::make_unique<FloatLeaf>(*block.leaf);
      for (openvdb::Index i = 0; i < 512; ++i) {
        const Coord ijk = block.leaf->offsetToGlobalCoord(i);
        const bool inside = block.part[i] != kNoPart;
        const PartFate its = inside ? section_.fates[block.first_node + block.part[i]] : PartFate::kCut;
        if (its != fate && its != PartFate::kCut) {
          leaves[n]->setValueOnly(i, band);
        } else if (its == PartFate::kCut && (inside || everywhere_ || zone.isValueOn(ijk))) {
          const double beyond = sign * distance_(ijk) + half_;
          leaves[n]->setValueOnly(i, std::max(block.leaf->getValue(i), static_cast<float>(beyond)));
        }
      }
    });
    for (std::size_t n = 0; n < leaves.size(); ++n) {
      const LabelledBlock& block = labels_.blocks[n];
      if (leaves[n]) tree.addLeaf(leaves[n].release());
      if (block.leaf || !keep[n]) continue;
      const PartFate its = section_.fates[block.first_node];
      const bool ours = its == PartFate::kCut ? sign * distance_(block.origin) < 0 : its == fate;
      if (ours) tree.addTile(1, block.origin, -band, false);
    }
    FinishLevelSet(*GridsOf(segment).phi);
    return segment;
  }

  bool IsNearSlice(const LabelledBlock& block) const {
    const double s = distance_.At(BlockCentre_vox(block.origin));
    return block.leaf && std::abs(s) <= half_ + (kHalfBandVoxels + kBlockRadius_vox + 2) * h_;
  }

  std::vector<Coord> FindSliceBlocks() const {
    std::vector<Coord> origins;
    for (const LabelledBlock& block : labels_.blocks) {
      if (IsNearSlice(block)) origins.push_back(block.origin);
    }
    return origins;
  }

  /// Makes the slice: the bone's phi, where it is cut, on the finer grid, between the two faces.
  Bone MakeSlice(const FloatTree& source) const {
    const int refine = std::max(2, static_cast<int>(std::ceil(4 * h_ / (2 * half_) - 1e-9)));
    const PlaneDistance fine{distance_.p_W, distance_.normal_W, h_ / refine};
    // Fine blocks are grouped by coarse blocks, so that their order is always the same.
    std::vector<SliceLeaves> leaves(labels_.blocks.size());
    std::atomic<std::size_t> count{0};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 8), [&](const auto& range) {
      openvdb::tree::ValueAccessor<const FloatTree> accessor(source);
      CellBlock cells;
      for (std::size_t n = range.begin(); n < range.end() && count <= kMaxSliceBlocks; ++n) {
        const LabelledBlock& block = labels_.blocks[n];
        if (!IsNearSlice(block)) continue;
        cells.Load(accessor, block.origin);
        leaves[n] = MakeSliceLeaves(cells, block.origin, refine, fine);
        count += leaves[n].size();
      }
    });
    if (count > kMaxSliceBlocks) {
      throw Error(
          fmt::format("a slice of {:g} mm through this much bone needs more than {} million voxels; make it thicker",
                      2 * half_, (kMaxSliceBlocks * 512) >> 20));
    }
    Bone slice = MakeEmptyCopy(fine.voxel_mm);
    for (SliceLeaves& of_block : leaves) {
      for (auto& leaf : of_block) GridsOf(slice).phi->tree().addLeaf(leaf.release());
    }
    FinishLevelSet(*GridsOf(slice).phi);
    return slice;
  }

  /// Makes the leaves of the fine grid within one coarse block that the slice or its band may reach.
  SliceLeaves MakeSliceLeaves(const CellBlock& cells, const Coord& coarse_origin, int refine,
                              const PlaneDistance& fine) const {
    const double radius = kBlockRadius_vox * fine.voxel_mm;
    const double band = kHalfBandVoxels * fine.voxel_mm;
    SliceLeaves leaves;
    for (int x = 0; x < refine; ++x) {
      for (int y = 0; y < refine; ++y) {
        for (int z = 0; z < refine; ++z) {
          const Coord origin(refine * coarse_origin.x() + kLeafEdge * x, refine * coarse_origin.y() + kLeafEdge * y,
                             refine * coarse_origin.z() + kLeafEdge * z);
          const Vec3 centre = BlockCentre_vox(origin);
          if (std::abs(fine.At(centre)) > half_ + band + radius) continue;
          // Skips blocks in the air: phi changes by about 1 per mm, and never by as much as 1.5.
          const Vec3 p =
              centre / static_cast<double>(refine) - Vec3(coarse_origin.x(), coarse_origin.y(), coarse_origin.z());
          const Vec3 cell = glm::floor(p);
          const double f[3] = {p.x - cell.x, p.y - cell.y, p.z - cell.z};
          const double phi = InterpolateInCell(
              cells.Corners(static_cast<int>(cell.x), static_cast<int>(cell.y), static_cast<int>(cell.z)), f);
          if (phi > band + 1.5 * radius) continue;
          auto leaf = MakeSliceLeaf(cells, coarse_origin, origin, refine, fine);
          if (leaf) leaves.push_back(std::move(leaf));
        }
      }
    }
    return leaves;
  }

  std::unique_ptr<FloatLeaf> MakeSliceLeaf(const CellBlock& cells, const Coord& coarse_origin, const Coord& origin,
                                           int refine, const PlaneDistance& fine) const {
    auto leaf = std::make_unique<FloatLeaf>(origin, 0.0f, true);
    const double band = kHalfBandVoxels * fine.voxel_mm;
    bool any = false;
    for (openvdb::Index i = 0; i < 512; ++i) {
      const Coord ijk = leaf->offsetToGlobalCoord(i);
      int cell[3];
      double f[3];
      for (int axis = 0; axis < 3; ++axis) {
        const int within = ijk[axis] - refine * coarse_origin[axis];
        cell[axis] = within / refine;
        f[axis] = static_cast<double>(within % refine) / refine;
      }
      const double phi = InterpolateInCell(cells.Corners(cell[0], cell[1], cell[2]), f);
      const double value = std::max(phi, std::abs(fine(ijk)) - half_);
      any = any || value < band;
      leaf->setValueOnly(i, static_cast<float>(value));
    }
    return any ? std::move(leaf) : nullptr;
  }

  /// Returns phi with the uncut bone replaced by air.
  FloatTree::Ptr MaskUncut() const {
    auto tree = std::make_shared<FloatTree>(phi_->constTree());
    const float band = tree->background();
    for (const LabelledBlock& block : labels_.blocks) {
      if (!block.leaf) continue;
      FloatLeaf* leaf = tree->probeLeaf(block.origin);
      for (openvdb::Index i = 0; i < 512; ++i) {
        if (block.part[i] == kNoPart || section_.fates[block.first_node + block.part[i]] == PartFate::kCut) continue;
        leaf->setValueOnly(i, band);
      }
    }
    return tree;
  }

  Bone MakeEmptyCopy(double voxel_mm) const {
    Bone copy;
    GridsOf(copy) = GridsOf(bone_);
    GridsOf(copy).phi = MakePhiGrid(voxel_mm);
    GridsOf(copy).whole = GridsOf(copy).cut = nullptr;
    return copy;
  }

  const Bone& bone_;
  openvdb::FloatGrid::Ptr phi_;  // the bone's, with leaves wherever the plane may cut
  double h_;
  PlaneDistance distance_;
  double half_;
  double reach_;
  Labels labels_;
  Section section_;
  bool everywhere_ = false;
  openvdb::MaskTree cut_zone_;
};

}  // namespace

SlabParts MakeSlabParts(const Bone& bone, const SlabCut& cut) {
  CheckCut(bone, cut);
  return Cutter(bone, cut).Make();
}

}  // namespace kerf
