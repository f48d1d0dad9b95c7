// Directions of a file's coordinates in the patient.
#pragma once

#include <glm/mat3x3.hpp>
#include <string>
#include <vector>

#include "bone/import/volume.h"
#include "kerf/geometry.h"

namespace kerf {

/// `frame`: three letters, the directions in which x, y and z increase: L or R, A or P, S or I, in any order. Returns
/// the signed permutation that transforms vectors of that frame to LPS. Throws kerf::Error for other text.
glm::dmat3 LpsFromFrame(const std::string& frame);

/// Returns the letters of a signed permutation to LPS; the inverse of LpsFromFrame().
std::string FrameName(const glm::dmat3& lps_from_frame);

/// Sets the lattice of `volume` from `origin` and `steps` (columns: from voxel to voxel along i, j, k), both in the
/// coordinates of volume.frame and in units of `unit_mm`.
void PlaceLattice(const Vec3& origin, const glm::dmat3& steps, double unit_mm, Volume& volume);

/// Removes the warnings about the frame of a file, which the user has stated.
void DropFrameWarnings(std::vector<std::string>& warnings);

/// Transforms to LPS a volume whose coordinates were read as LPS but are actually those of `frame`.
void ReinterpretFrame(const std::string& frame, Volume& volume);

/// Returns the same volume with its voxels stored along the patient's axes: i, j and k increase, as nearly as possible,
/// to the left, to the back and to the head. Files that store one scan in different orders then give the same bone, bit
/// for bit.
Volume StoreAlongPatient(Volume volume);

}  // namespace kerf
