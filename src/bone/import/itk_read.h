// Pixels through an itk::ImageIOBase into a volume. Only files of this folder that include ITK use it.
#pragma once

#include <itkImageIOBase.h>

#include <cstdint>
#include <string>

#include "bone/import/volume.h"
#include "bone/import/voxel_values.h"

namespace kerf {

/// ITK, GDCM and the small C libraries behind them write to the terminal when a file is bad; while one of these lives
/// nothing is written to standard error. Not for two threads at once, nor around a progress bar.
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

/// Reads all pixels of `io`, whose ReadImageInformation() was called, and appends them to `out` as HU. Throws Error
/// naming `name` for colour, values that are not numbers, or (with `complaint`) a file that can't be read to its end.
Overflow AppendPixels(itk::ImageIOBase& io, const std::string& name, std::vector<std::int16_t>& out,
                      const std::string& complaint = "the voxels can't be read");

/// The message of an ITK exception in one line.
std::string OneLine(const itk::ExceptionObject& e);

}  // namespace kerf
