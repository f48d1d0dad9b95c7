#include "session/scene/plan_section.h"

#include <gmock/gmock.h>

#include <glm/geometric.hpp>

#include "scene_text.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::MessageFor;
using test::ShortScene;
using ::testing::HasSubstr;

TEST(PlanSection, IsRead) {
  const Scene scene = ParseScene(ShortScene() + R"(
[[plan.plane]]
point_mm = [1, 2, 3]
normal = [0, 3, 4]
[[plan.plane]]
name = "second"
point_mm = [1, 2, 4]
normal = [0, 0, -1]
margin_mm = 0.5
width_mm = 30
height_mm = 12.5
up = [0, 2, 0]
state = "in_progress"
[[plan.stop]]
point_mm = [0, 0, 1]
direction = [0, 0, -2]
depth_mm = 6
)",
                                 "s.toml");
  ASSERT_EQ(scene.plan.planes.size(), 2u);
  EXPECT_EQ(scene.plan.planes[0].name, "plane 1");
  EXPECT_NEAR(glm::length(scene.plan.planes[0].plane.normal_W - Vec3(0, 0.6, 0.8)), 0, 1e-15);
  EXPECT_EQ(scene.plan.planes[0].margin_mm, 1);
  EXPECT_EQ(scene.plan.planes[1].name, "second");
  EXPECT_EQ(scene.plan.planes[1].margin_mm, 0.5);
  EXPECT_EQ(scene.plan.planes[0].width_mm, 50);
  EXPECT_EQ(scene.plan.planes[0].state, PlaneState::kPlanned);
  EXPECT_EQ(scene.plan.planes[1].width_mm, 30);
  EXPECT_EQ(scene.plan.planes[1].height_mm, 12.5);
  EXPECT_EQ(scene.plan.planes[1].up_W, Vec3(0, 1, 0));
  EXPECT_EQ(scene.plan.planes[1].state, PlaneState::kInProgress);
  // The resolved scene has the same planes.
  const Scene again = ParseScene(ResolvedToml(scene), "s.toml");
  EXPECT_EQ(again.plan.planes[1].height_mm, 12.5);
  EXPECT_EQ(again.plan.planes[1].state, PlaneState::kInProgress);
  ASSERT_EQ(scene.plan.stops.size(), 1u);
  EXPECT_EQ(scene.plan.stops[0].direction_W, Vec3(0, 0, -1));
  EXPECT_EQ(scene.plan.stops[0].depth_mm, 6);
  CheckPlan(scene.plan);
  EXPECT_TRUE(ParseScene(ShortScene(), "s.toml").plan.empty());
}

TEST(PlanSection, TakesAPlaneFromSlicer) {
  const test::Folder folder;
  const CutPlane plane{{1, -2, 3}, glm::normalize(Vec3(1, 2, -3))};
  WritePlaneMarkups(folder.file("cut.mrk.json"), {{.name = "a", .plane = plane}});
  const std::string text = ShortScene() + "[[plan.plane]]\nname = \"cut\"\nfile = \"cut.mrk.json\"\n";
  const Scene scene = ParseScene(text, folder.file("s.toml"));
  ASSERT_EQ(scene.plan.planes.size(), 1u);
  EXPECT_NEAR(glm::length(scene.plan.planes[0].plane.normal_W - plane.normal_W), 0, 1e-12);
  EXPECT_NEAR(glm::length(scene.plan.planes[0].plane.p_W - plane.p_W), 0, 1e-12);
  // The resolved scene no longer needs the file.
  const std::string resolved = ResolvedToml(scene);
  std::filesystem::remove(folder.file("cut.mrk.json"));
  EXPECT_EQ(ResolvedToml(ParseScene(resolved, "/s.toml")), resolved);
  EXPECT_THAT(MessageFor(text, folder.file("s.toml")), HasSubstr("s.toml:10:"));
}

TEST(PlanSection, FaultsAreReportedWithTheirPosition) {
  const auto message = [](const std::string& text) { return MessageFor(ShortScene() + text); };
  EXPECT_THAT(message("[plan]\nplanes = 3\n"), HasSubstr("s.toml:9:1: unknown key \"planes\" in [plan]"));
  EXPECT_THAT(message("[[plan.plane]]\npoint_mm = [0, 0, 0]\n"), HasSubstr("normal"));
  EXPECT_THAT(message("[[plan.plane]]\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 0]\n"), HasSubstr("no direction"));
  EXPECT_THAT(message("[[plan.plane]]\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\nmargin_mm = 0\n"),
              HasSubstr("s.toml:11:1: margin_mm = 0 is below 0.01"));
  const std::string plane = "[[plan.plane]]\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  EXPECT_THAT(message(plane + "width_mm = 0\n"), HasSubstr("width_mm = 0 is below 1"));
  EXPECT_THAT(message(plane + "up = [0, 0, 0]\n"), HasSubstr("up has no direction"));
  EXPECT_THAT(message(plane + "state = \"cut\"\n"), HasSubstr("in_progress"));
  EXPECT_THAT(message("[[plan.plane]]\npoint_mm = [0, 0, 0]\nfile = \"a\"\n"), HasSubstr("keep one"));
  const std::string stop = "[[plan.stop]]\nname = \"a\"\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 1]\ndepth_mm = 4\n";
  EXPECT_EQ(message(stop), "");
  EXPECT_THAT(message(stop + stop), HasSubstr("the name \"a\" is already taken"));
  EXPECT_THAT(message("[[plan.stop]]\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 1]\n"), HasSubstr("depth_mm"));
}

}  // namespace
}  // namespace kerf
