// Parts that a build may leave out (KERF_WITH_... of CMake). What stands in for them is in the folders "absent".
#pragma once

namespace kerf {

/// Throws Error: "this kerf was built without {what} ({option}=OFF)".
[[noreturn]] void FailNotBuilt(const char* what, const char* option);

}  // namespace kerf
