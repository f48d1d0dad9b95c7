#include "session/scene/path_csv.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(path_csv) {
  Accepts([&] { ParsePathCsv(std::string(bytes), "fuzz.csv"); });
}

}  // namespace kerf::fuzz
