#include "bone/grid/coarse_surface.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <glm/geometric.hpp>

#include "bone/grid/grids.h"
#include "bone/grid/interpolate.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

/// Returns every second voxel of a level set along each axis, where it was. Both ends of an edge that the surface
/// crosses are within two voxels of it and thus in the band.
openvdb::FloatGrid::Ptr TakeEverySecondVoxel(const openvdb::FloatGrid& fine) {
  openvdb::FloatGrid::Ptr coarse = openvdb::FloatGrid::create(fine.background());
  const openvdb::math::Transform::Ptr transform = fine.transform().copy();
  transform->preScale(2);
  coarse->setTransform(transform);
  coarse->setGridClass(openvdb::GRID_LEVEL_SET);
  for (auto leaf = fine.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord& first = leaf->origin();
    coarse->tree().touchLeaf({first.x() >> 1, first.y() >> 1, first.z() >> 1});
  }
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(coarse->tree());
  leaves.foreach ([&](auto& leaf, std::size_t) {
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> values(fine.tree());
    for (openvdb::Index i = 0; i < leaf.SIZE; ++i) {
      const openvdb::Coord at = leaf.offsetToGlobalCoord(i);
      float value = 0;
      const bool active = values.probeValue({2 * at.x(), 2 * at.y(), 2 * at.z()}, value);
      if (active) {
        leaf.setValueOn(i, value);
      } else {
        leaf.setValueOff(i, value);
      }
    }
  });
  openvdb::tools::signedFloodFill(coarse->tree(), true, 1, 1);  // the tiles
  return coarse;
}

/// Moves a point near the surface onto it, by at most a voxel.
template <typename Accessor>
void MoveToSurface(const Accessor& values, double voxel_mm, Vec3& p_W) {
  const CellPoint cell = FindCell(p_W / voxel_mm);
  const CellValues<float> corners = GetCorners(values, cell);
  const Vec3 slope = InterpolateGradient(corners, cell.f) / voxel_mm;
  const double slope2 = glm::dot(slope, slope);
  if (!(slope2 > 0.25)) return;  // between two walls
  const Vec3 shift = -Interpolate(corners, cell.f) / slope2 * slope;
  if (glm::dot(shift, shift) < voxel_mm * voxel_mm) p_W += shift;
}

}  // namespace

TriangleMesh ExtractCoarseSurface(const Bone& bone) {
  if (GridsOf(bone).cut) return ExtractSurface(bone);
  const openvdb::FloatGrid& phi = *GridsOf(bone).phi;
  TriangleMesh mesh = ExtractZeroLevel(*TakeEverySecondVoxel(phi), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.points.size(), 4096), [&](const auto& range) {
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> values(phi.tree());
    for (std::size_t i = range.begin(); i != range.end(); ++i) MoveToSurface(values, bone.voxel_mm(), mesh.points[i]);
  });
  return mesh;
}

}  // namespace kerf
