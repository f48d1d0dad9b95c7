// Which way the coordinates of a file point in the patient.
#pragma once

#include <glm/mat3x3.hpp>
#include <string>

#include "bone/import/volume.h"
#include "kerf/geometry.h"

namespace kerf {

/// `frame`: three letters, the directions in which x, y and z grow: L or R, A or P, S or I, in any order. Returns the
/// signed permutation that turns vectors of that frame into LPS. Throws Error for other text.
glm::dmat3 LpsFromFrame(const std::string& frame);

/// The letters of a signed permutation into LPS; the inverse of LpsFromFrame.
std::string FrameName(const glm::dmat3& lps_from_frame);

/// Puts the lattice of `volume` where `origin` and `steps` (columns: from voxel to voxel along i, j, k) say, both in
/// the coordinates of volume.frame and in units of `unit_mm`.
void PlaceLattice(const Vec3& origin, const glm::dmat3& steps, double unit_mm, Volume& volume);

/// Turns a volume that was read as LPS to the frame that its coordinates really have.
void StateFrame(const std::string& frame, Volume& volume);

/// The same volume with its voxels stored along the patient's axes: i, j and k grow, as nearly as they can, to the
/// left, to the back and to the head. Files of one scan that store it in different orders then give the same bone, bit
/// for bit.
Volume StoreAlongPatient(Volume volume);

}  // namespace kerf
