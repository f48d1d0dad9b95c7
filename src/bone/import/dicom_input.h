// A CT as a user has it: a folder, a medium, one of its files, or a ZIP file.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/files/temporary.h"
#include "bone/import/dicom.h"

namespace kerf {

/// The series of DICOM files at a path. A ZIP file is unpacked into a private folder, which exists as long as this
/// object.
class DicomInput {
 public:
  /// Returns whether the path is a folder, a DICOM file or a ZIP file. Throws kerf::Error for a pipe or a device.
  static bool Is(const std::string& path);

  /// Lists the series: see ListDicomSeries() and UnpackZip(), also for errors.
  explicit DicomInput(const std::string& path, const std::function<void(double)>& progress = {});

  const std::vector<DicomSeries>& series() const { return series_; }

  /// Returns the series as ChooseSeries() does; if the path is that of a slice and `uid` is empty, the series with this
  /// slice. Throws kerf::Error as ChooseSeries() does, or if the slice belongs to no series.
  DicomSeries Choose(const std::string& uid) const;

  /// Returns a message with the files of a ZIP file named by their places in it.
  std::string NameFiles(std::string message) const;

 private:
  std::string path_;
  std::unique_ptr<TemporaryFolder> unpacked_;
  bool is_slice_ = false;
  std::vector<DicomSeries> series_;
};

/// Returns the series as a CT, as the user confirms that it is one if `as_ct`. Throws UnclearSeries if it is not stated
/// to be a CT but may be one; CheckSeries() refuses the others.
DicomSeries TakeAsCt(DicomSeries series, bool as_ct);

/// Returns a picture of the series' middle slice: `side` x `side` grey values row by row, air black and what is
/// brightest white, the slice fitted in and centred on black. Returns nothing if the slice cannot be read. Takes a few
/// milliseconds.
std::vector<std::uint8_t> DrawMiddleSlice(const DicomSeries& series, int side);

}  // namespace kerf
