// Slices that were read without an error and whose values are nevertheless not those of their place.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/dicom_stack.h"

namespace kerf {

/// Finds what is certainly damage: a slice, or a sixteenth of its rows, of one value each where both neighbours show
/// something; a slice unlike both neighbours, which are like each other; and a slice whose values are exactly those of
/// another one. Where many slices are like that, it is the series. `slices`: in their order in space. `hu`: their
/// values, slice by slice.
SliceFaults FindUnfitSlices(const std::vector<DicomSlice>& slices, const std::int16_t* hu);

}  // namespace kerf
