// Point lists of 3D Slicer.
#include "base/files/markups.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <glm/geometric.hpp>

#include "support/folder.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using test::WriteBytes;
using ::testing::HasSubstr;

std::string List(const std::string& system, const std::string& points) {
  return "{\"markups\": [{\"type\": \"Fiducial\", \"coordinateSystem\": \"" + system + "\", \"controlPoints\": [" +
         points + "]}]}";
}

TEST(Markups, RasPointsBecomeLps) {
  const Folder folder;
  const std::string points = R"({"position": [1.5, -2, 3]}, {"position": [4, 5, 6], "positionStatus": "defined"})";
  WriteBytes(folder.file("lps.json"), List("LPS", points));
  WriteBytes(folder.file("ras.json"), List("RAS", points));
  const auto lps = ReadMarkups(folder.file("lps.json"));
  const auto ras = ReadMarkups(folder.file("ras.json"));
  ASSERT_EQ(lps.size(), 2u);
  ASSERT_EQ(ras.size(), 2u);
  EXPECT_EQ(lps[0], Vec3(1.5, -2, 3));
  EXPECT_EQ(ras[0], Vec3(-1.5, 2, 3));
  EXPECT_EQ(ras[1], Vec3(-4, -5, 6));
}

TEST(Markups, PointsThatWereNotPlacedAreLeftOut) {
  const Folder folder;
  WriteBytes(folder.file("a.json"),
             List("LPS", R"({"position": [1, 2, 3]}, {"position": [0, 0, 0], "positionStatus": "undefined"})"));
  EXPECT_EQ(ReadMarkups(folder.file("a.json")).size(), 1u);
}

TEST(Markups, OtherFilesThanPointListsAreRefused) {
  const Folder folder;
  const auto message = [&folder](const std::string& text) {
    WriteBytes(folder.file("a.json"), text);
    return MessageOf([&] { ReadMarkups(folder.file("a.json")); });
  };
  EXPECT_THAT(message("{"), HasSubstr("not valid JSON"));
  EXPECT_THAT(message("[1, 2]"), HasSubstr("not a 3D Slicer markups file"));
  EXPECT_THAT(message(List("XYZ", "")), HasSubstr("coordinateSystem is 'XYZ'; it must be LPS or RAS"));
  EXPECT_THAT(message(List("LPS", "")), HasSubstr("contains no placed control point"));
  EXPECT_THAT(message(List("LPS", R"({"position": [1, 2]})")),
              HasSubstr("control point 1 has no position with three coordinates"));
  EXPECT_THAT(message(List("LPS", R"({"position": [1, 2, "x"]})")), HasSubstr("has a coordinate that is not a number"));
  EXPECT_THAT(message(List("LPS", R"({"position": [1,5, 2,5, 3,0]})")),
              HasSubstr("three coordinates; if they have decimal commas, write decimal points"));
  EXPECT_THAT(message(List("LPS", R"({"position": ["1,5", "2,5", "3"]})")),
              HasSubstr("is not a number; its numbers have a decimal comma instead of a point"));
}

TEST(Markups, CurvesAreJoinedAndPointsAreNot) {
  const Folder folder;
  const auto list = [](const std::string& type, const std::string& points) {
    return R"({"type": ")" + type + R"(", "coordinateSystem": "RAS", "controlPoints": [)" + points + "]}";
  };
  const std::string three = R"({"position": [1, 2, 3]}, {"position": [4, 5, 6]}, {"position": [7, 8, 9]})";
  const auto read = [&](const std::string& markups) {
    WriteBytes(folder.file("a.json"), R"({"markups": [)" + markups + "]}");
    return ReadCurveMarkups(folder.file("a.json"));
  };
  const auto all = read(list("Curve", three) + "," + list("ClosedCurve", three) + "," + list("Fiducial", three) + "," +
                        list("Line", ""));
  ASSERT_EQ(all.size(), 3u);  // the last list has no points
  EXPECT_TRUE(all[0].joined);
  EXPECT_EQ(all[0].points.size(), 3u);
  EXPECT_EQ(all[0].points[1], Vec3(-4, -5, 6));
  EXPECT_TRUE(all[1].joined);
  ASSERT_EQ(all[1].points.size(), 4u);
  EXPECT_EQ(all[1].points.front(), all[1].points.back());
  EXPECT_FALSE(all[2].joined);
  EXPECT_THAT(MessageOf([&] { read(list("Plane", three)); }), HasSubstr("a markup of type 'Plane'; it must be Curve"));
  EXPECT_THAT(MessageOf([&] { read(list("Line", "")); }), HasSubstr("contains no placed control point"));
}

