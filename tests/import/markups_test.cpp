// Point lists of 3D Slicer.
#include "import/markups.h"

#include <gmock/gmock.h>

#include "ct_files.h"

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

TEST(Markups, WhatIsNoPointListIsRefused) {
  const Folder folder;
  const auto message = [&folder](const std::string& text) {
    WriteBytes(folder.file("a.json"), text);
    return MessageOf([&] { ReadMarkups(folder.file("a.json")); });
  };
  EXPECT_THAT(message("{"), HasSubstr("not valid JSON"));
  EXPECT_THAT(message("[1, 2]"), HasSubstr("not a markups file of 3D Slicer"));
  EXPECT_THAT(message(List("XYZ", "")), HasSubstr("coordinateSystem is 'XYZ'; it must be LPS or RAS"));
  EXPECT_THAT(message(List("LPS", "")), HasSubstr("holds no placed control point"));
  EXPECT_THAT(message(List("LPS", R"({"position": [1, 2]})")),
              HasSubstr("control point 1 has no position of three numbers"));
  EXPECT_THAT(message(List("LPS", R"({"position": [1, 2, "x"]})")), HasSubstr("has a coordinate that is no number"));
}

}  // namespace
}  // namespace kerf
