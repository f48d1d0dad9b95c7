// CT series in a folder of DICOM files.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// One slice file, as its header says.
struct DicomSlice {
  std::string path;
  Vec3 origin_W{0};     // centre of the first pixel, LPS mm
  Vec3 row_W{1, 0, 0};  // unit vector along a row (growing column number)
  Vec3 column_W{0, 1, 0};
  std::array<double, 2> pixel_mm{1, 1};  // between columns, between rows
  std::array<int, 2> size{0, 0};         // columns, rows
  int samples = 1;                       // 3 for colour
  int bits = 16;                         // allocated a sample
  int frames = 1;
  bool has_geometry = false;  // position, orientation and pixel spacing are all there
  bool compressed = false;
  bool inverted = false;        // shown with low values bright (MONOCHROME1), and read inverted by ITK
  std::string transfer_syntax;  // name, as GDCM gives it
};

struct DicomSeries {
  std::string uid, description, modality;
  std::vector<DicomSlice> slices;  // by position along the normal where all have one, else by file name
  double gap_mm = 0;               // median distance of neighbours along the normal; 0 when unknown
};

/// All series under a folder (its sub-folders too), largest first. No names of people are read. Throws Error when the
/// folder can't be read, holds no DICOM file, or holds a file that is named .dcm, .dicom or .ima but isn't one.
std::vector<DicomSeries> ListDicomSeries(const std::string& folder);

/// The one to import: by UID (or its end, when unambiguous), or with an empty `uid` the only CT series. Throws Error.
const DicomSeries& ChooseSeries(const std::vector<DicomSeries>& all, const std::string& uid, const std::string& folder);

/// Reads the pixels. `progress` 0 to 1, may be empty. Throws Error for anything but a complete CT series: another
/// modality, colour, unequal or missing slices, several at one place, slices of different shape, a transfer syntax that
/// GDCM can't unpack, a file cut off.
Volume ReadDicomSeries(const DicomSeries& series, const std::function<void(double)>& progress);

}  // namespace kerf
