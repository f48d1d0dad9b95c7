// Slices that were read without an error and whose values are nevertheless not those of their place.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/dicom_stack.h"

namespace kerf {

/// Slices whose values hardly are those of their place.
struct UnfitSlices {
  /// Certainly damaged: a slice, or a sixteenth of its rows, of one value each where both neighbours show something;
  /// and a slice whose values are exactly those of another one that is no neighbour.
  SliceFaults damaged;
  /// Perhaps damaged, but metal, few photons, motion and interpolation do the same: a slice unlike both neighbours,
  /// which are like each other; and a slice whose values are exactly those of a neighbour.
  SliceFaults doubtful;
};

/// Finds such slices. Where many slices are like that, it is the series. `slices`: in their order in space. `hu`: their
/// values, slice by slice.
UnfitSlices FindUnfitSlices(const std::vector<DicomSlice>& slices, const std::int16_t* hu);

}  // namespace kerf
