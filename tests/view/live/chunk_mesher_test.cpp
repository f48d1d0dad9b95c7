#include "view/live/chunk_mesher.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace kerf {
namespace {

TEST(ChunkMesher, NormalsOfAPlaneAreItsOwnUpToTheEndsOfTheSkirt) {
  const std::array<std::array<float, 3>, 4> normals{
      {{0.6f, 0.64f, 0.48f}, {-0.6f, 0.64f, -0.48f}, {0.8f, -0.6f, 0}, {0, 0.6f, 0.8f}}};
  std::size_t vertices = 0;
  for (const int cells : {4, 8, 16}) {
    for (const std::array<float, 3>& normal : normals) {
      for (float offset = -0.4f; offset < 1.5f; offset += 0.31f) {
        SampleBlock block;
        block.cells = cells;
        const int n = block.samples();
        for (int x = 0; x < n; ++x) {
          for (int y = 0; y < n; ++y) {
            for (int z = 0; z < n; ++z) {
              const auto along = [&](int i, int axis) {
                return normal[static_cast<std::size_t>(axis)] *
                       (static_cast<float>(i - 2) - offset * static_cast<float>(cells));
              };
              block.phi.push_back(along(x, 0) + along(y, 1) + along(z, 2));
            }
          }
        }
        CellSurface surface;
        MakeCellSurface(block, 0, true, surface);
        vertices += surface.vertices.size();
        for (const CellVertex& v : surface.vertices) {
          for (std::size_t i = 0; i < 3; ++i) {
            // The rounding of samples of at most 30 in single precision, twice in a difference over two cells.
            EXPECT_NEAR(v.normal[i], normal[i], 1e-5f)
                << cells << " cells, vertex in " << v.cell[0] << " " << v.cell[1] << " " << v.cell[2];
          }
        }
      }
    }
  }
  EXPECT_GT(vertices, 1000u);
}

}  // namespace
}  // namespace kerf
