#include <sstream>

#include "bone/vdb/bonefile.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(bonefile) {
  std::istringstream in{std::string(bytes)};
  Accepts([&] { ReadBone(in, "fuzz.vdb", {.hu = true}); });
}

}  // namespace kerf::fuzz
