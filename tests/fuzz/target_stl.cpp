#include "check_mesh.h"
#include "mesh/read.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(stl) {
  Takes([&] { CheckMesh(ReadStl(bytes, "fuzz.stl")); });
}

}  // namespace kerf::fuzz
