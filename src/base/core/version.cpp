#include "kerf/version.h"

#include "kerf_build_info.h"

namespace kerf {

const char* VersionString() {
  return KERF_VERSION;
}
const char* CommitString() {
  return KERF_COMMIT;
}
const char* CompilerString() {
  return "GCC " __VERSION__ ", " KERF_BUILD_TYPE;
}

}  // namespace kerf
