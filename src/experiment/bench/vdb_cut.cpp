#include "experiment/bench/vdb_cut.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <vector>

#include "bone/grid/grids.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr int kVdbLeafEdge = 8;

/// Calculates the distance to the tool in single precision; p is in the tool frame. Of a solid of revolution and of a
/// blade with an outline it is the largest distance from one of the faces.
struct ToolDistance {
  explicit ToolDistance(const Tool& tool)
      : form(GetForm(tool)),
        radius(static_cast<float>(CalcRadius(tool))),
        half_thickness(static_cast<float>(0.5 * (IsBlade(tool) ? CalcCutWidth(tool) : 0))) {
    if (form == ToolForm::kRound) faces = CalcRoundSolid(tool)->CalcFaces();
    const ConvexOutline outline = MakeToolOutline(tool);
    for (int i = 0; i < outline.size(); ++i) sides.push_back(outline.side(i));
  }
  float operator()(const glm::vec3& p) const {
    if (form == ToolForm::kBall) return std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z) - radius;
    if (!sides.empty()) {
      float largest = std::abs(p.z) - half_thickness;
      for (const ConvexOutline::Side& s : sides) {
        largest = std::max(largest, static_cast<float>(s.normal.x) * p.x + static_cast<float>(s.normal.y) * p.y -
                                        static_cast<float>(s.offset_mm));
      }
      return largest;
    }
    const float from_axis = std::sqrt(p.x * p.x + p.y * p.y);
    if (form == ToolForm::kRound) {
      float largest = -1e30f;
      for (const RoundSolid::Face& f : faces) {
        largest = std::max(largest, static_cast<float>(f.r) * from_axis + static_cast<float>(f.z) * p.z -
                                        static_cast<float>(f.offset_mm));
      }
      return largest;
    }
    const float radial = from_axis - radius;
    const float axial = std::abs(p.z) - half_thickness;
    if (radial > 0 && axial > 0) return std::sqrt(radial * radial + axial * axial);
    return std::max(radial, axial);
  }
  ToolForm form;
  std::array<RoundSolid::Face, 3> faces{};
  std::vector<ConvexOutline::Side> sides;
  float radius;
  float half_thickness;
};

FloatGrid::Ptr MakeToolGrid(const Tool& tool, const Pose& X_WT, double voxel_mm) {
  FloatGrid::Ptr grid = MakePhiGrid(voxel_mm);
  const float band = grid->background();
  const double leaf_mm = kVdbLeafEdge * voxel_mm;
  const double reach = CalcReach(tool) + static_cast<double>(band);
  const ToolDistance distance(tool);
  // Distance from the centre of a leaf's voxels to its furthest voxel.
  const auto half_diagonal = static_cast<float>(0.5 * std::sqrt(3.0) * (kVdbLeafEdge - 1) * voxel_mm);
  // A step along the grid's axes, and the vector from a leaf's lowest voxel to its centre, in the tool frame.
  const glm::vec3 dx(voxel_mm * X_WT.InverseVector({1, 0, 0}));
  const glm::vec3 dy(voxel_mm * X_WT.InverseVector({0, 1, 0}));
  const glm::vec3 dz(voxel_mm * X_WT.InverseVector({0, 0, 1}));
  const glm::vec3 to_middle = 0.5f * (kVdbLeafEdge - 1) * (dx + dy + dz);
  const auto first = glm::floor((X_WT.p_AB - reach) / leaf_mm);
  const auto last = glm::floor((X_WT.p_AB + reach) / leaf_mm);
  for (int x = static_cast<int>(first.x); x <= static_cast<int>(last.x); ++x) {
    for (int y = static_cast<int>(first.y); y <= static_cast<int>(last.y); ++y) {
      for (int z = static_cast<int>(first.z); z <= static_cast<int>(last.z); ++z) {
        const glm::vec3 corner(X_WT.InversePoint(leaf_mm * Vec3(x, y, z)));
        if (std::abs(distance(corner + to_middle)) > band + half_diagonal) continue;
        auto* leaf = new Leaf(Coord(kVdbLeafEdge * x, kVdbLeafEdge * y, kVdbLeafEdge * z), band, false);
        float* values = leaf->buffer().data();
        for (int i = 0; i < kVdbLeafEdge; ++i) {
          for (int j = 0; j < kVdbLeafEdge; ++j) {
            const glm::vec3 row = corner + static_cast<float>(i) * dx + static_cast<float>(j) * dy;
            for (int k = 0; k < kVdbLeafEdge; ++k) {
              *values++ = std::clamp(distance(row + static_cast<float>(k) * dz), -band, band);
            }
          }
        }
        values = leaf->buffer().data();
        for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
          if (std::abs(values[i]) < band) leaf->setValueOn(i);
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
  openvdb::tools::csgDifference(*GridsOf(bone_).phi, *tool_grid, /*prune=*/false);
}

}  // namespace kerf
