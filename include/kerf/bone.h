// A bone: where it is (a level set) and what it is made of (regions with elastic constants).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

/// A leaf of the level set that a simulation changed: {x, y, z} of its 8 x 8 x 8 voxels counted in leaves from the
/// world's origin, and the values that it has now (512, mm).
struct ChangedLeaf {
  std::array<int, 3> index;
  const float* values;
};

/// A bone as a narrow-band level set and a grid of region numbers, both OpenVDB grids in the world frame.
///
/// phi: signed distance to the surface in mm, negative inside, within `band_mm()` of the surface and clamped to
/// +-band_mm() beyond. Its zero level is second-order in the voxel size; away from it the distance of an imported
/// surface is true to a fifth of a voxel. region: 0 outside, else an id of materials(); it is defined a little beyond
/// the surface too, so that a tooth that touches the surface finds its material. The two grids may have different voxel
/// sizes. Copying is deep. Moving is cheap.
class Bone {
 public:
  Bone();  // no voxels
  ~Bone();
  Bone(const Bone& other);
  Bone& operator=(const Bone& other);
  Bone(Bone&&) noexcept;
  Bone& operator=(Bone&&) noexcept;

  double voxel_mm() const;         // edge of a phi voxel
  double region_voxel_mm() const;  // edge of a region voxel
  double band_mm() const;          // half width of the narrow band: 3 voxels unless it was built otherwise
  const MaterialTable& materials() const;
  void set_materials(MaterialTable table);
  /// Other constants from here on, for a run; a file written of the bone still gets the table that it had.
  void OverrideMaterials(MaterialTable table);
  /// Provenance and other notes, written into the file's metadata.
  const std::map<std::string, std::string>& notes() const;
  void set_note(const std::string& key, const std::string& value);

  /// Signed distance at a world point, mm, trilinear between voxel centres. Tick-safe, but slow (it starts a tree
  /// search).
  double SignedDistance(const Vec3& p_W) const;
  /// Region id at a world point (nearest voxel), 0 where there is none. Tick-safe, but slow likewise.
  int RegionAt(const Vec3& p_W) const;
  /// Young's modulus (MPa) and Poisson's ratio at a world point, as the saw's teeth meet them: interpolated between the
  /// region voxels around it that have a material, E from the CT where it is used; 0 where there is none. Tick-safe,
  /// but slow likewise.
  double ModulusAt(const Vec3& p_W) const;
  double PoissonRatioAt(const Vec3& p_W) const;

  /// Whether CT numbers are in memory: an import keeps them when asked, and reading a file loads them when asked.
  bool has_hu() const;
  /// Edge of their voxels, mm; 0 when there are none.
  double hu_voxel_mm() const;

  bool empty() const;                               // no point with phi < 0
  double CalcVolume() const;                        // mm^3, piecewise-linear within each cell; exact for plane faces
  std::map<int, double> CalcRegionVolumes() const;  // mm^3 by region; sums to CalcVolume()
  Box3 CalcBounds() const;                          // of the surface, to about a voxel
  std::uint64_t CountActiveVoxels() const;          // of phi
  std::uint64_t CalcMemoryBytes() const;            // all grids
  /// Order-independent 64-bit hash of all phi values with |phi| < band and of the region grid: equal iff the bones are
  /// (nearly certainly) bit-identical.
  std::uint64_t CalcHash() const;
  /// Of what it is made of: the constants of all regions, and E from the CT where that is used.
  std::uint64_t CalcMaterialHash() const;

  struct Grids;  // OpenVDB lives behind this door: src/bone/grid/grids.h
  Grids& grids() { return *grids_; }
  const Grids& grids() const { return *grids_; }

 private:
  std::unique_ptr<Grids> grids_;
};

}  // namespace kerf
