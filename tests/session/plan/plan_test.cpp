#include "session/plan/plan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "base/files/files.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::HasSubstr;

constexpr double kDegrees = kDegreesPerRad;

struct Draw {
  explicit Draw(unsigned seed) : random(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 Direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(Vec3(normal(random), normal(random), normal(random)));
  }
  Vec3 Point() { return {In(-50, 50), In(-50, 50), In(-50, 50)}; }
  Pose AnyPose() { return {glm::angleAxis(In(0, 3.1), Direction()), Point()}; }
  std::mt19937 random;
};

/// The disc lies in its plane z = 0 with the spindle along z. The plan is the same plane, with its point below the
/// disc.
TEST(PlaneDeviation, MeasuresTranslationAndRotationOfTheBlade) {
  Draw draw(1);
  const Tool tool = DiscSaw{.diameter_mm = 20};
  for (int i = 0; i < 200; ++i) {
    // In the plan's frame P, the normal is z and the depth is -y, so normal x depth = x.
    const Pose X_WP = draw.AnyPose();
    const PlannedPlane plane{.name = "p", .plane = {X_WP.p_AB, X_WP.Vector({0, 0, 1})}, .margin_mm = 1};
    const double offset = draw.In(-2, 2);
    const double roll = draw.In(-30, 30);
    const double turn = draw.In(-3, 3);  // about the spindle: no effect
    // The blade is tilted about x by the roll, with the rim's lowest point fixed above the plan's point.
    const Quat lean = glm::angleAxis(-roll / kDegrees, Vec3(1, 0, 0)) * glm::angleAxis(turn, Vec3(0, 0, 1));
    const Vec3 rim_T = glm::angleAxis(-roll / kDegrees, Vec3(1, 0, 0)) * Vec3(0, -10, 0);
    const Vec3 rim_P(0, 3, offset);
    Pose X_PT{lean, rim_P - rim_T};
    Pose X_WT{X_WP.R_AB * X_PT.R_AB, X_WP.Point(X_PT.p_AB)};
    const PlaneDeviation out = CalcDeviation(plane, tool, X_WT);
    EXPECT_NEAR(*out.angle_deg, std::abs(roll), 1e-9);
    EXPECT_NEAR(*out.pitch_deg, 0, 1e-9);
    // The offset is that of the nearest point, and it grows with depth if the roll is positive.
    EXPECT_NEAR(out.offset_mm, X_WP.InversePoint(out.p_W_mm).z, 1e-9);
    const Vec3 centre_P = X_PT.p_AB;
    const Vec3 nearest_P = X_WP.InversePoint(out.p_W_mm);
    const double growth = (nearest_P.z - centre_P.z) / (centre_P.y - nearest_P.y);
    EXPECT_NEAR(std::tan(*out.roll_deg / kDegrees), growth, 1e-9);
    EXPECT_NEAR(std::abs(*out.roll_deg), std::abs(roll), 1e-9);
  }
}

TEST(PlaneDeviation, NearestPointIsTheNearestOfTheWholeDisc) {
  Draw draw(2);
  const Tool tool = DiscSaw{.diameter_mm = 22};
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane{.name = "p", .plane = {draw.Point(), draw.Direction()}, .margin_mm = 1};
    const Pose X_WT = draw.AnyPose();
    const PlaneDeviation out = CalcDeviation(plane, tool, X_WT);
    const double least = glm::length(out.p_W_mm - plane.plane.p_W);
    EXPECT_LE(glm::length(out.p_W_mm - X_WT.p_AB), 11 + 1e-9);
    EXPECT_NEAR(glm::dot(out.p_W_mm - X_WT.p_AB, X_WT.Vector({0, 0, 1})), 0, 1e-9);
    for (int k = 0; k < 200; ++k) {
      const double r = 11 * std::sqrt(draw.In(0, 1));
      const double a = draw.In(0, 6.3);
      const Vec3 p = X_WT.Point({r * std::cos(a), r * std::sin(a), 0});
      EXPECT_GE(glm::length(p - plane.plane.p_W), least - 1e-9);
    }
    const double t = std::tan(*out.angle_deg / kDegrees);
    const double a = std::tan(*out.pitch_deg / kDegrees);
    const double b = std::tan(*out.roll_deg / kDegrees);
    EXPECT_NEAR(t * t, a * a + b * b, 1e-6 * (1 + t * t));
    EXPECT_GE(*out.angle_deg, 0);
    EXPECT_LE(*out.angle_deg, 90);
  }
}

