// What this build is.
#pragma once

namespace kerf {

const char* VersionString();    // "0.1.0"
const char* CommitString();     // abbreviated commit, "+" appended when the tree was changed; "unknown" outside git
const char* CompilerString();   // "GCC 12.2.0, Release"
const char* LibrariesString();  // those it was built with: "OpenVDB 10.0.1, ITK 5.2.1, ..."

}  // namespace kerf
