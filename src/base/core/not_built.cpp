#include "base/core/not_built.h"

#include <fmt/format.h>

#include "kerf/error.h"

namespace kerf {

void FailNotBuilt(const char* what, const char* option) {
  throw Error(fmt::format("this kerf was built without {} ({}=OFF)", what, option));
}

}  // namespace kerf
