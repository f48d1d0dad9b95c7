// Version and build information.
#pragma once

/// Version of the headers; VersionString() is that of the library.
#define KERF_VERSION_MAJOR 0
#define KERF_VERSION_MINOR 1
#define KERF_VERSION_PATCH 0
/// As one number, to be compared: 100 * (100 * major + minor) + patch.
#define KERF_VERSION_NUMBER (10000 * KERF_VERSION_MAJOR + 100 * KERF_VERSION_MINOR + KERF_VERSION_PATCH)

namespace kerf {

const char* VersionString();    // "0.1.0"
const char* CommitString();     // abbreviated commit, with "+" appended if the tree was modified; "unknown" outside git
const char* CompilerString();   // "GCC 12.2.0, Release"
const char* LibrariesString();  // libraries of this build: "OpenVDB 10.0.1, ITK 5.2.1, ..."

}  // namespace kerf
