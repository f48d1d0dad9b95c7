// Tests of kerf slab, run as a program.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kerf/geometry.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::HasSubstr;

/// Reads an OBJ as other programs would.
TriangleMesh ReadObj(const std::filesystem::path& path) {
  TriangleMesh mesh;
  std::istringstream lines(test::Slurp(path));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Vec3 p;
      words >> p.x >> p.y >> p.z;
      mesh.points.push_back(p);
    } else if (word == "f") {
      std::array<std::uint32_t, 3> t;
      words >> t[0] >> t[1] >> t[2];
      for (auto& id : t) --id;
      mesh.triangles.push_back(t);
    }
  }
  return mesh;
}

/// Reads a binary STL and merges points with equal coordinates.
TriangleMesh ReadStl(const std::filesystem::path& path) {
  const std::string bytes = test::Slurp(path);
  TriangleMesh mesh;
  std::uint32_t count = 0;
  if (bytes.size() < 84) return mesh;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(bytes.size(), 84 + 50 * std::size_t{count});
  std::map<std::array<float, 3>, std::uint32_t> ids;
  for (std::size_t n = 0; n < count && 84 + 50 * (n + 1) <= bytes.size(); ++n) {
    std::array<std::uint32_t, 3> t;
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<float, 3> p;
      std::memcpy(p.data(), bytes.data() + 84 + 50 * n + 12 + 12 * k, 12);
      const auto [at, is_new] = ids.try_emplace(p, static_cast<std::uint32_t>(mesh.points.size()));
      if (is_new)
        mesh.points.emplace_back(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
      t[k] = at->second;
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

class Slab : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    // The block extends from z = 0 down to -10 and has four long edges along x.
    ASSERT_EQ(Kerf("model block --size 30,12,10 --voxel 0.2 --layer 2:24 --layer 8:32 -o block.vdb").code, 0);
  }
  Json Report(const std::string& arguments) {
    const ProgramResult result = Kerf("slab block.vdb --json --no-picture -o out " + arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(result.out, test::Slurp(folder_ / "out/parts.json"));
    return Json::parse(result.out);
  }
  /// Returns the plane of the report, which must be equal for a --plane and for markups of the same plane.
  Json PlaneOf(const std::string& markups) {
    Write("plane.mrk.json", markups);
    return Report("--plane-markups plane.mrk.json --formats obj --triangles 2000")["plane"];
  }
};

TEST_F(Slab, FilesAreClosedOrientedOutwardAndOfTheRequestedThickness) {
  const Vec3 p(0.3, 0.2, -5);
  const Vec3 normals[] = {{1, 0, 0}, {1, 0.5, -0.3}};
  for (const Vec3& n : normals) {
    const Vec3 normal = n / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    for (const double t : {0.25, 1.0}) {
      const Json report =
          Report(fmt::format("--plane {},{},{},{},{},{} --thickness {}", p.x, p.y, p.z, n.x, n.y, n.z, t));
      EXPECT_NEAR(report["difference_percent"].get<double>(), 0, 0.1);
      EXPECT_NEAR(report["measured_thickness_mm"].get<double>(), t, 1e-4);
      // The solid is a prism along x without its bevelled rim. The volume is accurate to 0.1 %; the flat part of a face
      // lacks a rim of about a voxel.
      EXPECT_NEAR(report["section_mm2"].get<double>(), 120 / normal.x, 0.01 * 120 / normal.x);
      EXPECT_NEAR(report["flat_face_mm2"]["left"].get<double>(), 120 / normal.x, 0.1 * 120 / normal.x);
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Json& part = report["parts"][i];
        const std::string name = part["name"];
        sum += part["volume_mm3"].get<double>();
        EXPECT_TRUE(part["closed"].get<bool>());
        for (const bool stl : {false, true}) {
          const TriangleMesh mesh =
              stl ? ReadStl(folder_ / ("out/" + name + ".stl")) : ReadObj(folder_ / ("out/" + name + ".obj"));
          EXPECT_EQ(mesh.triangles.size(), part["triangles"].get<std::size_t>());
          EXPECT_EQ(CountOpenEdges(mesh), 0u) << name;
          // Edges are bevelled by up to a voxel.
          EXPECT_NEAR(CalcEnclosedVolume(mesh) / part["volume_mm3"].get<double>(), 1, 0.03) << name;
          if (name != "slice") continue;
          // The outermost points are those of the faces. Floats of up to 15 mm have rounding errors of 1e-6 mm.
          double lower = 1e9;
          double upper = -1e9;
          for (const Vec3& q : mesh.points) {
            const Vec3 d = q - p;
            const double s = d.x * normal.x + d.y * normal.y + d.z * normal.z;
            lower = std::min(lower, s);
            upper = std::max(upper, s);
          }
          EXPECT_NEAR(lower, -0.5 * t, 1e-5);
          EXPECT_NEAR(upper, 0.5 * t, 1e-5);
        }
        const Json info = Json::parse(Kerf("info --json out/" + name + ".vdb").out);
        EXPECT_NEAR(info["volume_mm3"].get<double>(), part["volume_mm3"].get<double>(), 1e-9 * sum);
      }
      EXPECT_NEAR(sum, report["sum_mm3"].get<double>(), 1e-9 * sum);
    }
  }
}

TEST_F(Slab, TableStatesTheVolumesAndPictureIsDrawn) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const ProgramResult result = Kerf("slab block.vdb --plane 0,0,-5,1,0,0 -o out --formats stl --triangles 400");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("slice      0.25 mm thick; 0.2500 mm between the faces"));
  EXPECT_THAT(result.out, HasSubstr("written    out/: left.stl slice.stl right.stl parts.png parts.json\n"));
  EXPECT_TRUE(Exists("out/parts.png"));
  EXPECT_FALSE(Exists("out/left.obj"));
  EXPECT_FALSE(Exists("out/left.vdb"));
  EXPECT_LE(ReadStl(folder_ / "out/left.stl").triangles.size(), 400u);
}

