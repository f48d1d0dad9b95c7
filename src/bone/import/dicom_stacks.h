// Stacks of slices among the images with one series UID, and what does not belong to any.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// Returns the stacks of a series, in the order of their first files, with their slices sorted. Left out are copies of
/// a slice, localizers, colour images, images of another modality, and images of which fewer than three have the same
/// size, orientation and spacing, or which are of another patient. Images of two patients, or of three or more slices
/// of a second study, are always separate stacks; acquisitions, phases, kernels and other properties are separated if
/// slices lie at the same place, or if two stacks overlap and are even only each for itself; phases and acquisitions
/// also if they are even together. `series`: with its slices in any order. Reads files whose slices may be copies of
/// each other.
std::vector<DicomSeries> DivideIntoStacks(DicomSeries series);

/// Returns why the slice does not fit to another one of its stack, by size, orientation or spacing, such as "has ...";
/// empty if it does.
std::string FindMisfit(const DicomSlice& slice, const DicomSlice& first);

/// Returns whether so many slices are exceptions among all, without which these can be read: one, or one in ten.
bool AreFew(std::size_t slices, std::size_t all);

/// Returns one sentence for each kind of file that was left out, with their number and the name of the first.
std::vector<std::string> DescribeLeftOut(const std::vector<LeftOutFile>& files);

/// Returns the length of the stack along the normal of its slices, mm; 0 if it is unknown.
double CalcLength(const DicomSeries& series);

}  // namespace kerf
