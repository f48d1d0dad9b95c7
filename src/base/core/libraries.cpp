#include "kerf/version.h"
#include "kerf_build_info.h"

namespace kerf {

const char* LibrariesString() {
  return KERF_LIBRARIES;
}

}  // namespace kerf
