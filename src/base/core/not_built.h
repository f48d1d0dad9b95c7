// Optional parts of a build (KERF_WITH_... of CMake). Folders named "absent" contain their stand-ins.
#pragma once

namespace kerf {

/// Throws kerf::Error: "this kerf was built without {what} ({option}=OFF)".
[[noreturn]] void FailNotBuilt(const char* what, const char* option);

}  // namespace kerf
