#include "session/marks/mark.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "kerf/error.h"
#include "session/marks/mark_file.h"
#include "session/marks/segment.h"
#include "session/marks/undo_stack.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::HasSubstr;

Mark AnyMark(std::mt19937& random, std::size_t points) {
  std::uniform_real_distribution<double> in(-20, 20);
  Mark mark{.name = "m", .kind = MarkKind::kNerve, .radius_mm = 1.25, .points_W = {}};
  for (std::size_t i = 0; i < points; ++i) mark.points_W.emplace_back(in(random), in(random), in(random));
  return mark;
}

double DistanceToLine(const Vec3& p, const std::vector<Vec3>& line) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) best = std::min(best, CalcSegmentDistance(p, line[i], line[i + 1]));
  return best;
}

TEST(Curve, PassesThroughItsPointsAndReversesWithThem) {
  std::mt19937 random(1);
  for (int i = 0; i < 30; ++i) {
    const Mark mark = AnyMark(random, 2 + static_cast<std::size_t>(i % 7));
    std::vector<std::size_t> first;
    const std::vector<Vec3> line = CalcCurve(mark.points_W, &first);
    ASSERT_EQ(first.size() + 1, mark.points_W.size());
    for (std::size_t k = 0; k < first.size(); ++k) EXPECT_EQ(line[first[k]], mark.points_W[k]);
    EXPECT_EQ(line.back(), mark.points_W.back());
    const std::vector<Vec3> reversed = CalcCurve({mark.points_W.rbegin(), mark.points_W.rend()});
    // Both are polylines of the same curve.
    for (const Vec3& p : reversed) EXPECT_LT(DistanceToLine(p, line), kCurveError_mm);
  }
}

TEST(Curve, IsStraightForPointsOnALine) {
  std::vector<Vec3> points;
  for (const double t : {0.0, 1.0, 1.5, 6.0, 20.0}) points.push_back(Vec3(1, 2, 3) + t * Vec3(0.6, 0, 0.8));
  const std::vector<Vec3> line = CalcCurve(points);
  double last = -1;
  for (const Vec3& p : line) {
    const double along = glm::dot(p - points[0], Vec3(0.6, 0, 0.8));
    EXPECT_NEAR(glm::length(p - points[0] - along * Vec3(0.6, 0, 0.8)), 0, 1e-12);
    EXPECT_GT(along, last);  // without turning back, although the spacing is uneven
    last = along;
  }
}

TEST(Curve, IsNearACircleThroughPointsOnIt) {
  // For evenly spaced points, the centripetal spline is the cubic Hermite spline with tangents along the chords of the
  // neighbours. With 15 degrees between points its radius is off by less than a thousandth.
  std::vector<Vec3> points;
  for (int i = 0; i <= 12; ++i) {
    const double angle = i * std::numbers::pi / 12;
    points.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), 4);
  }
  std::vector<std::size_t> first;
  const std::vector<Vec3> line = CalcCurve(points, &first);
  for (std::size_t i = first[1]; i <= first[11]; ++i) {  // the ends have no neighbours on the circle
    EXPECT_NEAR(std::hypot(line[i].x, line[i].y), 10, 0.01 + kCurveError_mm);
  }
}

TEST(Curve, AcceptsFewAndRepeatedPoints) {
  EXPECT_TRUE(CalcCurve({}).empty());
  EXPECT_EQ(CalcCurve({{1, 2, 3}}), (std::vector<Vec3>{{1, 2, 3}}));
  EXPECT_EQ(CalcCurve({{1, 2, 3}, {1, 2, 3}}), (std::vector<Vec3>{{1, 2, 3}}));
  EXPECT_EQ(CalcCurve({{0, 0, 0}, {0, 0, 0}, {4, 0, 0}}), (std::vector<Vec3>{{0, 0, 0}, {4, 0, 0}}));
  std::vector<std::size_t> first;
  const std::vector<Vec3> line = CalcCurve({{0, 0, 0}, {5, 0, 0}, {5, 0, 0}, {5, 5, 0}}, &first);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(line[first[1]], Vec3(5, 0, 0));
  EXPECT_EQ(line[first[2]], Vec3(5, 0, 0));
  for (const Vec3& p : line) EXPECT_TRUE(IsInWorld(p));
}

