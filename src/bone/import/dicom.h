// CT series in a folder of DICOM files.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// A slice, as described by the header of its file, which has one or many.
struct DicomSlice {
  std::string path;
  Vec3 origin_W{0};     // centre of the first pixel, LPS mm
  Vec3 row_W{1, 0, 0};  // unit vector along a row, in the direction of increasing column number
  Vec3 column_W{0, 1, 0};
  std::array<double, 2> pixel_mm{1, 1};  // between columns, between rows
  std::array<int, 2> size{0, 0};         // columns, rows
  int samples = 1;                       // 3 for colour
  int bits = 0;                          // allocated per sample; 0: not given
  int frames = 1;                        // of the file
  bool has_geometry = false;             // true if position, orientation and pixel spacing are all present or assumed
  bool compressed = false;
  bool inverted = false;        // displayed with low values bright (MONOCHROME1); ITK inverts the values
  std::string transfer_syntax;  // name, from GDCM
  int frame = 0;                // index in the file, zero-based
  std::string stack;            // of the frames of a file: those of one stack and one point in time have the same
  std::string spacing_from;     // element that gives the distance between frames without positions; else empty
  bool has_spacing = true;      // false if nothing gives that distance; the slices are then placed 1 mm apart
  bool has_orientation = true;  // false if it was assumed: rows to the patient's left, columns to the back
  int bits_stored = 0;
  bool is_signed = false;
  double slope = 1, intercept = 0;  // HU = slope * stored value + intercept
  bool has_rescale = false;         // true if the file gives one of them
  bool has_padding = false;
  std::array<int, 2> padding{0, 0};  // first and last stored value that means that there is no data
  std::string fault;                 // why the values can't be read; empty if they can
};

/// Returns the unit normal of the slice's plane.
Vec3 CalcNormal(const DicomSlice& slice);

struct DicomSeries {
  std::string uid, description, modality;
  std::string study_date;          // YYYY-MM-DD; empty: not given
  std::vector<DicomSlice> slices;  // sorted by position along the normal if all have one, otherwise by file name
  double gap_mm = 0;               // median distance between neighbours along the normal; 0 if unknown
};

/// Returns all series in a folder and its subfolders, largest first. No personal names are read. Throws kerf::Error if
/// the folder cannot be read, contains no DICOM file, or contains a file that is named .dcm, .dicom or .ima but is not
/// a DICOM file. `progress`, which is optional, is called repeatedly and may throw Cancelled.
std::vector<DicomSeries> ListDicomSeries(const std::string& folder, const std::function<void(double)>& progress = {});

/// Returns the series to import, chosen by its UID or an unambiguous suffix of the UID; if `uid` is empty, the only CT
/// series. Throws kerf::Error if there is no such series, or more than one.
const DicomSeries& ChooseSeries(const std::vector<DicomSeries>& all, const std::string& uid, const std::string& folder);

/// Throws kerf::Error unless the series is a complete CT, as far as its headers tell: see ReadDicomSeries().
void CheckSeries(const DicomSeries& series, double spacing_z_mm = 0);

/// Reads the pixels. `progress`, which is optional, is called with values from 0 to 1. `spacing_z_mm`: between slices,
/// for files that don't state it; 0: as stated. Padding becomes air. Slices at two spacings are resampled to the finer
/// one, and slices missing in between are interpolated and listed in Volume::gaps; the volume's warnings say so. Throws
/// kerf::Error unless the series is a complete CT: for another modality, colour, unequally spaced slices, several
/// slices at one position, slices of different shape, rescale values that are no numbers or missing in some slices, a
/// transfer syntax that GDCM cannot unpack, or a truncated file.
Volume ReadDicomSeries(const DicomSeries& series, const std::function<void(double)>& progress, double spacing_z_mm = 0);

}  // namespace kerf
