// Voxels of the bone's region grid that belong to a structure, given by regions, or by surfaces and curves from files.
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"

namespace kerf {

/// Set of voxels. A voxel's centre is its index times the voxel size. The set may extend beyond the bone.
class StructureVoxels {
 public:
  explicit StructureVoxels(double voxel_mm) : voxel_mm_(voxel_mm) {}

  // Each of the following adds to the set. Finish() must be called after the last one and before any query. All
  // allocate.
  void AddRegions(const Bone& bone, const std::array<bool, 256>& regions);
  /// Adds the voxels whose centres are inside the surface, that is, where its winding number is not 0.
  void AddSurface(const TriangleMesh& closed_W);
  /// Adds the voxels whose centres are at most `radius_mm` from the polyline through the points or, if these are
  /// separate, from any of them.
  void AddCurve(const EffectFile::Curve& curve_W, double radius_mm);
  void Add(const StructureVoxels& other);
  void Finish();

  /// Returns true if the point's voxel is in the set. Tick-safe.
  bool Contains(const Vec3& p_W) const;
  bool empty() const { return runs_.empty(); }
  double CalcVolume() const;
  std::size_t CalcMemoryBytes() const;

  /// Returns a box for each run of voxels along z, world frame, mm.
  std::vector<Box3> MakeBoxes() const;
  /// Returns boxes of the voxels that share a face with the set and are not in it.
  std::vector<Box3> MakeShell() const;
  /// Returns the faces between the set and that shell.
  TriangleMesh MakeSurface() const;

  static constexpr std::size_t kMaxRuns = std::size_t{1} << 22;

 private:
  struct Run {
    int x, y, z0, z1;  // voxels z0 to z1
    friend bool operator<(const Run& a, const Run& b) {
      return std::tie(a.x, a.y, a.z0, a.z1) < std::tie(b.x, b.y, b.z0, b.z1);
    }
  };
  void Add(int x, int y, double lower_mm, double upper_mm);
  void Push(const Run& run);
  bool Contains(int x, int y, int z) const;
  /// Calls visit(run, axis, sign, z0, z1) for each range of faces whose outward normal is `sign` along `axis`.
  template <typename Visit>
  void ForEachFace(Visit&& visit) const;

  double voxel_mm_;
  std::vector<Run> runs_;
};

}  // namespace kerf
