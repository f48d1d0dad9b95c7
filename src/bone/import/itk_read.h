// Reading of pixels through an itk::ImageIOBase into a volume. Only files of this folder that include ITK use it.
#pragma once

#include <itkImageIOBase.h>
#include <itkProcessObject.h>

#include <cstdint>
#include <functional>
#include <string>

#include "bone/import/volume.h"
#include "bone/import/voxel_values.h"

namespace kerf {

/// Suppresses output to the terminal during its lifetime: ITK, GDCM and the small C libraries used by them write there
/// if a file is invalid. Not for use by two threads at once, nor around a progress bar.
class QuietItk {
 public:
  QuietItk();
  ~QuietItk();
  QuietItk(const QuietItk&) = delete;
  QuietItk& operator=(const QuietItk&) = delete;

 private:
  std::streambuf* cerr_;
  std::streambuf* cout_;
  bool warnings_;
  int stderr_copy_;
};

/// Reads all pixels of `io`, whose ReadImageInformation() must have been called, and appends them to `out` as HU.
/// Throws kerf::Error, with `name` in the message, for colour, for values that are not numbers, or (with `complaint`)
/// if the file cannot be read to its end.
Overflow AppendPixels(itk::ImageIOBase& io, const std::string& name, std::vector<std::int16_t>& out,
                      const std::string& complaint = "the voxels can't be read");

/// From now on, calls `progress` (optional) with the fraction of the filter's work that is done, in the thread that
/// runs the filter. An exception that it throws ends the work and passes.
void ReportProgress(itk::ProcessObject& filter, const std::function<void(double)>& progress);

/// Returns the message of an ITK exception as one line.
std::string OneLine(const itk::ExceptionObject& e);

}  // namespace kerf
