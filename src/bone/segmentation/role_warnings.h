// Warnings about segments whose meaning is known, but doubtful.
#pragma once

#include <vector>

#include "bone/segmentation/roles.h"

namespace kerf {

/// Warns about segments without voxels, teeth in several segments, and teeth whose name has a number that is not of
/// ISO 3950. `by_name`: for each segment, false if its meaning comes from a preset of labels, not from its name or
/// code.
void AddRoleWarnings(const Segmentation& segmentation, SegmentationRoles& roles, const std::vector<bool>& by_name);

}  // namespace kerf
