// The values of the slices in a DICOM file. Only for a child process: GDCM may abort on a damaged file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bone/import/dicom.h"
#include "bone/import/voxel_values.h"

namespace kerf {

/// Throws kerf::Error if the slice's file is larger than kerf reads or too short to contain its pixels. Must be called
/// before memory is allocated for them.
void CheckFileSize(const DicomSlice& slice);

/// The stored values of all frames of a file, which is mapped into memory, or unpacked by GDCM if it is compressed.
class FilePixels {
 public:
  /// `any`: a slice of the file. Throws kerf::Error if the file is cut off or its pixels can't be read.
  explicit FilePixels(const DicomSlice& any);
  ~FilePixels();
  FilePixels(const FilePixels&) = delete;
  FilePixels& operator=(const FilePixels&) = delete;
  /// Returns the bytes of one frame.
  std::string_view Frame(int frame) const { return pixels_.substr(static_cast<std::size_t>(frame) * bytes_, bytes_); }
  int bytes_per_value() const { return bytes_per_value_; }
  bool big_endian() const { return big_endian_; }
  /// Returns the number of bytes that the element has behind the pixels, apart from padding to an even length.
  std::size_t bytes_behind() const { return bytes_behind_; }

 private:
  void FindPixels(const DicomSlice& any);
  void Unpack(const DicomSlice& any);

  std::string_view mapped_;
  std::vector<char> unpacked_;
  std::string_view pixels_;
  std::size_t bytes_ = 0;  // of a frame
  int bytes_per_value_ = 2;
  bool big_endian_ = false;
  std::size_t bytes_behind_ = 0;
};

/// What was found among the values of slices.
struct SliceValues {
  std::size_t overflow = 0;  // values that were clamped
  double extreme = 0;        // the one farthest from 0
  std::size_t padding = 0;   // voxels of padding that are not like air as they are stored
  int padding_value = 0;     // one of them, as stored
  bool is_marked = false;    // some padding is marked as such: see HuTable::Convert()
  std::size_t behind = 0;    // bytes behind the pixels, which were ignored
};

/// Converts stored values to HU: those of padding to -1024.
class HuTable {
 public:
  /// Writes the HU of a slice to `hu`, whose size is that of the slice. `padding`: one bit of each pixel; sets those of
  /// padding whose stored value no air has.
  void Convert(const FilePixels& file, const DicomSlice& slice, std::span<std::int16_t> hu, std::span<char> padding,
               SliceValues& found);

 private:
  struct Entry {
    std::int16_t hu = 0;
    bool clamped = false;
    bool padding = false;  // not like air as it is stored, so that it is counted
    bool marked = false;   // padding that is not exactly like air
    bool above = false;    // has bits above those of the value
  };
  static Entry MakeEntry(const DicomSlice& slice, std::uint32_t word, int bytes, double& exact_hu);
  void Fill(const DicomSlice& slice, int bytes);

  std::vector<Entry> entries_;  // by the stored word of up to 16 bits
  DicomSlice filled_;           // for which slice they are right
};

}  // namespace kerf
