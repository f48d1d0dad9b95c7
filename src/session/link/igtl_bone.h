// Bones in messages of OpenIGTLink: label maps (IMAGE) and closed surfaces (POLYDATA), as 3D Slicer sends them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bone/import/volume.h"
#include "kerf/geometry.h"

namespace kerf {

/// Name of the messages that contain a bone.
inline constexpr const char* kBoneName = "kerf_bone";
/// Bytes of such a message: a label map of 512 x 512 x 512 voxels has half as many, or as many in two bytes each.
inline constexpr std::size_t kMaxBoneBytes = (std::size_t{256} << 20) + 4096;
inline constexpr std::size_t kMaxBoneVoxels = std::size_t{1} << 27;
inline constexpr std::size_t kMaxBoneTriangles = std::size_t{4} << 20;

/// Reads the content of an IMAGE that is a label map with one label. Returns it in LPS, with the values 0 and 1. Throws
/// kerf::Error with one sentence if it is something else, contradicts itself, or is larger than kMaxBoneVoxels.
Volume ReadIgtlLabelMap(std::span<const std::uint8_t> content);

/// Reads the polygons and strips of the content of a POLYDATA, in LPS; polygons are split into triangles. Throws
/// kerf::Error with one sentence if it contradicts itself, or has more than kMaxBoneTriangles. Whether it is closed is
/// not checked.
TriangleMesh ReadIgtlSurface(std::span<const std::uint8_t> content);

}  // namespace kerf
