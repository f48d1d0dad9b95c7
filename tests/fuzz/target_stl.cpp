#include "bone/import/closed_surface.h"
#include "bone/import/shells.h"
#include "bone/mesh/read.h"
#include "check_mesh.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(stl) {
  Accepts([&] {
    TriangleMesh mesh = ReadStl(bytes, "fuzz.stl").mesh;
    CheckMesh(mesh);
    for (const TriangleMesh& layer : CloseSurface(std::move(mesh), false, "fuzz.stl").layers) {
      const EdgeCounts edges = CountEdges(layer);
      if (edges.open > 0 || edges.crowded > 0) Finding("a surface is still open after closing");
    }
  });
}

}  // namespace kerf::fuzz
