// Check that the values of a volume are Hounsfield units.
#pragma once

#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Recognises a label map (2 to 128 different integers from 0 to 255) and a CT without its offset of -1024 (air near 0,
/// soft tissue near 1000 to 1100). Throws kerf::Error, with `name` in the message, if `iso_hu` cannot separate bone in
/// such a volume: for labels if it is outside their range, for the CT if it is below the soft tissue. Returns a warning
/// sentence if `iso_hu` fits the values of such a volume, and "" if the values are HU.
std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
