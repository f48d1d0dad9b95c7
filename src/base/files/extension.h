// Extensions of file names.
#pragma once

#include <string>

namespace kerf {

/// Returns the extension of the path's file name in lower case, with its dot: ".vdb" for "BONE.VDB", ".gz" for
/// "ct.nii.gz"; empty if there is none.
std::string LowerExtension(const std::string& path);

}  // namespace kerf
