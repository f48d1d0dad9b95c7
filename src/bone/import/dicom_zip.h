// Folders packed as ZIP files.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// Returns whether the file begins like a ZIP file, whatever its name. Throws kerf::Error as OpenImageFile() does.
bool IsZipFile(const std::string& path);

/// Unpacks a ZIP file into an existing folder that is empty and private. Names that lead out of the folder, or contain
/// unprintable characters, are changed. Leaves out what macOS adds. Returns the other files that were left out: damaged
/// ones, and those of more than kFreePackedBytes that are no DICOM files. `progress` (optional) is called repeatedly
/// and may throw Cancelled. Throws kerf::Error with one sentence if no file is left, if a file is encrypted, if the ZIP
/// file is cut off, contains more than kMaxPackedFiles files or more than kMaxPackedBytes, or would be kMaxPackedRatio
/// times as large when unpacked, or if the disk has too little space.
std::vector<LeftOutFile> UnpackZip(const std::string& path, const std::string& folder,
                                   const std::function<void(double)>& progress);

}  // namespace kerf
