// Are the values of a volume Hounsfield units?
#pragma once

#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Recognises a label map (2 to 128 different whole numbers from 0 to 255) and a CT without its offset of -1024 (air
/// near 0, soft tissue near 1000 to 1100). Throws Error naming `name` when `iso_hu` can't find bone in it: for labels
/// one not among them, for the CT one below its soft tissue. Returns a sentence to warn with when the iso value was
/// chosen for such numbers, "" for HU.
std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
