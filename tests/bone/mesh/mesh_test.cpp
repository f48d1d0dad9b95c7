#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "base/files/files.h"
#include "bone/mesh/decimate.h"
#include "bone/mesh/meshfile.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;
using ::testing::HasSubstr;

// Returns a closed sphere of triangles by longitude and latitude, facing outward.
TriangleMesh MakeSphere(double radius_mm, int rings, const Vec3& centre) {
  TriangleMesh mesh;
  const int sectors = 2 * rings;
  mesh.points.push_back(centre + Vec3{0, 0, radius_mm});
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double polar = std::numbers::pi * i / rings;
      const double azimuth = 2 * std::numbers::pi * j / sectors;
      mesh.points.push_back(centre + radius_mm * Vec3{std::sin(polar) * std::cos(azimuth),
                                                      std::sin(polar) * std::sin(azimuth), std::cos(polar)});
    }
  }
  mesh.points.push_back(centre - Vec3{0, 0, radius_mm});
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * sectors + j % sectors); };
  const auto last = static_cast<std::uint32_t>(mesh.points.size() - 1);
  for (int j = 0; j < sectors; ++j) {
    mesh.triangles.push_back({0, id(1, j), id(1, j + 1)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
    mesh.triangles.push_back({last, id(rings - 1, j + 1), id(rings - 1, j)});
  }
  return mesh;
}

TriangleMesh MakeTetrahedron() {
  return {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

class MeshFile : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  std::string ReadMessage(const std::string& name, const std::string& content) const {
    std::ofstream(Path(name), std::ios::binary) << content;
    std::string message = test::MessageOf([&] { ReadMesh(Path(name)); });
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  test::Folder own_;
  std::string folder_ = own_.path();
};

TEST_F(MeshFile, EveryFormatGivesBackTheSameClosedSurface) {
  // The sphere is far from the origin, so that coordinates need all digits of a float.
  const TriangleMesh sphere = MakeSphere(30, 40, {-123.456789, 456.789123, 78.9});
  ASSERT_EQ(CountOpenEdges(sphere), 0u);
  const double volume = CalcEnclosedVolume(sphere);
  ASSERT_NEAR(volume, 4.0 / 3 * std::numbers::pi * 27000, 0.01 * volume);  // 40 rings make an inscribed polyhedron
  for (const char* name : {"a.stl", "a.obj", "a.ply", "A.STL"}) {
    SCOPED_TRACE(name);
    WriteMesh(sphere, Path(name));
    const TriangleMesh back = ReadMesh(Path(name));
    ASSERT_EQ(back.triangles.size(), sphere.triangles.size());
    EXPECT_EQ(back.points.size(), sphere.points.size());
    EXPECT_EQ(CountOpenEdges(back), 0u);
    // Triangles keep their order and orientation, and points are rounded to float. At 457 mm, half a unit in the last
    // place is 1.5e-5 mm.
    for (std::size_t t = 0; t < back.triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 d = back.points[back.triangles[t][i]] - sphere.points[sphere.triangles[t][i]];
        ASSERT_LT(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), 3.1e-5) << t;
      }
    }
    EXPECT_NEAR(CalcEnclosedVolume(back), volume, 1e-6 * volume);
  }
}

TEST_F(MeshFile, TextStlIsReadAndAgreesWithTheBinaryOne) {
  const TriangleMesh tetrahedron = MakeTetrahedron();
  std::string text = "solid tetrahedron\n";
  for (const auto& t : tetrahedron.triangles) {
    text += " facet normal 0 0 1\n  outer loop\n";
    for (const auto id : t) {
      const Vec3& p = tetrahedron.points[id];
      text += "   vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    }
    text += "  endloop\n endfacet\n";
  }
  WriteTextFile(Path("t.stl"), text + "endsolid tetrahedron\n");
  const TriangleMesh mesh = ReadMesh(Path("t.stl"));
  EXPECT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(mesh), 8.0 / 6);
  EXPECT_THAT(ReadMessage("cut.stl", text), EndsWith("cut.stl: the text STL has no 'endsolid'; it is cut off"));
  text.erase(text.rfind("vertex"), 20);
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(ReadMessage("bad.stl", text + "endsolid tetrahedron\n"), HasSubstr("bad.stl: not a valid text STL"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");  // VTK prints no messages of its own
}

TEST_F(MeshFile, BinaryStlWhoseHeaderSaysSolidIsStillBinary) {
  WriteMesh(MakeTetrahedron(), Path("a.stl"));
  std::string bytes = ReadTextFile(Path("a.stl"));
  std::memcpy(bytes.data(), "solid facet", 11);
  WriteTextFile(Path("b.stl"), bytes);
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(ReadMesh(Path("b.stl"))), 8.0 / 6);
}

TEST_F(MeshFile, ObjPolygonsNegativeIndicesAndTexturesAreUnderstood) {
  // A cube with edge length 2 made of quads; the last face has negative indices, which count from the end.
  WriteTextFile(
      Path("cube.obj"),
      "# cube\r\nmtllib x.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n"
      "vt 0 0\nvn 0 0 1\nf 4/1/1 3/1/1 2/1/1 1/1/1\nf 5 6 7 8\r\nf 1//1 2//1 6//1 5//1\nf 2 3 7 6\nf 3 4 8 7\n"
      "f -5 -8 -4 -1\n");
  const TriangleMesh cube = ReadMesh(Path("cube.obj"));
  EXPECT_EQ(cube.triangles.size(), 12u);
  EXPECT_EQ(CountOpenEdges(cube), 0u);
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(cube), 8);
}

TEST_F(MeshFile, TextAndBigEndianPlyAreRead) {
  const std::string points =
      "element vertex 4\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n";
  const std::string faces = "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  WriteTextFile(Path("t.ply"), "ply\nformat ascii 1.0\ncomment x\n" + points + faces +
                                   "0 0 0 1\n2 0 0 1\n0 2 0 1\n0 0 2 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(ReadMesh(Path("t.ply"))), 8.0 / 6);

  std::string bytes = "ply\nformat binary_big_endian 1.0\n" + points + faces;
  const auto put = [&](auto value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    bytes.append(std::reverse_iterator(raw + sizeof(value)), std::reverse_iterator(raw));
  };
  const TriangleMesh tetrahedron = MakeTetrahedron();
  for (const Vec3& p : tetrahedron.points) put(p.x), put(p.y), put(p.z), put(std::uint8_t{200});
  for (const auto& t : tetrahedron.triangles) {
    put(std::uint8_t{3});
    for (const auto id : t) put(static_cast<std::int32_t>(id));
  }
  WriteTextFile(Path("b.ply"), bytes);
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(ReadMesh(Path("b.ply"))), 8.0 / 6);
}

