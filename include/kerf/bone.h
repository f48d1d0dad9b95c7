// Bone: geometry (a level set) and material (regions with elastic constants).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

/// Edge of a voxel that kerf makes, half width of the level set's band, and significand of its distances.
inline constexpr Range kVoxelRange_mm{0.02, 4};
inline constexpr Range kBandRange_voxels{2, 8};
inline constexpr Range kPrecisionRange_bits{4, 24};

/// Leaf of the level set that a simulation has changed. `index` is the leaf's position {x, y, z}, counted in leaves (of
/// 8 x 8 x 8 voxels) from the world's origin. `values` points to its 512 current values, mm; `cut` to those
/// of minus the distance to what was cut (-band where nothing was), which are all that changes: `values` are the larger
/// of these and of the values before the first cut.
struct ChangedLeaf {
  std::array<int, 3> index;
  const float* values;
  const float* cut;
};

/// Bone as a narrow-band level set and a grid of region ids, both OpenVDB grids in the world frame.
///
/// phi is the signed distance to the surface in mm, negative inside, and clamped to +-band_mm() at larger distances.
/// Where a simulation has cut the surface, phi before the cut and the distance to the cut are kept as well, so that the
/// edge between them stays sharp in distances and volumes.
/// Its zero level is second-order accurate in the voxel size. Away from the zero level, the distance to an imported
/// surface is accurate to a fifth of a voxel. The region grid contains 0 outside the bone and the id of a region of
/// materials() elsewhere. It extends a little beyond the surface, so that a tooth that touches the surface finds a
/// material. The two grids may have different voxel sizes. Copies are independent of each other; moving a bone is
/// cheap.
class Bone {
 public:
  Bone();  // no voxels
  ~Bone();
  Bone(const Bone& other);
  Bone& operator=(const Bone& other);
  Bone(Bone&&) noexcept;
  Bone& operator=(Bone&&) noexcept;

  double voxel_mm() const;         // edge of a phi voxel, mm
  double region_voxel_mm() const;  // edge of a region voxel, mm
  double band_mm() const;          // half-width of the narrow band, mm; 3 voxels by default
  const MaterialTable& materials() const;
  void set_materials(MaterialTable table);
  /// Replaces the material constants for a run. Files of this bone are still written with the original constants.
  void OverrideMaterials(MaterialTable table);
  /// Provenance and other notes, stored in the file's metadata.
  const std::map<std::string, std::string>& notes() const;
  void set_note(const std::string& key, const std::string& value);

  /// Returns the signed distance at a world point, mm, interpolated trilinearly between voxel centres. Tick-safe, but
  /// slow: each call searches the tree.
  double SignedDistance(const Vec3& p_W) const;
  /// Returns the region id at a world point (nearest voxel), 0 if there is none. Tick-safe, but slow (tree search).
  int RegionAt(const Vec3& p_W) const;
  /// Return Young's modulus (MPa) and Poisson's ratio at a world point, as used for the forces on the teeth:
  /// interpolated between the surrounding region voxels that have a material, with E from the CT where that is enabled.
  /// Return 0 if there is no material. Tick-safe, but slow (tree search).
  double ModulusAt(const Vec3& p_W) const;
  double PoissonRatioAt(const Vec3& p_W) const;

  /// Returns true if CT numbers are in memory. CT import and file reading keep them only on request.
  bool has_hu() const;
  /// Edge of a CT voxel, mm; 0 if there are no CT numbers.
  double hu_voxel_mm() const;

  bool empty() const;                               // true if no voxel has phi < 0
  double CalcVolume() const;                        // mm^3; piecewise linear in each cell, exact for plane surfaces
  std::map<int, double> CalcRegionVolumes() const;  // mm^3 by region id; the sum equals CalcVolume()
  Box3 CalcBounds() const;                          // of the surface, world frame, accurate to about a voxel
  std::uint64_t CountActiveVoxels() const;          // of phi
  std::uint64_t CalcMemoryBytes() const;            // of all grids
  /// Computes an order-independent 64-bit hash of all phi values with |phi| < band and of the region grid. Two bones
  /// have equal hashes if and only if they are bit-identical (except for an improbable collision).
  std::uint64_t CalcHash() const;
  /// Computes a hash of the materials: the constants of all regions, and E from the CT where that is enabled.
  std::uint64_t CalcMaterialHash() const;

 private:
  friend struct BoneInternals;  // for kerf's own sources
  struct Grids;
  std::unique_ptr<Grids> grids_;
};

}  // namespace kerf
