// The line in which a planned plane meets the bone's surface.
#pragma once

#include <span>
#include <vector>

#include "bone/grid/removed.h"
#include "session/plan/plan.h"

namespace kerf {

/// Returns the lines in which the plane's rectangle meets the bone's surface, world frame, mm. A closed line repeats
/// its first point at the end; an open line ends at the border of the rectangle. Lines run counter-clockwise around the
/// bone, as seen from the side to which the normal points. Points are linear interpolations of phi on a lattice in the
/// plane of about one voxel (at most kMaxSectionSteps steps along either side), so their error is second order in the
/// lattice's spacing. Takes about 10 ms for 50 x 50 mm with voxels of 0.2 mm.
std::vector<std::vector<Vec3>> SectionLine(const PhiSampler& bone, const PlannedPlane& plane);

inline constexpr int kMaxSectionSteps = 1024;

/// Returns the plane with a rectangle around the parts of the bone's section that are nearest to the points, with a
/// margin of `margin_mm` on all sides. Returns it unchanged if it meets no bone within 120 mm of its centre. `near_W`:
/// world frame, mm. Takes a fifth of a second with voxels of 0.2 mm.
PlannedPlane FitToSection(const PhiSampler& bone, const PlannedPlane& plane, std::span<const Vec3> near_W,
                          double margin_mm = 4);

}  // namespace kerf
