#include "bone/mesh/read.h"
#include "check_mesh.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(obj) {
  Accepts([&] { CheckMesh(ReadObj(bytes, "fuzz.obj").mesh); });
}

}  // namespace kerf::fuzz
