// Folders packed as ZIP files.
#pragma once

#include <functional>
#include <string>

namespace kerf {

/// Returns whether the file is named .zip and begins like a ZIP file. Throws kerf::Error as OpenImageFile() does.
bool IsZipFile(const std::string& path);

/// Unpacks a ZIP file into an existing folder that is empty and private. Names that lead out of the folder, or contain
/// unprintable characters, are changed. Leaves out what macOS adds. `progress` (optional) is called repeatedly and may
/// throw Cancelled. Throws kerf::Error with one sentence if the file is damaged or encrypted, contains more than
/// kMaxPackedFiles files or more than kMaxPackedBytes, or would be kMaxPackedRatio times as large when unpacked, or if
/// the disk has too little space.
void UnpackZip(const std::string& path, const std::string& folder, const std::function<void(double)>& progress);

}  // namespace kerf
