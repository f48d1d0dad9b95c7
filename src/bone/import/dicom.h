// CT series in a folder of DICOM files.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bone/import/volume.h"
#include "kerf/error.h"

namespace kerf {

/// A slice, as described by the header of its file, which has one or many.
struct DicomSlice {
  static constexpr int kHasSlope = 1, kHasIntercept = 2;  // of `rescale`

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
  // What tells the stacks of one series apart; empty or 0: not stated. Texts are printable UTF-8.
  std::string class_uid;     // SOP class
  std::string instance_uid;  // SOP instance
  std::string modality;
  std::string image_type;     // values separated by backslashes
  std::uint64_t patient = 0;  // hash of the identifier with its issuer, or else of the name
  std::uint64_t study = 0;    // hash of the study's UID
  std::string phase;          // temporal position
  std::string acquisition;    // number
  std::string acquisition_time;
  std::string kernel;                // of the reconstruction
  std::vector<std::string> telling;  // values of kTellingTags
  double thickness_mm = 0;
  std::uint64_t pixels_at = 0;  // offset in the file from which to look for the pixels
  std::string damage;           // why its pixels are missing, a sentence with the path; empty: not known to be
  int frame = 0;                // index in the file, zero-based
  std::string stack;            // of the frames of a file: those of one stack and one point in time have the same
  std::string spacing_from;     // element that gives the distance between frames without positions; else empty
  bool has_spacing = true;      // false if nothing gives that distance; the slices are then placed 1 mm apart
  bool has_orientation = true;  // false if it was assumed: rows to the patient's left, columns to the back
  int bits_stored = 0;
  bool is_signed = false;
  double slope = 1, intercept = 0;  // HU = slope * stored value + intercept
  int rescale = 0;                  // which of them the file gives: kHasSlope, kHasIntercept
  bool has_padding = false;
  std::array<int, 2> padding{0, 0};  // first and last stored value that means that there is no data
  std::string fault;                 // why the values can't be read; empty if they can
};

/// Returns the unit normal of the slice's plane.
Vec3 CalcNormal(const DicomSlice& slice);

/// A file that does not belong to a series, or cannot be read.
struct LeftOutFile {
  std::string path;
  std::string kind;           // completes "2 files were left out (...)"
  std::string fault;          // complete sentence with the path
  bool may_be_slice = false;  // if a slice is missing, it may be this file
};

/// A stack of slices. Usually it is all that has one series UID; two patients, acquisitions or phases with one UID are
/// separate stacks.
struct DicomSeries {
  std::string uid, description, modality;
  std::string study_date;          // YYYY-MM-DD; empty: not given
  std::string frame_uid;           // of the frame of reference; empty: not given
  std::vector<DicomSlice> slices;  // sorted by position along the normal if all have one, otherwise by file name
  double gap_mm = 0;               // median distance between neighbours along the normal; 0 if unknown
  int part = 0;                    // number of the stack among those with this UID, from 1; 0: the only one
  std::string part_name;           // what tells it apart, such as "acquisition 2", or "localizer"
  std::vector<LeftOutFile> left_out;
  std::vector<std::string> warnings;  // one sentence each: what was left out and, of a chosen series, why it was chosen

  /// Returns the text that chooses it: the UID, with "#2" for the second of several stacks.
  std::string name() const { return part == 0 ? uid : uid + "#" + std::to_string(part); }
  /// Returns the distance between slices that the files state; 0: none.
  double stated_gap_mm() const { return slices.front().has_spacing ? gap_mm : 0; }
};

/// Which series is meant, or whether it is a CT, must be decided by the user.
class UnclearSeries : public Error {
 public:
  /// `what`: for a terminal, with options of kerf import. `why`: the reason alone, in words. `series`: to choose from.
  UnclearSeries(const std::string& what, std::string why, std::vector<DicomSeries> series)
      : Error(what), why_(std::move(why)), series_(std::move(series)) {}
  const std::string& why() const { return why_; }
  const std::vector<DicomSeries>& series() const { return series_; }
  /// Of the series: see DrawMiddleSlice(); empty if the import shows nothing.
  std::vector<std::vector<std::uint8_t>> pictures;

 private:
  std::string why_;
  std::vector<DicomSeries> series_;
};

/// Returns all series of DICOM files, largest first. `path`: a folder, with its subfolders; a DICOMDIR, for its folder;
/// or another DICOM file, for the files beside it or, if it has several frames and no other file continues it, for
/// itself. No personal names are kept. Files that are no images, are damaged, or do not belong to their series are left
/// out and listed in `left_out`. Throws kerf::Error if `path` cannot be read or contains no DICOM image. `progress`,
/// which is optional, is called repeatedly and may throw Cancelled.
std::vector<DicomSeries> ListDicomSeries(const std::string& path, const std::function<void(double)>& progress = {});

/// Returns whether the file is a DICOMDIR, the list of the files on a medium. Throws kerf::Error as IsDicomFile() does.
bool IsDicomDirectory(const std::string& path);

/// Returns whether images of this modality may be those of a CT that another program wrote, such as OT. Their values
/// are read only if the user confirms it.
bool MayBeCt(const std::string& modality);

/// Returns the series to import, chosen by its name (DicomSeries::name()) or UID or an unambiguous end of either. If
/// `uid` is empty or several stacks have this UID, takes the CT series that clearly suits a jaw best, and warns: it is
/// large and fine enough to show one, original rather than derived, and has 1.5 times as many slices as any other such
/// series or, with as many slices, alone a kernel for bone. Throws UnclearSeries if no series is, or if it is one of
/// several patients, and kerf::Error if there is no CT.
DicomSeries ChooseSeries(const std::vector<DicomSeries>& all, const std::string& uid, const std::string& folder);

/// Returns the series with its slices where ReadDicomSeries() places them, without damaged ones, and with what was
/// assumed about their places among its warnings. Throws kerf::Error unless it is a complete CT, as far as its headers
/// tell: see ReadDicomSeries().
DicomSeries CheckSeries(const DicomSeries& series, double spacing_z_mm = 0);

/// Reads the pixels. `progress`, which is optional, is called with values from 0 to 1. `spacing_z_mm`: between slices,
/// for files that don't state it; 0: as stated. Padding becomes air. Slices at two spacings are resampled to the finer
/// one, and slices missing in between are interpolated and listed in Volume::gaps, also those whose files are damaged;
/// the volume's warnings say so. Throws kerf::Error unless the series is a complete CT: for another modality, colour,
/// unequally spaced slices, several slices at one position, slices of different shape, rescale values that are no
/// numbers or missing in some slices, a transfer syntax that GDCM cannot unpack, or fewer than three whole files.
Volume ReadDicomSeries(const DicomSeries& series, const std::function<void(double)>& progress, double spacing_z_mm = 0);

}  // namespace kerf
