// A CT volume in memory: Hounsfield units on a lattice that may be oblique in the patient.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Where slices are missing from a scan: between the planes of the slices beside them. Where nothing was read beyond
/// one of these, both planes are that of the other.
struct SliceGap {
  Vec3 normal_W{0, 0, 1};  // of the planes, unit length
  double from_mm = 0;      // dot(normal_W, p_W) of a point in the plane
  double to_mm = 0;
  std::string what;  // for a message, such as "series 1.2: 1 slice is missing between a.dcm and b.dcm"
};

/// HU rounded to integers and clamped to the range of 16 bits. World W is the patient frame, LPS, mm.
struct Volume {
  std::array<int, 3> size{0, 0, 0};  // voxels along i, j, k
  Vec3 spacing_mm{1};
  Vec3 origin_W{0};                   // centre of voxel (0, 0, 0)
  glm::dmat3 axes_W{1};               // columns: unit vectors of i, j, k in W; k may be sheared (tilted gantry)
  std::vector<std::int16_t> hu;       // i fastest
  bool exact = true;                  // false if values of an image file were rounded or clamped
  std::string frame = "LPS";          // of the file's coordinates (patient_frame.h)
  std::vector<std::string> warnings;  // one sentence for each property that the file does not define, with the
                                      // assumption made
  std::vector<SliceGap> gaps;         // DICOM: the values there are interpolated
  std::vector<bool> padding;          // of each voxel, whether it is air because nothing was scanned there, such as
                                      // outside the scanner's circle; empty: no voxel is known to be

  std::size_t count() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
  std::size_t Index(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size[1] + j) * size[0] + i; }
  Vec3 WorldFromVoxel(const Vec3& p_V) const { return origin_W + axes_W * (p_V * spacing_mm); }
  Vec3 VoxelFromWorld(const Vec3& p_W) const { return (glm::inverse(axes_W) * (p_W - origin_W)) / spacing_mm; }
  bool Contains(const std::array<int, 3>& ijk) const {
    return ijk[0] >= 0 && ijk[1] >= 0 && ijk[2] >= 0 && ijk[0] < size[0] && ijk[1] < size[1] && ijk[2] < size[2];
  }
  double CalcVoxelVolume() const;  // mm^3
};

/// Returns a 64-bit hash of the values and the lattice (FNV-1a), for provenance.
std::uint64_t CalcHash(const Volume& volume);
/// Throws kerf::Error, with `name` in the message, unless the lattice is finite and not degenerate (right- or
/// left-handed) and its spacing is 0.01 to 20 mm.
void CheckLattice(const Volume& volume, const std::string& name);
/// Returns the part between two voxels, both included, in the same position. Voxels beyond the scan are air.
Volume Crop(const Volume& volume, const std::array<int, 3>& lower, const std::array<int, 3>& upper);

}  // namespace kerf
