#include "bone/grid/slice_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>

#include "bone/grid/cell_volume.h"
#include "bone/grid/grids.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

/// Lattice along a plane: index (i, j, k) lies at p + i u + j v + k w.
struct Lattice {
  Vec3 p_W, u, v, w;

  /// p is the point of the plane nearest to `near_W`. The plane's own point may lie far from the bone, and the
  /// lattice's indices would then be large.
  Lattice(const CutPlane& plane, const Vec3& near_W, double along_mm, double across_mm) {
    const Vec3& n = plane.normal_W;
    p_W = near_W - glm::dot(near_W - plane.p_W, n) * n;
    // The axis that is most nearly parallel to the plane.
    int axis = std::abs(n.x) <= std::abs(n.y) ? 0 : 1;
    if (std::abs(n.z) < std::abs(n[axis])) axis = 2;
    Vec3 a(0);
    a[axis] = 1;
    const Vec3 unit_u = glm::normalize(a - glm::dot(a, n) * n);
    u = along_mm * unit_u;
    v = along_mm * glm::cross(n, unit_u);
    w = across_mm * n;
  }
  Vec3 Point(const Coord& c) const {
    return p_W + static_cast<double>(c.x()) * u + static_cast<double>(c.y()) * v + static_cast<double>(c.z()) * w;
  }
};

int FloorToBlock(double x) {
  return static_cast<int>(std::floor(x / kLeafEdge)) * kLeafEdge;
}

/// Returns the centre of the box that contains the blocks, mm.
Vec3 CalcMiddle(const std::vector<Coord>& blocks, double voxel_mm) {
  Box3 box;
  for (const Coord& origin : blocks) box.Include(voxel_mm * Vec3(origin.x(), origin.y(), origin.z()));
  return box.empty() ? Vec3(0) : box.centre() + Vec3(0.5 * kLeafEdge * voxel_mm);
}

/// Returns the blocks of the lattice that cover the bone's blocks, for layers within `layers` of the plane.
std::vector<Coord> FindBlocks(const std::vector<Coord>& blocks, double voxel_mm, const Lattice& lattice, int layers) {
  std::vector<Coord> found;
  const double along2 = glm::dot(lattice.u, lattice.u);
  // A block's cells reach one voxel further.
  const double radius = 0.5 * std::sqrt(3.0) * kLeafEdge * voxel_mm / std::sqrt(along2) + 1;
  for (const Coord& origin : blocks) {
    const Vec3 d = voxel_mm * (Vec3(origin.x(), origin.y(), origin.z()) + 0.5 * kLeafEdge) - lattice.p_W;
    const double i = glm::dot(d, lattice.u) / along2;
    const double j = glm::dot(d, lattice.v) / along2;
    for (int x = FloorToBlock(i - radius); x <= i + radius; x += kLeafEdge) {
      for (int y = FloorToBlock(j - radius); y <= j + radius; y += kLeafEdge) {
        for (int z = FloorToBlock(-layers); z <= layers; z += kLeafEdge) found.emplace_back(x, y, z);
      }
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

template <typename Accessor>
double InterpolateLinearly(const Accessor& phi, const Vec3& p_vox) {
  const Vec3 base = glm::floor(p_vox);
  const double f[3] = {p_vox.x - base.x, p_vox.y - base.y, p_vox.z - base.z};
  const Coord ijk(static_cast<int>(base.x), static_cast<int>(base.y), static_cast<int>(base.z));
  std::array<float, 8> corners;
  for (int c = 0; c < 8; ++c) corners[c] = phi.getValue(ijk.offsetBy(c >> 2, (c >> 1) & 1, c & 1));
  return InterpolateInCell(corners, f);
}

}  // namespace

TriangleMesh MakeSliceSurface(const FloatTree& phi, double voxel_mm, const std::vector<Coord>& blocks,
                              const CutPlane& plane, double thickness_mm) {
  // Where the slice is thick, the spacing across it is half a voxel too.
  const int half_layers = std::max(1, static_cast<int>(std::ceil(thickness_mm / voxel_mm - 0.5)));
  const double step_mm = thickness_mm / (2 * half_layers + 1);
  const Lattice lattice(plane, CalcMiddle(blocks, voxel_mm), 0.5 * voxel_mm, step_mm);
  const std::vector<Coord> origins = FindBlocks(blocks, voxel_mm, lattice, half_layers + 2);
  std::vector<std::unique_ptr<FloatLeaf>> leaves(origins.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), 16), [&](const auto& range) {
    openvdb::tree::ValueAccessor<const FloatTree> accessor(phi);
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      leaves[n] = std::make_unique<FloatLeaf>(origins[n], 0.0f, true);
      for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
        const Coord ijk = leaves[n]->offsetToGlobalCoord(i);
        const double beyond = (std::abs(ijk.z()) - half_layers - 0.5) * step_mm;
        const double value =
            beyond > step_mm ? beyond : std::max(beyond, InterpolateLinearly(accessor, lattice.Point(ijk) / voxel_mm));
        leaves[n]->setValueOnly(i, static_cast<float>(value));
      }
    }
  });
  auto grid = openvdb::FloatGrid::create(static_cast<float>(voxel_mm));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);  // negative is inside
  const auto row = [](const Vec3& a) { return openvdb::Vec4d(a.x, a.y, a.z, 0); };
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  matrix.setRow(0, row(lattice.u));
  matrix.setRow(1, row(lattice.v));
  matrix.setRow(2, row(lattice.w));
  matrix.setRow(3, openvdb::Vec4d(lattice.p_W.x, lattice.p_W.y, lattice.p_W.z, 1));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  for (auto& leaf : leaves) grid->tree().addLeaf(leaf.release());
  return ExtractZeroLevel(*grid, 0);
}

}  // namespace kerf