TEST_F(MeshFile, TruncatedFilesAreRefusedAtEveryLength) {
  for (const char* name : {"a.stl", "a.ply"}) {
    WriteMesh(MakeTetrahedron(), Path(name));
    const std::string whole = ReadTextFile(Path(name));
    for (std::size_t length = 0; length < whole.size(); ++length) {
      ASSERT_THAT(ReadMessage(std::string("cut_") + name, whole.substr(0, length)),
                  HasSubstr(std::string("cut_") + name + ":"))
          << length;
    }
  }
}

TEST_F(MeshFile, FalseCountsAreRefusedBeforeAllocation) {
  WriteMesh(MakeTetrahedron(), Path("a.stl"));
  std::string stl = ReadTextFile(Path("a.stl"));
  const std::uint32_t lie = 4000000000u;
  std::memcpy(stl.data() + 80, &lie, 4);
  EXPECT_THAT(ReadMessage("lie.stl", stl),
              EndsWith("lie.stl: the binary STL states 4,000,000,000 triangles (200,000,000,084 bytes), but the "
                       "file has 284 bytes; it is cut off or not an STL"));
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(
      ReadMessage("lie.ply",
                  "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n" + xyz + "end_header\n"),
      HasSubstr("the PLY states 18,446,744,073,709,551,615 rows of element 'vertex', more than its 0 bytes can hold"));
  EXPECT_THAT(ReadMessage("list.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz +
                                          "element face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n"
                                          "2000000000 0 0\n"),
              HasSubstr("face 1 states a list of 2000000000 values, more than the file contains"));
}

