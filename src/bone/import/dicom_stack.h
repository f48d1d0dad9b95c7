// Where the slices of a DICOM series lie: an even stack of them.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// An even lattice of planes along which a series is read.
struct SliceStack {
  std::vector<DicomSlice> slices;   // sorted along their normal
  Vec3 origin_W{0};                 // centre of the first pixel of the first plane
  Vec3 step_W{0};                   // from plane to plane; sheared if the gantry was tilted
  std::vector<double> places;       // of the planes among the slices; 1.5: halfway between the second and third
  std::vector<DicomSlice> damaged;  // which were left out
  std::vector<std::string> warnings;
  std::vector<SliceGap> gaps;
};

/// Returns how a slice is named in messages: by its file, and by its frame if the file has several.
std::string NameOf(const DicomSlice& slice);

/// Why slices can't be read with the others, by their index: a sentence's end such as "it has no position".
using SliceFaults = std::map<std::size_t, std::string>;

/// Marks the slices as damaged. Throws kerf::Error, which names the first, if they are many: see AreFew().
void MarkFaulty(const DicomSeries& series, const SliceFaults& faults, std::vector<DicomSlice>& slices);

/// Takes the largest stack of a series whose slices all have a geometry, size and orientation, and places its slices.
/// Damaged ones count as missing, and so do a few that lie beside the others, between their
/// places or several at one place. `spacing_z_mm`:
/// as for ReadDicomSeries(). Throws kerf::Error if nothing gives their distance, if many lie beside the others or
/// several at one place, or if they are unequally spaced and neither rounding, nor two spacings, nor missing slices
/// explain it.
SliceStack PlaceSlices(const DicomSeries& series, double spacing_z_mm);

}  // namespace kerf
