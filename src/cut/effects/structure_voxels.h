// The voxels of the bone's region grid that are a structure: of its regions, and of surfaces and curves from files.
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

#include "kerf/bone.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"

namespace kerf {

/// A set of voxels, whose centres are their indices times their edge. It reaches beyond the bone where what it was made
/// of does.
class StructureVoxels {
 public:
  explicit StructureVoxels(double voxel_mm) : voxel_mm_(voxel_mm) {}

  // Each adds to the set; Finish() comes after the last and before anything is asked. All allocate.
  void AddRegions(const Bone& bone, const std::array<bool, 256>& regions);
  /// The voxels whose centres are inside: where the surface goes round them, whichever way and however often.
  void AddSurface(const TriangleMesh& closed_W);
  /// The voxels whose centres are at most `radius_mm` from the line through the points, or from one of them.
  void AddCurve(const EffectFile::Curve& curve_W, double radius_mm);
  void Add(const StructureVoxels& other);
  void Finish();

  /// Whether the point's voxel is one of them. Tick-safe.
  bool Contains(const Vec3& p_W) const;
  bool empty() const { return runs_.empty(); }
  double CalcVolume() const;
  std::size_t CalcMemoryBytes() const;

  /// World frame, mm; a box for each run of voxels along z.
  std::vector<Box3> MakeBoxes() const;
  /// Those that share a face with one of them and are none.
  std::vector<Box3> MakeShell() const;
  /// The faces between those and these.
  TriangleMesh MakeSurface() const;

  static constexpr std::size_t kMostRuns = std::size_t{1} << 22;

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
  /// Calls visit(run, axis, sign, z0, z1) for stretches of faces that look along `axis` out of the set.
  template <typename Visit>
  void ForEachFace(Visit&& visit) const;

  double voxel_mm_;
  std::vector<Run> runs_;
};

}  // namespace kerf
