#include "bone/models/recent_values.h"

#include <atomic>

namespace kerf {

std::uint64_t MakeFunctionId() {
  static std::atomic<std::uint64_t> made = 0;
  return ++made;
}

}  // namespace kerf
