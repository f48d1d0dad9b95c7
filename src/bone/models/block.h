// The solid of a block or a plate (kerf/models.h).
#pragma once

#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/models.h"

namespace kerf {

/// Returns the signed distance to the block's surface, mm, exact everywhere. Tick-safe.
double CalcBlockDistance(const BlockParams& params, const Vec3& p_W);
/// Returns the region of the layer that contains the point or is nearest to it; on a border, that of the lower layer.
/// Tick-safe.
int CalcBlockRegion(const BlockParams& params, const Vec3& p_W);

/// Throws kerf::Error if a parameter is out of range, the pose is not valid, or a layer has an unknown region or lies
/// entirely below the block.
void CheckBlock(const BlockParams& params, const MaterialTable& materials);

}  // namespace kerf