/// The LPS plane through (10, -20, 30) with normal (2, 3, 6) / 7, written in the coordinate system that `sign` selects
/// (1: LPS, -1: RAS).
struct PlaneText {
  double sign;
  std::string system() const { return sign > 0 ? "LPS" : "RAS"; }
  std::string Vector(double x, double y, double z) const { return fmt::format("[{}, {}, {}]", sign * x, sign * y, z); }
  std::string Centre() const { return "\"center\": " + Vector(10, -20, 30); }
  std::string Normal() const { return "\"normal\": " + Vector(2.0 / 7, 3.0 / 7, 6.0 / 7); }
  /// Rows x and y change sign with the system; the columns are (3, -6, 2) / 7, (6, 2, -3) / 7 and the normal.
  std::string Base() const {
    const double s = sign / 7;
    return fmt::format("\"baseToNode\": [{}, {}, {}, 0, {}, {}, {}, 0, {}, {}, {}, 0, 0, 0, 0, 1]", 3 * s, 6 * s, 2 * s,
                       -6 * s, 2 * s, 3 * s, 2.0 / 7, -3.0 / 7, 6.0 / 7);
  }
  /// The identity as Slicer writes it: in LPS, the first two rows are negated.
  std::string Object() const {
    return fmt::format("\"objectToBase\": [{0}, 0, 0, 0, 0, {0}, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]", -sign);
  }
  std::string Points(const std::string& list) const { return "\"controlPoints\": [" + list + "]"; }
  std::string Point(double x, double y, double z) const { return "{\"position\": " + Vector(x, y, z) + "}"; }
  std::string File(const std::string& entries, const std::string& type = "Plane") const {
    return "{\"markups\": [{\"type\": \"" + type + "\", \"coordinateSystem\": \"" + system() + "\", " + entries + "}]}";
  }
};

CutPlane ReadPlaneText(const std::string& text) {
  const Folder folder;
  WriteBytes(folder.file("a.json"), text);
  return ReadPlaneMarkups(folder.file("a.json"));
}

void ExpectPlane(const CutPlane& plane, double tolerance) {
  EXPECT_NEAR(glm::length(plane.normal_W - Vec3(2, 3, 6) / 7.0), 0, tolerance);
  EXPECT_NEAR(glm::dot(plane.p_W - Vec3(10, -20, 30), Vec3(2, 3, 6) / 7.0), 0, 100 * tolerance);
}

TEST(PlaneMarkups, SlicerPlaneIsTheSameInLpsAndRasAndFromAnyEntry) {
  for (const double sign : {1.0, -1.0}) {
    const PlaneText t{sign};
    const std::string point = t.Points(t.Point(10, -20, 30));
    for (const std::string& entries :
         {t.Centre() + ", " + t.Normal(), t.Base() + ", " + point, t.Base() + ", " + t.Object() + ", " + point,
          "\"planeType\": \"pointNormal\", " + t.Centre() + ", " + t.Normal() + ", " + t.Base() + ", " + t.Object() +
              ", " + point}) {
      const CutPlane plane = ReadPlaneText(t.File(entries));
      ExpectPlane(plane, 1e-12);
      EXPECT_EQ(plane.p_W, Vec3(10, -20, 30)) << entries;
    }
  }
}

TEST(PlaneMarkups, RotationWithinTheBaseRotatesThePlane) {
  for (const double sign : {1.0, -1.0}) {
    const PlaneText t{sign};
    // A quarter turn about the base's x axis, which maps z to -y. Its rows are (1, 0, 0), (0, 0, -1), (0, 1, 0).
    const std::string object =
        fmt::format("\"objectToBase\": [{0}, 0, 0, 0, 0, 0, {1}, 0, 0, 1, 0, 0, 0, 0, 0, 1]", -sign, sign);
    const CutPlane plane = ReadPlaneText(t.File(t.Base() + ", " + object + ", " + t.Points(t.Point(10, -20, 30))));
    EXPECT_NEAR(glm::length(plane.normal_W + Vec3(6, 2, -3) / 7.0), 0, 1e-12);
  }
}