TEST_F(MeshFile, IndicesOutOfRangeAndBadNumbersAreNamed) {
  EXPECT_THAT(
      ReadMessage("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
      EndsWith("a.obj:4: a face uses point 4, but the number of points defined before it is 3; they count from 1"));
  EXPECT_THAT(ReadMessage("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n"), HasSubstr("b.obj:4: a face uses point 0"));
  EXPECT_THAT(ReadMessage("c.obj", "v 0 0\n"), EndsWith("c.obj:1: expected three numbers after 'v', but found only 2"));
  EXPECT_THAT(ReadMessage("d.obj", "v 0 0 0\nf 1 1\n"), EndsWith("d.obj:2: a face needs at least three points"));
  EXPECT_THAT(ReadMessage("e.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"),
              EndsWith("e.obj: triangle 1 has a point that is not finite (nan, 0, 0)"));
  EXPECT_THAT(ReadMessage("f.obj", "v 0 0 0\n"), EndsWith("f.obj: contains no triangles"));
  EXPECT_THAT(ReadMessage("g.obj", "v 0 0 0\nf one two three\n"),
              HasSubstr("g.obj:2: expected point numbers after 'f', but found 'one'"));
  EXPECT_THAT(
      ReadMessage("a.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
      EndsWith("a.ply: face 1 uses point 3, but the points are 0 to 2"));
  TriangleMesh bad = MakeTetrahedron();
  bad.points[1].y = std::numeric_limits<double>::infinity();
  WriteMesh(bad, Path("inf.stl"));
  EXPECT_THAT(test::MessageOf([&] { ReadMesh(Path("inf.stl")); }),
              HasSubstr("triangle 1 has a point that is not finite"));
}

TEST_F(MeshFile, FilesThatAreNotSurfacesAreRefused) {
  EXPECT_THAT(ReadMessage("a.txt", "hello"), EndsWith("a.txt: a surface's name must end in .stl, .obj or .ply"));
  EXPECT_THAT(ReadMessage("a.stl", "hello"), EndsWith("a.stl: not an STL file"));
  EXPECT_THAT(ReadMessage("a.ply", "hello\n"), EndsWith("a.ply: not a PLY file"));
  EXPECT_THAT(ReadMessage("a.obj", "hello\n"), EndsWith("a.obj: contains no triangles"));
  EXPECT_THAT(test::MessageOf([&] { ReadMesh(Path("none.stl")); }), EndsWith("none.stl: there is no such file"));
  EXPECT_THAT(test::MessageOf([&] { WriteMesh(MakeTetrahedron(), Path("a.vtk")); }),
              HasSubstr("must end in .stl, .obj or .ply"));
  EXPECT_THAT(test::MessageOf([&] { WriteMesh(MakeTetrahedron(), Path("no/a.stl")); }),
              HasSubstr("there is no folder"));
}

TEST_F(MeshFile, ColouredPlyHoldsTheColoursAndTheSurface) {
  const TriangleMesh tetrahedron = MakeTetrahedron();
  WriteColouredMesh(tetrahedron, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {250, 251, 252}}, Path("c.ply"));
  EXPECT_DOUBLE_EQ(CalcEnclosedVolume(ReadMesh(Path("c.ply"))), 8.0 / 6);
  const std::string bytes = ReadTextFile(Path("c.ply"));
  EXPECT_THAT(bytes, HasSubstr("property uchar red"));
  EXPECT_THAT(bytes, HasSubstr("\xfa\xfb\xfc"));
  EXPECT_THAT(test::MessageOf([&] { WriteColouredMesh(tetrahedron, {}, Path("c.ply")); }),
              HasSubstr("0 colours for 4 points"));
}

double LargestDistanceFromSphere(const TriangleMesh& mesh, double radius_mm) {
  double largest = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 centre = (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0;
    largest = std::max(largest, std::abs(glm::length(centre) - radius_mm));
  }
  return largest;
}

TEST(Decimate, SphereStaysClosedRoundAndKeepsItsVolume) {
  const TriangleMesh sphere = MakeSphere(30, 100, {0, 0, 0});
  const double volume = CalcEnclosedVolume(sphere);
  for (const std::size_t target : {10000u, 2000u, 500u}) {
    SCOPED_TRACE(target);
    const TriangleMesh reduced = Decimate(sphere, target);
    EXPECT_LE(reduced.triangles.size(), target);
    EXPECT_GE(reduced.triangles.size(), target - target / 20);
    EXPECT_EQ(CountOpenEdges(reduced), 0u);
    // n equal triangles of edge a cover the sphere if n sqrt(3)/4 a^2 = 4 pi R^2; their sagitta is a^2 / (6 R). Twice
    // this sagitta is a sufficient bound for uneven triangles. An inscribed polyhedron would lose about half the
    // sagitta everywhere, which is a fraction 3 (sagitta / 2) / R of the volume; the quadrics must not do worse.
    const double sagitta_mm = 16 * std::numbers::pi * 900 / (std::sqrt(3.0) * static_cast<double>(target)) / 180;
    EXPECT_LT(LargestDistanceFromSphere(reduced, 30), 2 * sagitta_mm);
    EXPECT_NEAR(CalcEnclosedVolume(reduced), volume, 1.5 * sagitta_mm / 30 * volume);
    std::printf("sphere %zu -> %zu triangles: volume %+.4f %%\n", sphere.triangles.size(), reduced.triangles.size(),
                100 * (CalcEnclosedVolume(reduced) / volume - 1));
  }
}

TEST(Decimate, MandibleStaysClosedAndKeepsItsVolume) {
  const std::string path = std::string(KERF_TEST_DATA) + "/mesh_dynjaw/jaw_smooth.stl";
  if (!fs::exists(path)) GTEST_SKIP() << "not found: " << path;
  const TriangleMesh jaw = ReadMesh(path);
  ASSERT_EQ(CountOpenEdges(jaw), 0u);
  const double volume = CalcEnclosedVolume(jaw);
  EXPECT_NEAR(volume, 57600, 50);  // the README of the data states 57.6 cm3
  for (const std::size_t target : {20000u, 10000u, 3000u}) {
    const TriangleMesh reduced = Decimate(jaw, target);
    EXPECT_LE(reduced.triangles.size(), target);
    EXPECT_EQ(CountOpenEdges(reduced), 0u);
    // The measured differences are -0.02 %, -0.08 % and -0.35 %.
    EXPECT_NEAR(CalcEnclosedVolume(reduced), volume, (target >= 10000 ? 1e-3 : 5e-3) * volume);
    std::printf("mandible %zu -> %zu triangles: volume %+.4f %%\n", jaw.triangles.size(), reduced.triangles.size(),
                100 * (CalcEnclosedVolume(reduced) / volume - 1));
  }
}

// Adds one face of a box: a grid of n x n squares that `edge_u` and `edge_v` span from `origin`, facing edge_u x
// edge_v.
void AddGrid(const Vec3& origin, const Vec3& edge_u, const Vec3& edge_v, int n, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) mesh.points.push_back(origin + edge_u * (1.0 * i / n) + edge_v * (1.0 * j / n));
  }
  const auto id = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
}

