// Growth of markers over the bone of a CT until they touch.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

enum Marker : std::uint8_t { kUnmarked = 0, kKeep = 1, kDrop = 2, kOutside = 3 };

/// Grows the markers by a marker-controlled watershed (itk::MorphologicalWatershedFromMarkersImageFilter) on the relief
/// of HU and depth in the bone: borders form where the bone between two markers is thin or has low HU. Every voxel of
/// the result is kKeep, kDrop or kOutside; voxels marked kOutside remain kOutside.
/// `progress`, which is optional, is called with values from 0 to 1 and may throw Cancelled.
std::vector<std::uint8_t> GrowMarkers(const Volume& ct, double iso_hu, const std::vector<std::uint8_t>& markers,
                                      const std::function<void(double)>& progress = {});

}  // namespace kerf
