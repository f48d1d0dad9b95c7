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

/// The tool in the leaves of a grid, which are cubes of kVdbLeafEdge voxels.
class ToolInLeaves {
 public:
  ToolInLeaves(const Tool& tool, const Pose& X_WT, double voxel_mm, float band)
      : distance_(tool),
        X_WT_(X_WT),
        voxel_mm_(voxel_mm),
        reach_mm_(CalcReach(tool) + static_cast<double>(band)),
        // Distance from the centre of a leaf's voxels to its furthest voxel, and the band.
        near_(band + static_cast<float>(0.5 * std::sqrt(3.0) * (kVdbLeafEdge - 1) * voxel_mm)),
        dx_(voxel_mm * X_WT.InverseVector({1, 0, 0})),
        dy_(voxel_mm * X_WT.InverseVector({0, 1, 0})),
        dz_(voxel_mm * X_WT.InverseVector({0, 0, 1})) {}

  /// Calls visit(origin) for each leaf near the tool.
  template <typename Visit>
  void VisitLeaves(Visit&& visit) const {
    const double leaf_mm = kVdbLeafEdge * voxel_mm_;
    const auto first = glm::floor((X_WT_.p_AB - reach_mm_) / leaf_mm);
    const auto last = glm::floor((X_WT_.p_AB + reach_mm_) / leaf_mm);
    for (int x = static_cast<int>(first.x); x <= static_cast<int>(last.x); ++x) {
      for (int y = static_cast<int>(first.y); y <= static_cast<int>(last.y); ++y) {
        for (int z = static_cast<int>(first.z); z <= static_cast<int>(last.z); ++z) {
          visit(Coord(kVdbLeafEdge * x, kVdbLeafEdge * y, kVdbLeafEdge * z));
        }
      }
    }
  }
  /// Returns the distance at the centre of a leaf.
  float CalcMiddle(const Coord& origin) const {
    return distance_(GetCorner(origin) + 0.5f * (kVdbLeafEdge - 1) * (dx_ + dy_ + dz_));
  }
  /// Largest distance at the centre of a leaf of which a voxel may be in the tool's band.
  float near() const { return near_; }
  /// Calls visit(value, distance) for each of a leaf's values.
  template <typename Visit>
  void VisitValues(const Coord& origin, float* values, Visit&& visit) const {
    const glm::vec3 corner = GetCorner(origin);
    for (int i = 0; i < kVdbLeafEdge; ++i) {
      for (int j = 0; j < kVdbLeafEdge; ++j) {
        const glm::vec3 row = corner + static_cast<float>(i) * dx_ + static_cast<float>(j) * dy_;
        for (int k = 0; k < kVdbLeafEdge; ++k) visit(*values++, distance_(row + static_cast<float>(k) * dz_));
      }
    }
  }

 private:
  glm::vec3 GetCorner(const Coord& origin) const {
    return glm::vec3(X_WT_.InversePoint(voxel_mm_ * Vec3(origin.x(), origin.y(), origin.z())));
  }

  ToolDistance distance_;
  Pose X_WT_;
  double voxel_mm_;
  double reach_mm_;
  float near_;
  glm::vec3 dx_, dy_, dz_;  // steps along the grid's axes, in the tool frame
};

}  // namespace

struct VdbCut::Grid {
  FloatGrid::Ptr grid;
};

VdbCut::VdbCut(Bone bone) : bone_(std::move(bone)), tool_(std::make_unique<Grid>()) {}
VdbCut::~VdbCut() = default;

void VdbCut::MakeTool(const Tool& tool, const Pose& X_WT) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  tool_->grid = MakePhiGrid(bone_.voxel_mm());
  const float band = tool_->grid->background();
  const ToolInLeaves in_leaves(tool, X_WT, bone_.voxel_mm(), band);
  in_leaves.VisitLeaves([&](const Coord& origin) {
    if (std::abs(in_leaves.CalcMiddle(origin)) > in_leaves.near()) return;
    auto* leaf = new Leaf(origin, band, false);
    float* values = leaf->buffer().data();
    in_leaves.VisitValues(origin, values,
                          [&](float& value, float distance) { value = std::clamp(distance, -band, band); });
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      if (std::abs(values[i]) < band) leaf->setValueOn(i);
    }
    tool_->grid->tree().addLeaf(leaf);
  });
  openvdb::tools::signedFloodFill(tool_->grid->tree());
}

void VdbCut::RemoveTool() {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  openvdb::tools::csgDifference(*GridsOf(bone_).phi, *tool_->grid, /*prune=*/false);
}

void VdbCut::CutLeaves(const Tool& tool, const Pose& X_WT) {
  FloatGrid& phi = *GridsOf(bone_).phi;
  const ToolInLeaves in_leaves(tool, X_WT, bone_.voxel_mm(), phi.background());
  auto bone = phi.getAccessor();
  in_leaves.VisitLeaves([&](const Coord& origin) {
    if (in_leaves.CalcMiddle(origin) > in_leaves.near()) return;
    Leaf* leaf = bone.probeLeaf(origin);
    if (leaf == nullptr && bone.getValue(origin) < 0) leaf = bone.touchLeaf(origin);  // inside the bone
    if (leaf == nullptr) return;
    in_leaves.VisitValues(origin, leaf->buffer().data(), [&](float& value, float distance) {
      value = std::max(value, std::min(-distance, phi.background()));
    });
  });
}

}  // namespace kerf
