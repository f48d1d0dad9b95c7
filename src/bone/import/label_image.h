// Label maps in one file: NRRD, NIfTI, MetaImage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "bone/import/volume.h"

namespace kerf {

/// Different values of a label map, with the background. CTs have thousands.
inline constexpr std::size_t kMaxDifferentLabels = 64;

/// Returns why values, which are `exact` as in Volume, are not those of a label map with at most `max_different`
/// labels; empty if they are.
std::string FindLabelObjection(std::span<const std::int16_t> values, bool exact, std::size_t max_different);

/// Reads a label map as ReadImageFile() reads a CT; `hu` has its labels, 0 is the background. Throws kerf::Error with
/// one sentence if the file cannot be read, or if its values are not those of a label map: integers from 0 to 32767, at
/// most kMaxDifferentLabels different ones.
Volume ReadLabelImage(const std::string& path);

}  // namespace kerf
