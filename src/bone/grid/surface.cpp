#include "kerf/surface.h"

#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>

#include "bone/grid/grids.h"
#include "bone/grid/sharp_edges.h"

namespace kerf {
namespace {

bool HasMetal(const Bone& bone) {
  const auto& regions = bone.materials().regions();
  return std::any_of(regions.begin(), regions.end(),
                     [](const auto& region) { return region.second.tissue == Tissue::kMetal; });
}

}  // namespace

TriangleMesh ExtractSurface(const Bone& bone, double adaptivity) {
  openvdb::FloatGrid::Ptr phi = GridsOf(bone).phi;
  if (GridsOf(bone).cut && HasMetal(bone)) {
    // Metal that was kept deep in a cut is beside voxels as deep outside. OpenVDB passes over pairs of inactive voxels.
    phi = phi->deepCopy();
    for (auto leaf = phi->tree().beginLeaf(); leaf; ++leaf) leaf->setValuesOn();
  }
  TriangleMesh mesh = ExtractZeroLevel(*phi, adaptivity);
  SharpenEdges(GridsOf(bone), mesh);
  return mesh;
}

std::vector<BoneLeaf> ListLeaves(const Bone& bone) {
  std::vector<BoneLeaf> leaves;
  const openvdb::FloatTree& tree = GridsOf(bone).phi->tree();
  leaves.reserve(tree.leafCount());
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord& first = leaf->origin();
    leaves.push_back({{first.x(), first.y(), first.z()}, std::span<const float, 512>(leaf->buffer().data(), 512)});
  }
  return leaves;
}

TriangleMesh ExtractZeroLevel(const openvdb::FloatGrid& grid, double adaptivity) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, triangles, quads, 0.0, adaptivity);
  TriangleMesh mesh;
  mesh.points.reserve(points.size());
  for (const auto& p : points) {
    mesh.points.emplace_back(static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z()));
  }
  // OpenVDB's polygons are clockwise seen from outside.
  mesh.triangles.reserve(triangles.size() + 2 * quads.size());
  for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[2], t[1]});
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[2], q[1]});
    mesh.triangles.push_back({q[0], q[3], q[2]});
  }
  return mesh;
}

}  // namespace kerf
