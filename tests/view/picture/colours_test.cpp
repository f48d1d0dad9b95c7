#include "view/picture/colours.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "kerf/simulation.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

// A cortical lid of 4 mm over a cancellous core, with a kerf across both.
class SlottedPlate : public ::testing::Test {
 protected:
  static Bone MakePlate() {
    BlockParams params;
    params.size_mm = {16, 10, 10};
    params.layers = {{4, 24}, {6, kCancellousRegion}};
    params.voxel_mm = 0.2;
    return MakeBlock(params, DefaultMandibleTable());
  }
};

TEST_F(SlottedPlate, SurfaceShowsTheTissueBelowIt) {
  const Bone bone = MakePlate();
  const TriangleMesh mesh = ExtractSurface(bone);
  const SurfaceColours colours = CalcSurfaceColours(bone, mesh, ColourBy::kTissue);
  ASSERT_EQ(colours.points.size(), mesh.points.size());
  std::size_t lid = 0;
  std::size_t core = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    // The layers meet at z = -4. Within a voxel of that, either colour is correct.
    if (mesh.points[i].z > -3.8) {
      ASSERT_EQ(colours.points[i], TissueColour(Tissue::kCortical)) << mesh.points[i].z;
      ++lid;
    } else if (mesh.points[i].z < -4.2) {
      ASSERT_EQ(colours.points[i], TissueColour(Tissue::kCancellous)) << mesh.points[i].z;
      ++core;
    }
  }
  EXPECT_GT(lid, 1000u);
  EXPECT_GT(core, 1000u);
  ASSERT_EQ(colours.legend.size(), 2u);
  EXPECT_EQ(colours.legend[0].text, "cancellous");  // core 160 + 312 mm2 of surface, lid 160 + 208 mm2
  EXPECT_EQ(colours.legend[1].text, "cortical");
}

TEST_F(SlottedPlate, FacesOfACutShowTheLayersInside) {
  const Pose X{{std::sqrt(0.5), 0, std::sqrt(0.5), 0}, {0, 0, 3}};  // disc across x, reaching down to z = -8
  SimulationParams params;
  DiscSaw thick;
  thick.thickness_mm = 1;
  params.tool = thick;
  Pose start = X;
  start.p_AB.z += 12;
  Simulation simulation(MakePlate(), params, start);
  for (int i = 1; i <= 120; ++i) {
    TickInput in;
    in.X_WT = start;
    in.X_WT.p_AB.z -= 0.1 * i;
    simulation.Tick(in);
  }
  const TriangleMesh mesh = ExtractSurface(simulation.UpdateBone());
  const SurfaceColours colours = CalcSurfaceColours(simulation.UpdateBone(), mesh, ColourBy::kTissue);
  std::size_t wall[2] = {0, 0};
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    if (std::abs(std::abs(p.x) - 0.5) > 0.1 || std::abs(p.y) > 4 || p.z > -0.6) continue;  // the kerf's two walls
    if (p.z > -3.8) {
      ASSERT_EQ(colours.points[i], TissueColour(Tissue::kCortical)) << p.z;
      ++wall[0];
    } else if (p.z < -4.2) {
      ASSERT_EQ(colours.points[i], TissueColour(Tissue::kCancellous)) << p.z;
      ++wall[1];
    }
  }
  EXPECT_GT(wall[0], 500u);
  EXPECT_GT(wall[1], 500u);
}

TEST_F(SlottedPlate, RegionsAreNamedWithTheirModulusAndPlainHasNoLegend) {
  const Bone bone = MakePlate();
  const TriangleMesh mesh = ExtractSurface(bone);
  const SurfaceColours regions = CalcSurfaceColours(bone, mesh, ColourBy::kRegion);
  ASSERT_EQ(regions.legend.size(), 2u);
  bool found = false;
  for (const LegendEntry& entry : regions.legend) {
    const bool is_24 = entry.text.rfind("24 ", 0) == 0;
    found = found || is_24;
    if (is_24) {
      EXPECT_EQ(entry.colour, RegionColour(24));
      EXPECT_THAT(entry.text, ::testing::HasSubstr(" GPa"));
    }
  }
  EXPECT_TRUE(found);
  const SurfaceColours plain = CalcSurfaceColours(bone, mesh, ColourBy::kPlain);
  EXPECT_THAT(plain.points, ::testing::Each(kBoneColour));
  EXPECT_TRUE(plain.legend.empty());
}

TEST(Colours, TissuesAlsoDifferInLightness) {
  const auto lightness = [](const Rgb8& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
  const Tissue tissues[] = {Tissue::kCortical, Tissue::kCancellous, Tissue::kTooth, Tissue::kCanal};
  for (const Tissue a : tissues) {
    for (const Tissue b : tissues) {
      if (a != b) {
        EXPECT_GT(std::abs(lightness(TissueColour(a)) - lightness(TissueColour(b))), 15);
      }
    }
  }
  for (int id = 1; id < 31; ++id) EXPECT_NE(RegionColour(id), RegionColour(id + 1));
  const std::vector<int> paper{24, 21, 13, 6};
  for (const int a : paper) {
    for (const int b : paper) {
      if (a != b) {
        EXPECT_NE(RegionColour(a), RegionColour(b));
      }
    }
  }
}

}  // namespace
}  // namespace kerf
