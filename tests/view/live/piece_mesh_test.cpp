#include "view/live/piece_mesh.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <set>

#include "kerf/surface.h"
#include "support/chunks.h"
#include "view/live/palette.h"

namespace kerf {
namespace {

// A plate of 16 x 10 x 10 mm (4 mm of cortical bone above cancellous bone), and a part of it that was cut at x = 1.
TEST(PieceMesh, CutFacesShowTheirTissueAndTheRestThePiecesColour) {
  const Bone start = test::MakePlate(0.25);
  BlockParams params;
  params.size_mm = {9, 10, 10};
  params.layers = {{4, 24}, {6, kCancellousRegion}};
  params.voxel_mm = 0.25;
  TriangleMesh part = ExtractSurface(MakeBlock(params, DefaultMandibleTable()));
  for (Vec3& p : part.points) p.x -= 3.5;  // from x = -8 to 1
  const Rgb8 own = PieceColour(0);
  for (const std::size_t max_triangles : {std::size_t{1'000'000}, part.triangles.size() / 2}) {
    const PieceMesh piece = MakePieceMesh(start, part, own, max_triangles);
    ASSERT_EQ(piece.colours.size(), piece.mesh_P.points.size());
    EXPECT_LE(piece.mesh_P.triangles.size(), max_triangles);
    int cut = 0, uncut = 0;
    for (std::size_t i = 0; i < piece.colours.size(); ++i) {
      const Vec3& p = piece.mesh_P.points[i];
      // Half a millimetre around the edges is not compared: the level set is rounded there.
      const bool inside = p.y > -4.5 && p.y < 4.5 && p.z < -0.5 && p.z > -9.5;
      if (std::abs(p.x - 1) < 0.1 && inside && std::abs(p.z + 4) > 0.6) {
        EXPECT_EQ(piece.colours[i], CutColour(p.z > -4 ? Tissue::kCortical : Tissue::kCancellous));
        ++cut;
      } else if (p.x < 0.4) {
        EXPECT_EQ(piece.colours[i], own);
        ++uncut;
      }
    }
    EXPECT_GT(cut, 800);  // 9 x 9 mm with a point every 0.25 mm, without a strip: the cut face is never coarser
    EXPECT_GT(uncut, 100);
    // The merged surface still encloses the piece, within the cells' size.
    EXPECT_NEAR(CalcEnclosedVolume(piece.mesh_P), 900, 30);
  }
}

TEST(PieceMesh, ColoursRepeatAfterAll) {
  std::set<Rgb8> colours;
  for (int i = 0; i < kPieceColours; ++i) colours.insert(PieceColour(i));
  EXPECT_EQ(colours.size(), static_cast<std::size_t>(kPieceColours));
  EXPECT_EQ(PieceColour(kPieceColours), PieceColour(0));
  EXPECT_EQ(PieceColour(-1), PieceColour(0));
}

}  // namespace
}  // namespace kerf