TEST(MarkEdits, InsertBetweenTheNearestNeighbours) {
  Mark mark{.name = "m", .points_W = {{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 10, 0}}};
  EXPECT_EQ(InsertPoint(mark, {14, 1, 0}), 2u);
  EXPECT_EQ(mark.points_W[2], Vec3(14, 1, 0));
  EXPECT_EQ(InsertPoint(mark, {-5, 0, 0}), 1u);  // before the start: still between
  AddPoint(mark, {31, 11, 0});
  EXPECT_EQ(mark.points_W.back(), Vec3(31, 11, 0));
  MovePoint(mark, 0, {0, 0, 1});
  EXPECT_EQ(mark.points_W[0], Vec3(0, 0, 1));
  RemovePoint(mark, 1);
  EXPECT_EQ(mark.points_W[1], Vec3(10, 0, 0));
  EXPECT_THAT(MessageOf([&] { RemovePoint(mark, 99); }), HasSubstr("there is no point 100"));
  EXPECT_THAT(MessageOf([&] { AddPoint(mark, {0, 0, std::nan("")}); }), HasSubstr("not a valid place"));
  mark.points_W.assign(kMaxMarkPoints, {});
  EXPECT_THAT(MessageOf([&] { AddPoint(mark, {}); }), HasSubstr("1000 points already"));
  Mark empty{.name = "e"};
  EXPECT_EQ(InsertPoint(empty, {1, 1, 1}), 0u);
  EXPECT_EQ(InsertPoint(empty, {2, 1, 1}), 1u);
}

TEST(Marks, AreChecked) {
  CheckMarks({{.name = "a"}, {.name = "b"}});
  EXPECT_THAT(MessageOf([] { CheckMarks({{.name = "a"}, {.name = "a"}}); }), HasSubstr("two marks are named 'a'"));
  EXPECT_THAT(MessageOf([] { CheckMarks({{.name = ""}}); }), HasSubstr("no name"));
  EXPECT_THAT(MessageOf([] { CheckMarks({{.name = "a", .radius_mm = 0}}); }), HasSubstr("mark 'a': radius_mm = 0"));
  EXPECT_EQ(MakeMarkName({}, MarkKind::kNerve), "nerve");
  EXPECT_EQ(MakeMarkName({{.name = "nerve"}, {.name = "nerve 2"}}, MarkKind::kNerve), "nerve 3");
}

TEST(MarkFile, ReadsBackBitForBit) {
  std::mt19937 random(2);
  std::vector<Mark> marks;
  for (int i = 0; i < 5; ++i) {
    Mark mark = AnyMark(random, 1 + static_cast<std::size_t>(i));
    mark.name = fmt::format("mark \"{}\" ä", i);
    mark.kind = static_cast<MarkKind>(i);
    mark.radius_mm = 0.1 + i / 3.0;
    marks.push_back(mark);
  }
  const Folder folder;
  WriteMarks(folder.file("marks.mrk.json"), marks);
  EXPECT_EQ(ReadMarks(folder.file("marks.mrk.json")), marks);
  marks.push_back({.name = "without points"});
  EXPECT_EQ(ParseMarks(FormatMarks(marks), "m").size(), 5u);
}

TEST(MarkFile, ReadsCurvesOf3dSlicer) {
  const std::string text = R"({"markups": [
    {"type": "Curve", "coordinateSystem": "RAS", "name": "nerve left", "controlPoints": [
      {"position": [1, 2, 3]}, {"position": [4, 5, 6], "positionStatus": "undefined"}, {"position": [7, 8, 9]}]},
    {"type": "Line", "coordinateSystem": "LPS", "controlPoints": [{"position": [1, 2, 3]}]}]})";
  const std::vector<Mark> marks = ParseMarks(text, "slicer.mrk.json");
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks[0].kind, MarkKind::kNerve);
  EXPECT_EQ(marks[0].radius_mm, 1);
  EXPECT_EQ(marks[0].points_W, (std::vector<Vec3>{{-1, -2, 3}, {-7, -8, 9}}));
  EXPECT_EQ(marks[1].name, "curve 2");
  EXPECT_EQ(marks[1].kind, MarkKind::kOther);
}