TEST(PlaneDeviation, NearestPointOfABladeWithAStrokeIsOnTheBlade) {
  Draw draw(6);
  const PiezoInsert insert;
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane{.name = "p", .plane = {draw.Point(), draw.Direction()}, .margin_mm = 1};
    const Pose X_WT = draw.AnyPose();
    const Vec3 p_T = X_WT.InversePoint(CalcDeviation(plane, insert, X_WT).p_W_mm);
    EXPECT_NEAR(p_T.z, 0, 1e-9);
    EXPECT_LT(CalcSignedToolDistance(insert, p_T), 1e-9);
    const double least_mm = glm::distance(X_WT.Point(p_T), plane.plane.p_W);
    for (int k = 0; k < 200; ++k) {
      const double x = draw.In(-insert.length_mm, 0);
      const double half_mm = 0.5 * insert.width_mm * (1 + (1 - insert.taper) * x / insert.length_mm);
      const Vec3 p_W = X_WT.Point({x, draw.In(-half_mm, half_mm), 0});
      EXPECT_GE(glm::distance(p_W, plane.plane.p_W), least_mm - 1e-9);
    }
  }
}

TEST(PlaneDeviation, IsIndependentOfTheSpindlesSign) {
  Draw draw(3);
  const Tool tool = DiscSaw{};
  for (int i = 0; i < 50; ++i) {
    const PlannedPlane plane{.name = "p", .plane = {draw.Point(), draw.Direction()}, .margin_mm = 1};
    const Pose X = draw.AnyPose();
    const Pose turned{X.R_AB * glm::angleAxis(std::numbers::pi, Vec3(1, 0, 0)), X.p_AB};
    const PlaneDeviation a = CalcDeviation(plane, tool, X);
    const PlaneDeviation b = CalcDeviation(plane, tool, turned);
    EXPECT_NEAR(a.offset_mm, b.offset_mm, 1e-9);
    EXPECT_NEAR(*a.angle_deg, *b.angle_deg, 1e-6);
    EXPECT_NEAR(*a.pitch_deg, *b.pitch_deg, 1e-6);
    EXPECT_NEAR(*a.roll_deg, *b.roll_deg, 1e-6);
  }
}

TEST(PlaneDeviation, OfABallIsMeasuredAtItsCentre) {
  const PlannedPlane plane{.name = "p", .plane = {{0, 0, 1}, {0, 0, 1}}, .margin_mm = 0.5};
  const PlaneDeviation out = CalcDeviation(plane, BallBurr{}, Pose{{1, 0, 0, 0}, {5, 5, 1.4}});
  EXPECT_NEAR(out.offset_mm, 0.4, 1e-12);
  EXPECT_TRUE(out.within_margin);
  EXPECT_FALSE(out.angle_deg);
}

TEST(PlaneDeviation, IsFiniteForABladePerpendicularToThePlan) {
  const PlannedPlane plane{.name = "p", .plane = {{0, 0, 0}, {1, 0, 0}}, .margin_mm = 1};
  for (const Vec3& p : {Vec3(0), Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 5)}) {
    const PlaneDeviation out = CalcDeviation(plane, DiscSaw{}, Pose{{1, 0, 0, 0}, p});
    EXPECT_NEAR(*out.angle_deg, 90, 1e-9);
    EXPECT_TRUE(std::isfinite(*out.pitch_deg) && std::isfinite(*out.roll_deg));
  }
}