TEST_F(MeshFile, FlatFacesAndTheirEdgesAreKeptExactlyByDecimation) {
  // On the flat faces of a block all errors are equal, a case in which a decimation can fail.
  TriangleMesh block;
  const Vec3 x{16, 0, 0}, y{0, 8, 0}, z{0, 0, 4},
      o{0, 0, 0};  // binary fractions, so that edges of faces coincide exactly
  constexpr int kSquares = 128;
  AddGrid(o, y, x, kSquares, block), AddGrid(z, x, y, kSquares, block), AddGrid(o, x, z, kSquares, block);
  AddGrid(y, z, x, kSquares, block), AddGrid(o, z, y, kSquares, block), AddGrid(x, y, z, kSquares, block);
  WriteMesh(block, Path("block.stl"));
  block = ReadMesh(Path("block.stl"));  // reading the file joins the faces
  ASSERT_EQ(block.triangles.size(), 6u * 2 * kSquares * kSquares);
  ASSERT_EQ(CountOpenEdges(block), 0u);
  const TriangleMesh reduced = Decimate(block, 300);
  EXPECT_LE(reduced.triangles.size(), 300u);
  EXPECT_EQ(CountOpenEdges(reduced), 0u);
  EXPECT_NEAR(CalcEnclosedVolume(reduced), 16 * 8 * 4, 1e-6 * 16 * 8 * 4);
}