TEST(MarkFile, RefusesFaultsWithOneSentence) {
  const auto message = [](const std::string& keys, const std::string& type = "Curve") {
    return MessageOf([&] {
      ParseMarks(R"({"markups": [{"type": ")" + type + R"(", "coordinateSystem": "LPS", )" + keys +
                     R"("controlPoints": [{"position": [1, 2, 3]}]}]})",
                 "m.mrk.json");
    });
  };
  EXPECT_EQ(message(""), "");
  EXPECT_THAT(message(R"("radius": "2",)"), HasSubstr("m.mrk.json: 'radius' of the curve 'curve 1' is not a positive"));
  EXPECT_THAT(message(R"("radius": -1,)"), HasSubstr("not a positive number"));
  EXPECT_THAT(message(R"("radius": 1e99,)"), HasSubstr("radius_mm = 1e+99 is above 50"));
  EXPECT_THAT(message(R"("kind": 3,)"), HasSubstr("is not a word"));
  EXPECT_THAT(message(R"("kind": "bone",)"), HasSubstr("it must be nerve, canal, tooth, root or other"));
  EXPECT_THAT(message("", "Plane"), HasSubstr("must be Curve, ClosedCurve or Line"));
  EXPECT_THAT(MessageOf([] { ParseMarks("{}", "m"); }), HasSubstr("not a 3D Slicer markups file"));
}

TEST(UndoStack, ReturnsEveryValue) {
  UndoStack<int> stack(0, 3);
  EXPECT_FALSE(stack.can_undo());
  EXPECT_FALSE(stack.Undo());
  for (int i = 1; i <= 5; ++i) stack.Push(i, std::to_string(i));
  EXPECT_EQ(stack.undo_name(), "5");
  // Three steps are kept.
  for (int i = 4; i >= 2; --i) {
    EXPECT_TRUE(stack.Undo());
    EXPECT_EQ(stack.now(), i);
  }
  EXPECT_FALSE(stack.Undo());
  EXPECT_EQ(stack.redo_name(), "3");
  EXPECT_TRUE(stack.Redo());
  EXPECT_EQ(stack.now(), 3);
  stack.Amend(30);
  EXPECT_FALSE(stack.can_redo());
  EXPECT_EQ(stack.now(), 30);
  stack.Push(7, "seven");
  EXPECT_TRUE(stack.Undo());
  EXPECT_EQ(stack.now(), 30);
}

TEST(Marks, AreAppendedWithNamesThatAreNotInUse) {
  const auto named = [](const std::string& name) { return Mark{.name = name, .points_W = {Vec3(0)}}; };
  std::vector<Mark> marks{named("nerve 1"), named("left")};
  AppendMarks(marks, {named("nerve 1"), named("nerve 2"), named("left"), named("48"), named("48")});
  std::vector<std::string> names;
  for (const Mark& mark : marks) names.push_back(mark.name);
  EXPECT_THAT(names, ::testing::ElementsAre("nerve 1", "left", "nerve 2", "nerve 3", "left 2", "48", "48 2"));
  CheckMarks(marks);
}

TEST(Marks, MustLieInTheSurroundingsOfTheBone) {
  const Box3 bone{Vec3(-10, -20, -30), Vec3(10, 20, 30)};
  const auto at = [](const Vec3& p_W) { return std::vector{Mark{.name = "m", .points_W = {Vec3(0), p_W}}}; };
  CheckMarksNear(at({59.9, 0, 0}), bone);
  CheckMarksNear(at({-40, -60, 30}), bone);  // 30 and 40 mm outside: 50 mm
  const std::string message = MessageOf([&] { CheckMarksNear(at({-40, -61, 30}), bone); });
  EXPECT_THAT(message, HasSubstr("the mark 'm' lies up to 51 mm outside of the bone"));
  EXPECT_THAT(message, HasSubstr("another coordinate frame"));
}

}  // namespace
}  // namespace kerf