TEST(StopDeviation, IsTheSupportOfTheTool) {
  Draw draw(4);
  for (int i = 0; i < 50; ++i) {
    const DepthStop stop{.name = "s", .p_W_mm = draw.Point(), .direction_W = draw.Direction(), .depth_mm = 7};
    const Pose X = draw.AnyPose();
    const StopDeviation out = CalcDeviation(stop, DiscSaw{.diameter_mm = 22}, X);
    double deepest = -1e9;
    for (int k = 0; k < 3600; ++k) {
      const double a = k * 6.283185307179586 / 3600;
      deepest =
          std::max(deepest, glm::dot(stop.direction_W, X.Point({11 * std::cos(a), 11 * std::sin(a), 0}) - stop.p_W_mm));
    }
    // A rim of 3600 points misses at most R (1 - cos(pi / 3600)) of the depth.
    EXPECT_NEAR(out.depth_mm, deepest, 1e-5);
    EXPECT_NEAR(out.left_mm, 7 - out.depth_mm, 1e-12);
    EXPECT_NEAR(CalcDeviation(stop, BallBurr{.diameter_mm = 6}, X).depth_mm,
                glm::dot(stop.direction_W, X.p_AB - stop.p_W_mm) + 3, 1e-12);
  }
}

TEST(StopDeviation, OfABurIsThatOfItsDeepestEdge) {
  Draw draw(6);
  const FissureBur bur{.diameter_mm = 2.4, .length_mm = 6, .taper = 0.7, .point_angle_deg = 140};
  const RoundSolid solid = *CalcRoundSolid(bur);
  for (int i = 0; i < 50; ++i) {
    const DepthStop stop{.name = "s", .p_W_mm = draw.Point(), .direction_W = draw.Direction(), .depth_mm = 7};
    const Pose X = draw.AnyPose();
    const double cosine = glm::dot(stop.direction_W, X.Vector({0, 0, 1}));
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    // The tip, the edge of its cone, and the edge of the top.
    const double deepest = std::max({0.0, solid.corner_z_mm * cosine + solid.corner_radius_mm * sine,
                                     solid.top_z_mm * cosine + solid.top_radius_mm * sine});
    const StopDeviation out = CalcDeviation(stop, bur, X);
    EXPECT_NEAR(out.depth_mm, glm::dot(stop.direction_W, X.p_AB - stop.p_W_mm) + deepest, 1e-9);
    EXPECT_NEAR(out.left_mm, 7 - out.depth_mm, 1e-12);
  }
}

TEST(PlaneDeviation, OfATiltedBurIsMeasuredAtItsTip) {
  const PlannedPlane plane{.name = "p", .plane = {{0, 0, 1}, {0, 0, 1}}, .margin_mm = 0.5};
  const PlaneDeviation out = CalcDeviation(plane, FissureBur{}, Pose{glm::angleAxis(0.7, Vec3(1, 0, 0)), {5, 5, 1.4}});
  EXPECT_NEAR(out.offset_mm, 0.4, 1e-12);
  EXPECT_TRUE(out.within_margin);
  EXPECT_FALSE(out.angle_deg);
}

TEST(PlacePlane, GoesThroughItsThreePoints) {
  Draw draw(5);
  for (int i = 0; i < 50; ++i) {
    const Vec3 a = draw.Point();
    const Vec3 b = draw.Point();
    const Vec3 c = draw.Point();
    const CutPlane plane = PlacePlane("p", a, b, c).plane;
    for (const Vec3& p : {a, b, c}) EXPECT_NEAR(glm::dot(plane.normal_W, p - plane.p_W), 0, 1e-9);
    EXPECT_GT(glm::dot(plane.normal_W, glm::cross(b - a, c - a)), 0);
  }
  EXPECT_THAT(MessageOf([] { PlacePlane("p", {0, 0, 0}, {1, 1, 1}, {2, 2, 2}); }), HasSubstr("on a line"));
  EXPECT_THAT(MessageOf([] { PlacePlane("p", {1, 0, 0}, {1, 0, 0}, {1, 0, 0}); }), HasSubstr("on a line"));
}

TEST(PlacePlane, FromAPoseHasNoDeviationThere) {
  Draw draw(6);
  const Pose X = draw.AnyPose();
  const PlaneDeviation out = CalcDeviation(PlacePlane("p", X), DiscSaw{}, X);
  EXPECT_NEAR(out.offset_mm, 0, 1e-12);
  EXPECT_NEAR(*out.angle_deg, 0, 1e-6);
}

