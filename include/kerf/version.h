// What this build is.
#pragma once

namespace kerf {

const char* VersionString();   // "0.1.0"
const char* CommitString();    // abbreviated commit, "+" appended when the tree was changed; "unknown" outside git
const char* CompilerString();  // "GCC 12.2.0, Release"

}  // namespace kerf
