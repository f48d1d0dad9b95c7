// Steps of Isolate() that use a mask, and those that they share with the others.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bone/import/isolate.h"

namespace kerf {

inline constexpr double kMargin_mm = 10;  // around a candidate or a mask

/// Returns the part of the CT from `lower` to `upper` with a margin, which has a few voxels of air beyond the scan.
Volume CropAround(const Volume& ct, const std::array<int, 3>& lower, const std::array<int, 3>& upper, double margin_mm);

/// Returns the bone voxel nearest to a point of `--option`. Throws kerf::Error if there is none nearby.
std::array<int, 3> Snap(const Volume& ct, double iso_hu, const Vec3& p_W, const char* option);

/// Makes the crop and the markers of a mask, on the crop. Throws kerf::Error if the mask does not fit the scan.
std::vector<std::uint8_t> MarkMask(const Volume& ct, const IsolateOptions& options, Isolation& result);

/// Gives bone that the mask names, and that the watershed gave to the other side, back if it is more than a layer of
/// one voxel, or much: then the CT shows no border there. The watershed is repeated with this bone as markers.
/// `markers`: of the watershed that gave `grown`.
void GiveBack(const Isolation& result, double iso_hu, std::vector<std::uint8_t> markers,
              std::vector<std::uint8_t>& grown);

/// Returns 1 for the bone that is joined to the wanted bone, that a mask marked as unwanted because it lies outside,
/// and that is in no segment of other bone.
std::vector<std::uint8_t> FindCutOff(const Isolation& result, double iso_hu, const std::vector<std::uint8_t>& markers);

/// Finds the bone that the mask names and that is not in the result, and its greatest distance from it.
void FindGivenAway(Isolation& result, double iso_hu);

}  // namespace kerf
