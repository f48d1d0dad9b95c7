// Version and build information.
#pragma once

namespace kerf {

const char* VersionString();    // "0.1.0"
const char* CommitString();     // abbreviated commit, with "+" appended if the tree was modified; "unknown" outside git
const char* CompilerString();   // "GCC 12.2.0, Release"
const char* LibrariesString();  // libraries of this build: "OpenVDB 10.0.1, ITK 5.2.1, ..."

}  // namespace kerf
