#include "bench/vdb_cut.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "bench/dense_bone.h"
#include "bone/grids.h"

namespace kerf {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr int kLeafEdge = 8;

double CalcToolDistance(const Tool& tool, const Pose& X_WT, const Vec3& p_W) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    return CalcDiscSweepDistance(p_W, X_WT, X_WT, disc->radius_mm(), disc->thickness_mm);
  }
  return CalcBallSweepDistance(p_W, X_WT.p_AB, X_WT.p_AB, CalcReach(tool));
}

FloatGrid::Ptr MakeToolGrid(const Tool& tool, const Pose& X_WT, double voxel_mm) {
  const FloatGrid::Ptr grid = MakePhiGrid(voxel_mm);
  const double band = static_cast<double>(grid->background());
  const double leaf_mm = kLeafEdge * voxel_mm;
  const double reach = CalcReach(tool) + band;
  // From the middle of a leaf's voxels to its furthest voxel.
  const double half_diagonal = 0.5 * std::sqrt(3.0) * (kLeafEdge - 1) * voxel_mm;
  const auto first = glm::floor((X_WT.p_AB - reach) / leaf_mm);
  const auto last = glm::floor((X_WT.p_AB + reach) / leaf_mm);
  for (int x = static_cast<int>(first.x); x <= static_cast<int>(last.x); ++x) {
    for (int y = static_cast<int>(first.y); y <= static_cast<int>(last.y); ++y) {
      for (int z = static_cast<int>(first.z); z <= static_cast<int>(last.z); ++z) {
        const Vec3 lowest = leaf_mm * Vec3(x, y, z);
        const Vec3 middle = lowest + 0.5 * (kLeafEdge - 1) * voxel_mm;
        if (std::abs(CalcToolDistance(tool, X_WT, middle)) > band + half_diagonal) continue;
        auto* leaf = new Leaf(Coord(kLeafEdge * x, kLeafEdge * y, kLeafEdge * z), static_cast<float>(band), false);
        for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
          const Coord local = Leaf::offsetToLocalCoord(i);
          const Vec3 p_W = lowest + voxel_mm * Vec3(local.x(), local.y(), local.z());
          const double d = CalcToolDistance(tool, X_WT, p_W);
          if (std::abs(d) < band) {
            leaf->setValueOn(i, static_cast<float>(d));
          } else {
            leaf->setValueOff(i, static_cast<float>(std::copysign(band, d)));
          }
        }
        grid->tree().addLeaf(leaf);
      }
    }
  }
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

}  // namespace

VdbCut::VdbCut(Bone bone) : bone_(std::move(bone)) {}
VdbCut::~VdbCut() = default;

void VdbCut::Cut(const Tool& tool, const Pose& X_WT) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const FloatGrid::Ptr tool_grid = MakeToolGrid(tool, X_WT, bone_.voxel_mm());
  openvdb::tools::csgDifference(*bone_.grids().phi, *tool_grid, /*prune=*/false);
}

}  // namespace kerf