TEST(Decimate, OpenSurfaceKeepsItsRim) {
  TriangleMesh sheet;
  AddGrid({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 50, sheet);
  const TriangleMesh reduced = Decimate(sheet, 100);
  EXPECT_LE(reduced.triangles.size(), 100u);
  double area = 0;
  for (const auto& t : reduced.triangles) {
    area += 0.5 * glm::length(glm::cross(reduced.points[t[1]] - reduced.points[t[0]],
                                         reduced.points[t[2]] - reduced.points[t[0]]));
  }
  EXPECT_NEAR(area, 100, 1e-4);
}

TEST(Decimate, SphereCanBeReducedToAlmostATetrahedron) {
  const TriangleMesh reduced = Decimate(MakeSphere(10, 20, {1, 2, 3}), 4);
  EXPECT_GE(reduced.triangles.size(), 4u);
  EXPECT_LE(reduced.triangles.size(), 12u);
  EXPECT_EQ(CountOpenEdges(reduced), 0u);
  EXPECT_GT(CalcEnclosedVolume(reduced), 0);
}

TEST(Decimate, TorusKeepsItsHole) {
  TriangleMesh torus;
  constexpr int kAround = 60;
  constexpr int kTube = 20;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kTube; ++j) {
      const double u = 2 * std::numbers::pi * i / kAround;
      const double v = 2 * std::numbers::pi * j / kTube;
      const double r = 10 + 3 * std::cos(v);
      torus.points.emplace_back(r * std::cos(u), r * std::sin(u), 3 * std::sin(v));
      const auto id = [&](int a, int b) { return static_cast<std::uint32_t>(a % kAround * kTube + b % kTube); };
      torus.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      torus.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  for (const std::size_t target : {200u, 4u}) {
    const TriangleMesh reduced = Decimate(torus, target);
    EXPECT_LE(reduced.triangles.size(), std::max(target, std::size_t{80}));
    EXPECT_EQ(CountOpenEdges(reduced), 0u);
    // By Euler's formula, points - edges + triangles is 0 on a torus and 2 on a sphere; a closed mesh has 3/2 edges per
    // triangle.
    EXPECT_EQ(2 * reduced.points.size(), reduced.triangles.size());
  }
}

TEST(Decimate, SmallEnoughMeshIsLeftAloneAndAbsurdTargetsAreRefused) {
  const TriangleMesh tetrahedron = MakeTetrahedron();
  EXPECT_EQ(Decimate(tetrahedron, 4).triangles, tetrahedron.triangles);
  EXPECT_THAT(test::MessageOf([&] { Decimate(tetrahedron, 3); }), HasSubstr("triangles = 3 is below 4"));
}

}  // namespace
}  // namespace kerf
