// Stacks of slices among the images with one series UID, and what does not belong to any.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// An element that may tell stacks with one series UID apart, beside those that DicomSlice names.
struct TellingTag {
  std::uint16_t group, element;
  const char* name;
  bool follows = false;  // counts or dates the slices, so that those of a stack may follow those of another
};
/// In the order in which they are tried.
inline constexpr std::array kTellingTags{TellingTag{0x0018, 0x0060, "kV"},
                                         TellingTag{0x0018, 0x0081, "echo time in ms"},
                                         TellingTag{0x0018, 0x0010, "contrast agent"},
                                         TellingTag{0x0018, 0x0022, "scan options"},
                                         TellingTag{0x0018, 0x1030, "protocol"},
                                         TellingTag{0x0018, 0x1160, "filter"},
                                         TellingTag{0x0008, 0x103e, "description"},
                                         TellingTag{0x0008, 0x2111, "derivation"},
                                         TellingTag{0x0020, 0x4000, "comment"},
                                         TellingTag{0x0020, 0x0011, "series number"},
                                         TellingTag{0x0008, 0x0031, "series time", true},
                                         TellingTag{0x0018, 0x1060, "trigger time in ms", true},
                                         TellingTag{0x0008, 0x002a, "acquisition time", true},
                                         TellingTag{0x0008, 0x0033, "content time", true},
                                         TellingTag{0x0018, 0x1151, "tube current in mA"},
                                         TellingTag{0x0028, 0x1050, "window centre"},
                                         TellingTag{0x0020, 0x0013, "image number", true}};

/// Returns the stacks of a series, in the order of their first files, with their slices sorted. Left out are copies of
/// a slice, localizers, colour images, images of another modality, and images of which fewer than three have the same
/// size, orientation and spacing, or which are of another patient. Images of two patients, or of three or more slices
/// of a second study, are always separate stacks; acquisitions, phases, kernels and other properties, such as
/// kTellingTags and the folder, are separated if slices lie at the same place, or if two stacks overlap and are even
/// only each for itself; phases and acquisitions also if they are even together. Of a number, such as a time, it
/// suffices that the stacks follow each other. `series`: with its slices in any order. Reads files whose slices may be
/// copies of each other.
std::vector<DicomSeries> DivideIntoStacks(DicomSeries series);

/// Returns why the slice does not fit to another one of its stack, by size, orientation or spacing, such as "has ...";
/// empty if it does.
std::string FindMisfit(const DicomSlice& slice, const DicomSlice& first);

/// Returns whether a series of `all` slices can be read without `slices` of them: one, or at most a tenth.
bool AreFew(std::size_t slices, std::size_t all);

/// Returns one sentence for each kind of file that was left out, with their number and the name of the first.
std::vector<std::string> DescribeLeftOut(const std::vector<LeftOutFile>& files);

/// Returns the length of the stack along the normal of its slices, mm; 0 if it is unknown.
double CalcLength(const DicomSeries& series);

}  // namespace kerf