TEST(Plan, IsWrittenForSlicerAndReadBack) {
  Draw draw(7);
  const test::Folder folder;
  Plan plan;
  for (int i = 0; i < 5; ++i) {
    plan.planes.push_back({.name = MakePlaneName(plan), .plane = {draw.Point(), draw.Direction()}, .margin_mm = 1});
  }
  plan.planes[1].plane.normal_W = {0, 0, -1};
  plan.planes[2].plane.normal_W = {1, 0, 0};
  plan.planes[3].name = "left \"body\" <ä>";
  WritePlaneMarkups(folder.file("plan.mrk.json"), MakeMarkups(plan));
  const std::vector<PlannedPlane> read = ReadPlannedPlanes(folder.file("plan.mrk.json"));
  ASSERT_EQ(read.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(read[i].name, plan.planes[i].name);
    EXPECT_NEAR(glm::length(read[i].plane.p_W - plan.planes[i].plane.p_W), 0, 1e-12);
    EXPECT_NEAR(glm::length(read[i].plane.normal_W - plan.planes[i].plane.normal_W), 0, 1e-12);
    // A file with a single plane is read through the scene's `file` key.
    const std::string one = folder.file("one.mrk.json");
    WritePlaneMarkups(one, {MakeMarkups(plan)[i]});
    EXPECT_NEAR(glm::length(ReadPlaneMarkups(one).normal_W - plan.planes[i].plane.normal_W), 0, 1e-12);
  }
}

/// Text of a plane as 3D Slicer itself saves it: without a name.
std::string MakePlaneFile(const char* coordinates, const std::string& centre, const char* more = "") {
  return fmt::format(
      R"({{"markups": [{{"type": "Plane", "coordinateSystem": "{}", "center": [{}], "normal": [0, 1, 0]{}}}]}})",
      coordinates, centre, more);
}

