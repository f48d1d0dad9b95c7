#include "bone/mesh/read.h"
#include "check_mesh.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(ply) {
  Accepts([&] { CheckMesh(ReadPly(bytes, "fuzz.ply").mesh); });
}

}  // namespace kerf::fuzz
