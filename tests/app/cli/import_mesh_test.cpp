// Tests of kerf import of surfaces, run as a program.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;

class ImportMesh : public test::ProgramTest {
 protected:
  // Writes boxes about the origin as an OBJ; a negative edge length makes the box face inwards.
  void WriteBoxes(const std::string& name, const std::vector<double>& edges) const {
    std::string points, faces;
    int first = 1;
    for (const double edge : edges) {
      for (int c = 0; c < 8; ++c) {
        const auto at = [&](int bit) { return std::to_string(0.5 * std::abs(edge) * ((c >> bit & 1) != 0 ? 1 : -1)); };
        points += "v " + at(0) + " " + at(1) + " " + at(2) + "\n";
      }
      constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
      for (const auto& f : kFaces) {
        faces += "f";
        for (int n = 0; n < 4; ++n) faces += fmt::format(" {}", first + f[edge < 0 ? 3 - n : n]);
        faces += "\n";
      }
      first += 8;
    }
    Write(name, points + faces);
  }
};

TEST_F(ImportMesh, HollowCubeHasItsVolumeAndNoFillFillsIt) {
  WriteBoxes("facing_in.obj", {30, -10});
  const ProgramResult hollow = Kerf("import facing_in.obj --voxel 0.5 -o a.vdb");
  ASSERT_EQ(hollow.code, 0) << hollow.err;
  EXPECT_THAT(hollow.out, HasSubstr("volume     26.00 cm3\n"));
  EXPECT_THAT(hollow.out, HasSubstr("surface    24 triangles in 2 shells; 1 inner shell left hollow (1.00 cm3 in all), "
                                    "because it faces inward\n"));
  WriteBoxes("facing_out.obj", {30, 10});
  EXPECT_THAT(Kerf("import facing_out.obj --voxel 0.5 -o a.vdb").out, HasSubstr("volume     27.00 cm3\n"));
  const ProgramResult json = Kerf("import facing_out.obj --voxel 0.5 --no-fill --json -o a.vdb");
  const auto report = nlohmann::json::parse(json.out);
  EXPECT_NEAR(report["volume_mm3"].get<double>(), 26000, 26);
  EXPECT_EQ(report["surface"]["hollow_shells"], 1);
}

TEST_F(ImportMesh, OptionsWithoutEffectAreRefused) {
  WriteBoxes("a.obj", {30});
  for (const char* option : {"--keep 1,2,3", "--drop 1,2,3", "--no-isolate", "--iso 400", "--series 1.2"}) {
    const ProgramResult result = Kerf(std::string("import a.obj -o a.vdb ") + option);
    EXPECT_EQ(result.code, 2) << option;
    EXPECT_THAT(result.err, HasSubstr("applies to a CT only, but INPUT is a surface, which is imported whole"))
        << option;
    EXPECT_FALSE(Exists("a.vdb"));
  }
  EXPECT_THAT(Kerf("import ct.nrrd -o a.vdb --units m").err, HasSubstr("applies to a surface only, but INPUT is a CT"));
  EXPECT_EQ(Kerf("import a.obj -o a.vdb --units feet").code, 2);
}

TEST_F(ImportMesh, AmbiguousUnitsAreRefusedAndTinyVolumesAreReadable) {
  WriteBoxes("a.obj", {0.5});
  const ProgramResult asks = Kerf("import a.obj -o a.vdb");
  EXPECT_EQ(asks.code, 1);
  EXPECT_THAT(asks.err, HasSubstr("--units m (it is then 500 mm) or --units mm to keep them unchanged"));
  const ProgramResult tiny = Kerf("import a.obj -o a.vdb --units mm --voxel 0.05");
  ASSERT_EQ(tiny.code, 0) << tiny.err;
  EXPECT_THAT(tiny.out, HasSubstr("volume     0.12"));
  EXPECT_THAT(tiny.out, HasSubstr(" mm3\n"));
  const ProgramResult none = Kerf("import a.obj -o none.vdb --units um");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("the surface encloses no piece of 0.001 mm3 or more; check its unit (--units)"));
  EXPECT_FALSE(Exists("none.vdb"));
}

}  // namespace
}  // namespace kerf