TEST_F(Slab, MarkupsInLpsAndRasGiveTheSamePlaneAsNumbersDo) {
  const Json plane = Report("--plane 1.5,0.25,-4,2,0.4,-0.6 --formats obj --triangles 2000")["plane"];
  // Vectors in the file need not have unit length.
  const char* form = R"({{"markups": [{{"type": "Plane", "coordinateSystem": "{}", "planeType": "pointNormal",
      "center": [{}, {}, -4], "normal": [{}, {}, -0.6], "controlPoints": []}}]}})";
  const Json lps = PlaneOf(fmt::format(fmt::runtime(form), "LPS", 1.5, 0.25, 2, 0.4));
  const Json ras = PlaneOf(fmt::format(fmt::runtime(form), "RAS", -1.5, -0.25, -2, -0.4));
  EXPECT_EQ(lps, plane);
  EXPECT_EQ(ras, plane);
}

TEST_F(Slab, BadUsageIsRefused) {
  ExpectRefusal(
      Kerf("slab none.vdb --plane 0,0,-5,1,0,0 -o out"),
      "none.vdb: there is no such file; 'kerf import INPUT -o none.vdb' makes it from a CT or a closed surface");
  ExpectRefusal(Kerf("slab block.vdb --plane 40,0,-5,1,0,0 -o out"),
                "the plane misses the bone: along its normal the bone lies -54.80 to -25.20 mm from the plane");
  EXPECT_FALSE(Exists("out"));
  for (const char* arguments :
       {"slab block.vdb -o out", "slab block.vdb --plane 0,0,-5,1,0,0", "slab block.vdb --plane 0,0,-5,1,0 -o out",
        "slab block.vdb --plane 0,0,-5,0,0,0 -o out", "slab block.vdb --plane 0,0,nan,1,0,0 -o out",
        "slab block.vdb --plane 0,0,-5,1,0,0 --plane-markups a.mrk.json -o out",
        "slab block.vdb --plane 0,0,-5,1,0,0 --thickness 0 -o out",
        "slab block.vdb --plane 0,0,-5,1,0,0 --formats ply -o out",
        "slab block.vdb --plane 0,0,-5,1,0,0 --near 1,2 -o out",
        "slab block.vdb --plane 0,0,-5,1,0,0 --near 1,2,3 --everywhere -o out"}) {
    EXPECT_EQ(Kerf(arguments).code, 2) << arguments;
  }
  EXPECT_THAT(Kerf("slab block.vdb --plane 0,0,-5,1 -o out").err,
              HasSubstr("'0,0,-5,1' must be a point and a normal, x,y,z,nx,ny,nz"));
  EXPECT_THAT(Kerf("slab block.vdb -o out").err, HasSubstr("give the plane by either --plane or --plane-markups"));
  ExpectRefusal(Kerf("slab block.vdb --plane-markups none.mrk.json -o out"), "none.mrk.json: there is no such file");
}

TEST_F(Slab, BoneIsNeverOverwritten) {
  std::filesystem::create_directory(folder_ / "work");
  std::filesystem::copy(folder_ / "block.vdb", folder_ / "work/left.vdb");
  const std::string before = test::Slurp(folder_ / "work/left.vdb");
  ExpectRefusal(Kerf("slab work/left.vdb --plane 0,0,-5,1,0,0 -o ./work"),
                "work/left.vdb: is an input and would be overwritten by ./work/left.vdb; choose another output");
  EXPECT_EQ(test::Slurp(folder_ / "work/left.vdb"), before);
  EXPECT_FALSE(Exists("work/left.obj"));
}

TEST_F(Slab, MarkupsAreNeverOverwritten) {
  std::filesystem::create_directory(folder_ / "out");
  const std::string plane = R"({"markups": [{"type": "Plane", "coordinateSystem": "LPS", "center": [0, 0, -5],
      "normal": [1, 0, 0], "controlPoints": []}]})";
  Write("out/parts.json", plane);
  ExpectRefusal(Kerf("slab block.vdb --plane-markups out/parts.json -o out"),
                "out/parts.json: is an input and would be overwritten by out/parts.json; choose another output");
  EXPECT_EQ(test::Slurp(folder_ / "out/parts.json"), plane);
}

