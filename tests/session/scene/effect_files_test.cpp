// Tests of structures from files. They are read with the scene, and faults are reported at the key that names the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bone/mesh/meshfile.h"
#include "scene_text.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::WriteBytes;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TriangleMesh Tetrahedron() {
  return {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

constexpr const char* kCurve =
    R"({"markups": [{"type": "Curve", "coordinateSystem": "RAS", "controlPoints": [{"position": [1, 2, 3]},
{"position": [4, 5, 6]}]}]})";

std::string WithStructures(const std::string& keys) {
  return test::ShortScene() + "[effects.structures]\n" + keys;
}

TEST(EffectFiles, AreReadRelativeToTheScene) {
  const Folder folder;
  WriteMesh(Tetrahedron(), folder.file("canal.stl"));
  WriteBytes(folder.file("canal.mrk.json"), kCurve);
  const Scene scene = ParseScene(
      WithStructures("tissues = \"none\"\nsurface = \"canal.stl\"\nmarkups = \"canal.mrk.json\"\nradius_mm = 1.5\n"),
      folder.file("s.toml"));
  const EffectChoice& choice = scene.effects.at(0);
  const auto file = [&](const char* key) { return choice.files().at(choice.info().FindParameter(key)); };
  ASSERT_NE(file("surface"), nullptr);
  EXPECT_EQ(file("surface")->mesh.triangles.size(), 4u);
  EXPECT_EQ(file("surface")->name, folder.file("canal.stl"));
  ASSERT_NE(file("markups"), nullptr);
  ASSERT_EQ(file("markups")->curves.size(), 1u);
  EXPECT_TRUE(file("markups")->curves[0].joined);
  EXPECT_EQ(file("markups")->curves[0].points[1], Vec3(-4, -5, 6));
  EXPECT_EQ(file("warn_mm"), nullptr);
  // The resolved scene names the same files.
  const Scene again = ParseScene(ResolvedToml(scene), folder.file("elsewhere.toml"));
  EXPECT_EQ(again.effects.at(0).values(), choice.values());
}

TEST(EffectFiles, SurfaceIsTurnedToTheFrameOfTheScene) {
  // Like the markups of 3D Slicer, its surfaces may be in RAS.
  const Folder folder;
  WriteMesh(Tetrahedron(), folder.file("canal.stl"));
  std::string header = "3D Slicer output. SPACE=RAS";
  header.resize(80);
  WriteBytes(folder.file("canal.stl"), header + test::ReadBytes(folder.file("canal.stl")).substr(80));
  const Scene scene =
      ParseScene(WithStructures("tissues = \"none\"\nsurface = \"canal.stl\"\n"), folder.file("s.toml"));
  const EffectChoice& choice = scene.effects.at(0);
  EXPECT_THAT(choice.files().at(choice.info().FindParameter("surface"))->mesh.points,
              testing::UnorderedElementsAre(Vec3(0), Vec3(-4, 0, 0), Vec3(0, -4, 0), Vec3(0, 0, 4)));
}

TEST(EffectFiles, InvalidFilesAreRefusedAtTheirKey) {
  const Folder folder;
  const auto message = [&](const std::string& keys) {
    return MessageOf([&] { ParseScene(WithStructures(keys), folder.file("s.toml")); });
  };
  const std::string place = folder.file("s.toml") + ":9:1: ";
  TriangleMesh open = Tetrahedron();
  open.triangles.pop_back();
  WriteMesh(open, folder.file("open.stl"));
  EXPECT_THAT(message("surface = \"open.stl\"\n"),
              AllOf(StartsWith(place), HasSubstr("the surface is not closed (3 open edges)")));
  WriteBytes(folder.file("empty.stl"), "");
  EXPECT_THAT(message("surface = \"empty.stl\"\n"), StartsWith(place));
  EXPECT_THAT(message("surface = \"none.stl\"\n"), StartsWith(place));
  const std::string curve = kCurve;
  WriteBytes(folder.file("cut.json"), curve.substr(0, curve.size() / 2));
  EXPECT_THAT(message("markups = \"cut.json\"\nradius_mm = 1\n"),
              AllOf(StartsWith(place), HasSubstr("not valid JSON")));
  WriteBytes(folder.file("whole.json"), curve);
  EXPECT_EQ(message("markups = \"whole.json\"\nradius_mm = 1\n"), "");
  EXPECT_THAT(message("markups = \"whole.json\"\n"), HasSubstr(":8:10: [effects.structures]: markups needs radius_mm"));
  EXPECT_THAT(message("radius_mm = 1\n"), HasSubstr(":8:10: [effects.structures]: radius_mm is not used"));
  EXPECT_THAT(message("tissues = \"none\"\n"), HasSubstr("neither surface nor markups is set"));
}

}  // namespace
}  // namespace kerf