TEST(PlaneMarkups, OrderOfThreePointsDefinesThePlaneAndItsSide) {
  for (const double sign : {1.0, -1.0}) {
    const PlaneText t{sign};
    // The points are p, p + 7 u and p + 14 v, where u and v are columns of the matrix above and u x v is the normal.
    const std::string a = t.Point(10, -20, 30);
    const std::string b = t.Point(13, -26, 32);
    const std::string c = t.Point(22, -16, 24);
    ExpectPlane(ReadPlaneText(t.File(t.Points(fmt::format("{},{},{}", a, b, c)), "Fiducial")), 1e-12);
    ExpectPlane(ReadPlaneText(t.File(t.Points(fmt::format("{},{},{}", a, b, c)))), 1e-12);  // as Slicer 4.11 writes it
    const CutPlane turned = ReadPlaneText(t.File(t.Points(fmt::format("{},{},{}", a, c, b)), "Fiducial"));
    ExpectPlane({turned.p_W, -turned.normal_W}, 1e-12);
    EXPECT_NEAR(glm::length(turned.p_W - Vec3(15, -62.0 / 3, 86.0 / 3)), 0, 1e-12);  // the mean of the points
  }
}

TEST(PlaneMarkups, ManyPointsAreFittedByLeastSquares) {
  const PlaneText t{1};
  // A rectangle of 7 x 14 mm whose corners are alternately 0.07 mm above and below the plane, which the fit must
  // find.
  std::string points;
  const Vec3 u(3, -6, 2), v(12, 4, -6), n(0.02, 0.03, 0.06);
  const Vec3 corners[] = {Vec3(0), u, u + v, v};
  for (int i = 0; i < 4; ++i) {
    const Vec3 p = Vec3(10, -20, 30) + corners[i] + (i % 2 ? 1.0 : -1.0) * n;
    points.append(i ? "," : "").append(t.Point(p.x, p.y, p.z));
  }
  ExpectPlane(ReadPlaneText(t.File(t.Points(points), "Fiducial")), 1e-9);
}

TEST(PlaneMarkups, FilesThatDefineNoPlaneAreRefused) {
  const PlaneText t{1};
  const auto message = [](const std::string& text) { return MessageOf([&] { ReadPlaneText(text); }); };
  const std::string two = t.Points(t.Point(0, 0, 0) + "," + t.Point(1, 0, 0));
  EXPECT_THAT(message(t.File(two, "Fiducial")), HasSubstr("contains 2 placed points; a plane needs three"));
  const std::string line = t.Points(t.Point(0, 0, 0) + "," + t.Point(1, 2, 3) + "," + t.Point(2, 4, 6));
  EXPECT_THAT(message(t.File(line, "Fiducial")), HasSubstr("its points lie on a line, so they do not define a plane"));
  EXPECT_THAT(message(t.File("\"normal\": [0, 0, 0], " + t.Centre())),
              HasSubstr("'normal' of the plane has no direction"));
  EXPECT_THAT(message(t.File("\"normal\": [0, 1], " + t.Centre())),
              HasSubstr("'normal' of the plane is not a list of 3 numbers"));
  EXPECT_THAT(message(t.File(t.Normal())), HasSubstr("the plane has neither a center nor a placed point"));
  EXPECT_THAT(message(t.File("\"normal\": [0, 0, 1], " + t.Centre() + ", " + t.Base())),
              HasSubstr("the plane's 'normal' and 'baseToNode' contradict each other; save it again from 3D Slicer"));
  EXPECT_THAT(message(t.File("\"planeType\": \"pointNormal\", " + t.Centre() + ", " + t.Normal() + ", " +
                             t.Points(t.Point(10, -20, 31)))),
              HasSubstr("'center' and its control point contradict each other"));
  const std::string plane = t.File(t.Centre() + ", " + t.Normal());
  const std::string one = plane.substr(13, plane.size() - 15);
  EXPECT_THAT(message("{\"markups\": [" + one + ", " + one + "]}"), HasSubstr("contains several planes"));
  EXPECT_THAT(message("[]"), HasSubstr("not a 3D Slicer markups file"));
}

}  // namespace
}  // namespace kerf
