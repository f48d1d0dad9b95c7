#include "experiment/study/records.h"

namespace kerf {

std::string_view ToString(Holding holding) {
  return holding == Holding::kHand ? "hand" : "path";
}

}  // namespace kerf