TEST(Plan, IsReadFromAFolderOrASceneOfSlicerWithTheNamesOfItsFiles) {
  const test::Folder folder;
  const auto write = [&folder](const std::string& name, const std::string& text) {
    WriteTextFile(folder.file(name), text);
  };
  std::filesystem::create_directories(folder.file("Data"));
  write("Data/mandible plane 2.mrk.json", MakePlaneFile("RAS", "4, 5, 6"));
  write("Data/mandible plane 1.mrk.json", MakePlaneFile("LPS", "1, 2, 3"));
  write("Data/named.mrk.json", MakePlaneFile("LPS", "7, 8, 9", R"(, "name": "mandible plane 1")"));
  write("Data/FibulaPlane0_A.mrk.json", MakePlaneFile("LPS", "0, 0, -900"));
  write("Data/points.mrk.json",
        R"({"markups": [{"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": []}]})");
  write("Data/other.json", "no markups");
  const std::vector<PlannedPlane> planes = ReadPlannedPlanes(folder.file("Data"));
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_EQ(planes[0].name, "mandible plane 1");
  EXPECT_EQ(planes[0].plane.p_W, Vec3(1, 2, 3));
  EXPECT_EQ(planes[0].plane.normal_W, Vec3(0, 1, 0));
  EXPECT_EQ(planes[1].name, "mandible plane 2");
  EXPECT_EQ(planes[1].plane.p_W, Vec3(-4, -5, 6));
  EXPECT_EQ(planes[1].plane.normal_W, Vec3(0, -1, 0));
  EXPECT_EQ(planes[2].name, "mandible plane 1 2");

  write("case.mrml", R"(<MRML version="Slicer5">
    <MarkupsPlaneStorage id="a" fileName="Data/mandible%20plane%202.mrk.json" useCompression="1"></MarkupsPlaneStorage>
    <MarkupsPlaneStorage id="b" fileName="Data/FibulaPlane0_A.mrk.json"></MarkupsPlaneStorage>
    <ModelStorage id="c" fileName="Data/mandible.vtk"></ModelStorage></MRML>)");
  const std::vector<PlannedPlane> of_scene = ReadPlannedPlanes(folder.file("case.mrml"));
  ASSERT_EQ(of_scene.size(), 1u);
  EXPECT_EQ(of_scene[0].name, "mandible plane 2");
  // References of XML in the name are replaced once, and then the escapes of a URL.
  write("Data/\u00f6 & &amp; 5%.mrk.json", MakePlaneFile("LPS", "1, 2, 3"));
  write("odd.mrml", R"(<MRML><MarkupsPlaneStorage
    fileName="D&#97;ta/&#xF6;%20&amp;%20&amp;amp;%205&#37;25.mrk.json"/></MRML>)");
  EXPECT_EQ(ReadPlannedPlanes(folder.file("odd.mrml"))[0].name, "\u00f6 & &amp; 5%");
  for (const char* odd : {"&#0;", "&#xD800;", "&#x110000;", "&#;", "&#x;", "&#1x;", "&none;", "&"}) {  // stay
    const std::string name = fmt::format("a{}b.mrk.json", odd);
    write(name, MakePlaneFile("LPS", "1, 2, 3"));
    write("odd.mrml", fmt::format(R"(<MRML><MarkupsPlaneStorage fileName="{}"/></MRML>)", name));
    EXPECT_EQ(ReadPlannedPlanes(folder.file("odd.mrml"))[0].name, fmt::format("a{}b", odd));
  }
  write("not UTF-8 \xff.mrk.json", MakePlaneFile("LPS", "1, 2, 3"));
  EXPECT_EQ(ReadPlannedPlanes(folder.file("not UTF-8 \xff.mrk.json"))[0].name, "not UTF-8 ?");
  // A file that is named itself is read whatever it is called.
  EXPECT_EQ(ReadPlannedPlanes(folder.file("Data/FibulaPlane0_A.mrk.json"))[0].name, "FibulaPlane0_A");

  std::filesystem::create_directories(folder.file("empty"));
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("empty")); }), HasSubstr("contains no plane"));
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("Data/points.mrk.json")); }),
              HasSubstr("a plane needs three"));
  write("no.mrml", "text");
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("no.mrml")); }), HasSubstr("not a scene"));
  write("cut.mrml", R"(<MRML><MarkupsPlaneStorage fileName="Data/mandible%20plane%202.mrk.json"/>)");
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("cut.mrml")); }), HasSubstr("is cut off"));
  write("view.mrml", R"(<MRML><A fileName="Data/mandible%20plane%202.mrk.json"/>
    <SceneView><A fileName="Data/mandible%20plane%202.mrk.json"/></SceneView></MRML>)");
  EXPECT_EQ(ReadPlannedPlanes(folder.file("view.mrml")).size(), 1u);
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("case.mrb")); }), HasSubstr("is a bundle of 3D Slicer"));
  write("lost.mrml", R"(<MRML><MarkupsPlaneStorage fileName="Data/lost.mrk.json"/></MRML>)");
  EXPECT_THAT(MessageOf([&] { ReadPlannedPlanes(folder.file("lost.mrml")); }), HasSubstr("lost.mrk.json"));
}

TEST(Plan, UnnamedPlanesAreNumbered) {
  const std::string text = R"({"markups": [
    {"type": "Plane", "coordinateSystem": "RAS", "center": [1, 2, 3], "normal": [0, 0, 1]},
    {"type": "Plane", "coordinateSystem": "LPS", "center": [1, 2, 3], "normal": [0, 0, 1], "name": "cut"},
    {"type": "Plane", "coordinateSystem": "LPS", "center": [1, 2, 3], "normal": [0, 0, 1], "name": "cut"}]})";
  const auto planes = ParsePlaneMarkupList(text, "a.json");
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_EQ(planes[0].name, "plane 1");
  EXPECT_EQ(planes[0].plane.p_W, Vec3(-1, -2, 3));
  EXPECT_EQ(planes[1].name, "cut");
  EXPECT_EQ(planes[2].name, "cut 2");
}