TEST_F(Slab, NormalMayHaveAnyLength) {
  const Json plane = Report("--plane 0,0,-5,1,2,-0.5 --formats obj --triangles 2000")["plane"];
  for (const char* normal : {"1e200,2e200,-5e199", "1e-200,2e-200,-5e-201", " 1, +2, -.5"}) {
    const Json same = Report(fmt::format("'--plane=0,0,-5,{}' --formats obj --triangles 2000", normal))["plane"];
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(same["normal"][i].get<double>(), plane["normal"][i].get<double>(), 1e-15) << normal;
    }
  }
}

TEST_F(Slab, InvalidNumbersAreReported) {
  const std::string cut = "slab block.vdb -o out --plane ";
  for (const char* plane : {"0,0,-5,1,0,0,", "0,0,-5,0x1,0,0", "0,0,-5,1,0,0,0", "0,0,-5,1,0,inf", "0,,-5,1,0,0"}) {
    const ProgramResult result = Kerf(cut + plane);
    EXPECT_EQ(result.code, 2) << plane;
    EXPECT_THAT(result.err, HasSubstr(fmt::format("'{}' must be a point and a normal, x,y,z,nx,ny,nz", plane)));
  }
  for (const auto& [thickness, sentence] : {std::pair{"nan", "'nan' is not a number; valid range 0.02 to 50 mm"},
                                            {"abc", "'abc' is not a number; valid range 0.02 to 50 mm"},
                                            {"0x1", "'0x1' is not a number; valid range 0.02 to 50 mm"},
                                            {"60", "60 is above 50; valid range 0.02 to 50 mm"}}) {
    const ProgramResult result = Kerf(cut + "0,0,-5,1,0,0 --thickness " + thickness);
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.err, HasSubstr(fmt::format("--thickness: {}; see 'kerf slab --help'\n", sentence)));
  }
  const ProgramResult far = Kerf(cut + "0,0,-5,1,0,0 --near 1e200,0,0");
  EXPECT_EQ(far.code, 2);
  EXPECT_THAT(far.err, HasSubstr("--near: '1e200,0,0' lies outside the world; coordinates go from -1000000 to 1000000 "
                                 "mm; see 'kerf slab --help'\n"));
  ExpectRefusal(Kerf(cut + "1e308,0,-5,1,0,0"),
                "the plane's point (1e+308, 0, -5) lies outside the world; coordinates go from -1000000 to 1000000 mm");
  EXPECT_FALSE(Exists("out"));
}

TEST_F(Slab, DeviationsOfVolumeAndThicknessAreReported) {
  ASSERT_EQ(Kerf("model plate --size 20,10,0.8 --layer 1:24 --voxel 0.4 -o plate.vdb").code, 0);
  const ProgramResult coarse =
      Kerf("slab plate.vdb --plane 0.1,0,-0.4,1,0,0 --thickness 1 --no-picture --formats vdb --json -o out");
  ASSERT_EQ(coarse.code, 0) << coarse.err;
  const Json json = Json::parse(coarse.out);
  ASSERT_LT(json["difference_percent"].get<double>(), -0.1);
  EXPECT_THAT(
      coarse.err,
      HasSubstr(fmt::format("kerf: the parts' volumes differ by {:+.2f} % from the bone's: voxels of 0.4 mm are coarse "
                            "for this bone and cut; make the bone again with smaller voxels\n",
                            json["difference_percent"].get<double>())));
  const ProgramResult few =
      Kerf("slab block.vdb --plane 0,0,-5,1,0,0 --triangles 4 --no-picture --formats obj --json -o out");
  ASSERT_EQ(few.code, 0);
  EXPECT_EQ(few.err, fmt::format("kerf: the slice's surface is {:.3f} mm thick instead of 0.25 mm; allow more "
                                 "--triangles\n",
                                 Json::parse(few.out)["measured_thickness_mm"].get<double>()));
}

TEST_F(Slab, PlaneThroughTheBoneInSeveralPlacesIsReported) {
  ASSERT_EQ(Kerf("model mandible --voxel 0.8 -o jaw.vdb").code, 0);
  const std::string cut = "slab jaw.vdb --plane 24,30,0,0,1,0 --formats vdb --no-picture --json -o out ";
  const ProgramResult one = Kerf(cut);
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(one.err,
            "kerf: the plane passes through the bone in 2 places; 1 of them is not cut (--near chooses another, "
            "--everywhere cuts all)\n");
  const ProgramResult other = Kerf(cut + "--near -24,30,0");
  EXPECT_GT(Json::parse(one.out)["parts"][1]["bounds_lower_mm"][0].get<double>(), 0);
  EXPECT_LT(Json::parse(other.out)["parts"][1]["bounds_upper_mm"][0].get<double>(), 0);
  const ProgramResult both = Kerf(cut + "--everywhere");
  EXPECT_EQ(both.err, "");
  EXPECT_EQ(Json::parse(both.out)["cut_places"], 2);
}

}  // namespace
}  // namespace kerf