TEST(Plan, FaultsAreReported) {
  Plan plan;
  plan.planes.push_back({.name = "a", .plane = {}, .margin_mm = 1});
  plan.stops.push_back({.name = "a", .p_W_mm = {}, .direction_W = {0, 0, 1}, .depth_mm = 5});
  CheckPlan(plan);
  const auto with = [&](const std::function<void(Plan&)>& change) {
    Plan changed = plan;
    change(changed);
    return MessageOf([&] { CheckPlan(changed); });
  };
  EXPECT_THAT(with([](Plan& p) { p.planes.push_back(p.planes[0]); }), HasSubstr("two planes"));
  EXPECT_THAT(with([](Plan& p) { p.stops[0].name = ""; }), HasSubstr("no name"));
  EXPECT_THAT(with([](Plan& p) { p.planes[0].plane.normal_W = {0, 0, 2}; }), HasSubstr("length 1"));
  EXPECT_THAT(with([](Plan& p) { p.planes[0].margin_mm = std::nan(""); }), HasSubstr("margin"));
  EXPECT_THAT(with([](Plan& p) { p.stops[0].depth_mm = -1; }), HasSubstr("depth"));
  EXPECT_THAT(with([](Plan& p) { p.stops[0].p_W_mm.x = 1e9; }), HasSubstr("valid range"));
}

TEST(Guide, CombinesPlaneAndStop) {
  Draw draw(8);
  for (int i = 0; i < 50; ++i) {
    const PlannedPlane plane{.name = "p", .plane = {draw.Point(), draw.Direction()}, .margin_mm = 0.7};
    const Vec3 in_plane = glm::normalize(glm::cross(plane.plane.normal_W, draw.Direction()));
    const DepthStop stop{.name = "s", .p_W_mm = draw.Point(), .direction_W = in_plane, .depth_mm = 6};
    EffectChoice guide = MakeGuide(&plane, &stop);
    CheckEffects({guide});
    EXPECT_EQ(guide.info().find_fault(guide.values()), "");
    EXPECT_EQ(guide.GetNumber("tolerance_mm"), kGuidePlay_mm) << "the margin of 0.7 mm is not a play of the saw";
    const auto vector = [&](const char* key) {
      return std::get<Vec3>(guide.values()[guide.info().FindParameter(key)]);
    };
    // The plane's point lies in the plane, at the depth of the stop's point.
    EXPECT_NEAR(glm::dot(plane.plane.normal_W, vector("point_mm") - plane.plane.p_W), 0, 1e-9);
    EXPECT_NEAR(glm::dot(in_plane, vector("point_mm") - stop.p_W_mm), 0, 1e-9);
    EXPECT_EQ(guide.GetNumber("depth_mm"), 6);
    for (const EffectChoice& one : {MakeGuide(&plane, nullptr), MakeGuide(nullptr, &stop)}) {
      CheckEffects({one});
      EXPECT_EQ(one.info().find_fault(one.values()), "");
    }
    // The guide belongs to its plane, whichever way that faces, and to no other one.
    PlannedPlane other = plane;
    EXPECT_TRUE(IsGuideOf(guide, plane) && IsGuideOf(MakeGuide(&plane, nullptr), plane));
    other.plane.normal_W = -plane.plane.normal_W;
    EXPECT_TRUE(IsGuideOf(guide, other));
    other.plane.p_W = plane.plane.p_W + 0.02 * plane.plane.normal_W;
    EXPECT_FALSE(IsGuideOf(guide, other));
    other.plane = {plane.plane.p_W, glm::normalize(plane.plane.normal_W + 0.002 * in_plane)};
    EXPECT_FALSE(IsGuideOf(MakeGuide(&plane, nullptr), other));
    PlannedPlane narrow = plane;
    narrow.margin_mm = 0.05;
    EXPECT_EQ(MakeGuide(&narrow, &stop).GetNumber("tolerance_mm"), 0.05);
    const DepthStop across{.name = "s", .p_W_mm = {}, .direction_W = plane.plane.normal_W, .depth_mm = 6};
    EXPECT_THAT(MessageOf([&] { MakeGuide(&plane, &across); }), HasSubstr("90 degrees out of plane 'p'"));
  }
}

}  // namespace
}  // namespace kerf
