// Import of surfaces with inner shells, defects, and stated units.
#include "bone/import/closed_surface.h"

#include <gmock/gmock.h>

#include <random>

#include "bone/import/import.h"
#include "bone/import/mesh_units.h"
#include "bone/mesh/meshfile.h"
#include "ct_files.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void AddBox(TriangleMesh& mesh, double edge_mm, bool inward, const Vec3& centre = Vec3(0)) {
  constexpr std::array<std::array<std::uint32_t, 3>, 12> kTriangles{{{0, 2, 3},
                                                                     {0, 3, 1},
                                                                     {4, 5, 7},
                                                                     {4, 7, 6},
                                                                     {0, 1, 5},
                                                                     {0, 5, 4},
                                                                     {2, 6, 7},
                                                                     {2, 7, 3},
                                                                     {0, 4, 6},
                                                                     {0, 6, 2},
                                                                     {1, 3, 7},
                                                                     {1, 7, 5}}};
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (int c = 0; c < 8; ++c) {
    mesh.points.push_back(centre +
                          0.5 * edge_mm * Vec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1));
  }
  for (const auto& t : kTriangles) {
    mesh.triangles.push_back({first + t[0], first + t[inward ? 2 : 1], first + t[inward ? 1 : 2]});
  }
}

// Makes concentric boxes; each is given by its edge length and whether it faces inward.
TriangleMesh Boxes(const std::vector<std::pair<double, bool>>& boxes) {
  TriangleMesh mesh;
  for (const auto& [edge_mm, inward] : boxes) AddBox(mesh, edge_mm, inward);
  return mesh;
}

ImportOptions Coarse() {
  ImportOptions options;
  options.voxel_mm = 0.5;
  return options;
}

// Writes an STL with `header`, as other programs do.
void WriteForeignStl(const TriangleMesh& mesh, std::string header, const std::string& path) {
  WriteMesh(mesh, path);
  header.resize(80);
  test::WriteBytes(path, header + test::ReadBytes(path).substr(80));
}

// Returns the volume of the imported mesh, mm^3. Level sets chamfer edges slightly: 0.1 % of these volumes.
double ImportVolume(const TriangleMesh& mesh, const ImportOptions& options, ImportReport* report = nullptr) {
  const Folder folder;
  WriteForeignStl(mesh, "", folder.file("a.stl"));
  const ImportResult result = Import(folder.file("a.stl"), options);
  if (report != nullptr) *report = result.report;
  return result.report.solid_mm3;
}

TEST(HollowSurface, InnerShellWithOppositeOrientationIsAHollow) {
  ImportReport report;
  EXPECT_NEAR(ImportVolume(Boxes({{30, false}, {10, true}}), Coarse(), &report), 26000, 26);
  EXPECT_EQ(report.surface.shells, 2u);
  EXPECT_EQ(report.surface.hollow_shells, 1u);
  EXPECT_NEAR(report.surface.hollow_mm3, 1000, 1e-6);
  EXPECT_EQ(report.surface.how, "2 shells; 1 inner shell left hollow (1.00 cm3 in all), because it faces inward");
  EXPECT_THAT(report.surface.repairs, IsEmpty());
  // The same surface with all triangles inside out.
  EXPECT_NEAR(ImportVolume(Boxes({{30, true}, {10, false}}), Coarse()), 26000, 26);
  // A solid shell within the hollow is bone.
  EXPECT_NEAR(ImportVolume(Boxes({{30, false}, {20, true}, {10, false}}), Coarse()), 20000, 20);
}

TEST(HollowSurface, OutwardInnerShellIsSolidUnlessFillIsOff) {
  const TriangleMesh mesh = Boxes({{30, false}, {10, false}});
  ImportReport report;
  EXPECT_NEAR(ImportVolume(mesh, Coarse(), &report), 27000, 27);
  EXPECT_EQ(report.surface.how,
            "2 shells; 1 inner shell filled, because it faces outward (--no-fill leaves it hollow)");
  ImportOptions options = Coarse();
  options.fill = false;
  EXPECT_NEAR(ImportVolume(mesh, options, &report), 26000, 26);
  EXPECT_EQ(report.surface.how, "2 shells; 1 inner shell left hollow (1.00 cm3 in all), because of --no-fill");
}

TEST(HollowSurface, NotesAndRegionsReflectTheHollow) {
  const Folder folder;
  WriteMesh(Boxes({{30, false}, {10, true}}), folder.file("a.stl"));
  const ImportResult result = Import(folder.file("a.stl"), Coarse());
  EXPECT_THAT(result.bone.notes().at("import_shells"), HasSubstr("1 inner shell left hollow"));
  EXPECT_EQ(result.bone.notes().at("import_units"), "mm");
  EXPECT_GT(result.bone.SignedDistance({0, 0, 0}), 0);
  EXPECT_LT(result.bone.SignedDistance({0, 0, 10}), 0);
  EXPECT_EQ(result.bone.RegionAt({0, 0, 5.5}), 1);  // cortex lines the hollow too
  EXPECT_EQ(result.bone.RegionAt({0, 0, 10}), 32);
}

// Chains of nested boxes, side by side; each box is oriented inward or outward at random. A box with the same
// orientation as the one around it changes nothing.
TEST(HollowSurface, LayersMatchRandomChainsOfNestedShells) {
  std::mt19937 random(21);
  for (int trial = 0; trial < 20; ++trial) {
    TriangleMesh mesh;
    std::vector<std::size_t> shells_of(5, 0);  // number of shells in each layer
    double hollow_mm3 = 0;
    for (int cell = 0; cell < 8; ++cell) {
      const Vec3 centre(40 * (cell & 1), 40 * (cell >> 1 & 1), 40 * (cell >> 2));
      const int boxes = 1 + static_cast<int>(random() % 5);
      bool before = false;
      std::size_t layer = 0;
      for (int n = 0; n < boxes; ++n) {
        const double edge_mm = 30 - 6 * n;
        const bool inward = random() % 2 == 1;
        AddBox(mesh, edge_mm, inward, centre);
        if (n > 0 && inward != before) {
          ++layer;
          hollow_mm3 += (layer % 2 == 1 ? 1 : -1) * std::pow(edge_mm, 3);
        }
        ++shells_of[layer];
        before = inward;
      }
    }
    const ClosedSurface closed = CloseSurface(mesh, false, "a.stl");
    EXPECT_NEAR(closed.report.hollow_mm3, hollow_mm3, 1e-6);
    for (std::size_t n = 0; n < shells_of.size(); ++n) {
      const std::size_t triangles = n < closed.layers.size() ? closed.layers[n].triangles.size() : 0;
      EXPECT_EQ(triangles, 12 * shells_of[n]) << n;
    }
  }
}

TriangleMesh Jittered(double by_mm) {
  const TriangleMesh box = Boxes({{30, false}});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(-by_mm, by_mm);
  TriangleMesh soup;
  for (const auto& t : box.triangles) {
    for (const std::uint32_t p : t) {
      soup.points.push_back(box.points[p] + Vec3(jitter(random), jitter(random), jitter(random)));
    }
    const auto end = static_cast<std::uint32_t>(soup.points.size());
    soup.triangles.push_back({end - 3, end - 2, end - 1});
  }
  return soup;
}

TEST(FaultySurface, SeparateTrianglesAreWeldedWithinTheTolerance) {
  ImportReport report;
  // Two copies of a corner are at most 2 * sqrt(3) * 0.002 = 0.007 mm apart.
  EXPECT_NEAR(ImportVolume(Jittered(0.002), Coarse(), &report), 27000, 27);
  EXPECT_THAT(report.surface.repairs,
              ElementsAre("28 points lay nearer than 0.01 mm to another point and were welded to it"));
  EXPECT_THAT(MessageOf([&] { ImportVolume(Jittered(0.02), Coarse()); }),
              HasSubstr("36 of its edges belong to one triangle only, because the triangles are not joined: corners "
                        "that should coincide lie up to 0.1 mm apart, and kerf welds points nearer than 0.01 mm"));
}

TEST(FaultySurface, DuplicateTrianglesAreRemoved) {
  TriangleMesh mesh = Boxes({{30, false}});
  const std::vector<std::array<std::uint32_t, 3>> all = mesh.triangles;
  mesh.triangles.insert(mesh.triangles.end(), all.begin(), all.begin() + 4);
  ImportReport report;
  EXPECT_NEAR(ImportVolume(mesh, Coarse(), &report), 27000, 27);
  EXPECT_THAT(report.surface.repairs, ElementsAre("4 triangles were in the file more than once and were left out"));
  mesh.triangles = all;
  for (const auto& t : all) mesh.triangles.push_back({t[0], t[2], t[1]});  // both orientations of each triangle
  EXPECT_NEAR(ImportVolume(mesh, Coarse(), &report), 27000, 27);
  EXPECT_THAT(report.surface.repairs, ElementsAre("12 triangles were in the file more than once and were left out"));
}

TEST(FaultySurface, FlippedTrianglesAreTurned) {
  TriangleMesh mesh = Boxes({{30, false}, {10, true}});
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
  std::swap(mesh.triangles[20][0], mesh.triangles[20][1]);
  ImportReport report;
  EXPECT_NEAR(ImportVolume(mesh, Coarse(), &report), 26000, 26);
  EXPECT_THAT(report.surface.repairs,
              ElementsAre("3 triangles faced opposite to most of their shell and were flipped"));
}

TEST(FaultySurface, FaultsThatCannotBeRepairedAreNamed) {
  TriangleMesh hole = Boxes({{30, false}});
  hole.triangles.pop_back();
  EXPECT_THAT(MessageOf([&] { ImportVolume(hole, Coarse()); }),
              HasSubstr("a.stl: the surface is not closed: 3 of its edges belong to one triangle only, which is the "
                        "rim of a hole or of a gap wider than 0.01 mm; close the holes in a mesh program"));
  TriangleMesh flat = Boxes({{30, false}});
  for (Vec3& p : flat.points) p.z = 0.5 * p.x;
  EXPECT_THAT(MessageOf([&] { ImportVolume(flat, Coarse()); }),
              HasSubstr("a.stl: the surface is flat, so it encloses no volume"));
  TriangleMesh touching;
  AddBox(touching, 30, false);
  AddBox(touching, 30, false, {30, 30, 0});
  EXPECT_THAT(MessageOf([&] { ImportVolume(touching, Coarse()); }),
              HasSubstr("1 edge of the surface belongs to more than two triangles: parts touch along edges"));
  // The projective plane made of six points and ten triangles is closed, but one-sided.
  TriangleMesh one_sided;
  one_sided.points = {{0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, 0, 30}, {30, 30, 9}, {9, 30, 30}};
  one_sided.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                         {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  EXPECT_THAT(MessageOf([&] { ImportVolume(one_sided, Coarse()); }), HasSubstr("is one-sided"));
}

TEST(SurfaceUnits, AreRequiredIfMillimetresAreImplausible) {
  const auto message = [](double edge) { return MessageOf([&] { ImportVolume(Boxes({{edge, false}}), Coarse()); }); };
  EXPECT_THAT(message(0.03),
              HasSubstr("a.stl: the largest side of the surface is 0.03, which is unlikely for a bone in mm; give the "
                        "unit of its coordinates: --units m (it is then 30 mm) or --units mm to keep them "
                        "unchanged"));
  EXPECT_THAT(message(3), HasSubstr("--units cm (it is then 30 mm) or --units in (it is then 76.2 mm) or --units mm"));
  EXPECT_THAT(message(4.7), HasSubstr("--units in (it is then 119 mm)"));
  EXPECT_THAT(message(30000), HasSubstr("is 30000, "));
  EXPECT_THAT(message(30000), HasSubstr("--units um (it is then 30 mm)"));
  for (const auto& [unit, edge] : {std::pair{"m", 0.03}, {"cm", 3.0}, {"in", 30 / 25.4}, {"um", 30000.0}}) {
    ImportOptions options = Coarse();
    options.mesh_units = unit;
    EXPECT_NEAR(ImportVolume(Boxes({{edge, false}}), options), 27000, 27) << unit;
  }
  ImportOptions as_it_is = Coarse();
  as_it_is.mesh_units = "mm";
  EXPECT_NEAR(ImportVolume(Boxes({{3, false}}), as_it_is), 27, 0.5);
  EXPECT_THAT(MessageOf([&] {
                ImportVolume(Boxes({{30000, false}}), as_it_is);
              }),
              HasSubstr("the largest side of the surface is 30000 mm; kerf imports up to 1000 mm"));
  as_it_is.mesh_units = "feet";
  EXPECT_EQ(MessageOf([&] {
              ImportVolume(Boxes({{3, false}}), as_it_is);
            }),
            "'feet' is not a unit of length; the units are mm, cm, m, in, um");
}

TEST(SurfaceUnits, AreAskedForIfMillimetresAndCentimetresArePlausible) {
  const auto message = [](const Vec3& size, const std::string& unit, const glm::dmat3& turn = glm::dmat3(1)) {
    TriangleMesh box;
    for (int c = 0; c < 8; ++c) box.points.push_back(turn * (size * Vec3(c >> 2 & 1, c >> 1 & 1, c & 1)));
    return MessageOf([&] { ScaleToMm(box, unit, "a.stl"); });
  };
  // A skull in cm was read as a small piece in mm, with a warning; the bone was then 1000 times too small.
  EXPECT_EQ(message({14, 18, 16}, ""),
            "a.stl: the largest side of the surface is 18, which may be a piece of 18 mm or a skull of 18 cm; give the "
            "unit of its coordinates: --units mm or --units cm");
  EXPECT_THAT(message({3, 38, 2.5}, ""), HasSubstr("is 38, which may be a piece of 38 mm or a long bone of 38 cm"));
  EXPECT_THAT(message({9, 45, 10}, ""), HasSubstr("a long bone of 45 cm"));  // a femur
  // A fibula in an oblique position is still one.
  const glm::dmat3 oblique(glm::dvec3(1, 2, 2) / 3.0, glm::dvec3(2, 1, -2) / 3.0, glm::dvec3(2, -2, 1) / 3.0);
  EXPECT_THAT(message({3, 38, 2.5}, "", oblique), HasSubstr("or a long bone of"));
  EXPECT_THAT(message({28, 21, 17}, ""), HasSubstr("a pelvis of 28 cm"));
  EXPECT_THAT(message({4.4, 3.5, 20}, ""), HasSubstr("a long bone of a child of 20 cm"));
  TriangleMesh tiny = Boxes({{3, false}});
  try {
    ScaleToMm(tiny, "", "a.stl");
    FAIL() << "no error";
  } catch (const UnclearUnit& e) {
    std::vector<std::string> choices;
    for (const auto& [choice, side_mm] : e.choices()) choices.push_back(fmt::format("{} {:g}", choice, side_mm));
    EXPECT_THAT(choices, ElementsAre("cm 30", "in 76.2", "mm 3"));
    EXPECT_EQ(e.why(), "the largest side of the surface is 3, which is unlikely for a bone in mm");
  }
  for (const char* unit : {"mm", "cm"}) {
    EXPECT_EQ(message({14, 18, 16}, unit), "");
    EXPECT_EQ(message({3, 38, 2.5}, unit), "");
  }
  EXPECT_EQ(message({8, 7, 22}, ""), "");       // a tooth
  EXPECT_EQ(message({14, 38, 13}, ""), "");     // a segment of a fibula in mm
  EXPECT_EQ(message({6, 6, 21}, ""), "");       // a lower incisor
  EXPECT_EQ(message({20, 12, 9}, ""), "");      // a piece of bone
  EXPECT_EQ(message({118, 87, 77}, ""), "");    // a mandible
  EXPECT_EQ(message({140, 180, 160}, ""), "");  // a skull in mm
  EXPECT_EQ(message({30, 380, 25}, ""), "");    // a fibula in mm
}

TEST(SurfaceUnits, ThatTheFileStatesAreTakenAndSaid) {
  const Folder folder;
  TriangleMesh cube;
  AddBox(cube, 3, false);
  const auto import_as = [&](const std::string& header) {
    WriteForeignStl(cube, header, folder.file("a.stl"));
    return Import(folder.file("a.stl"), Coarse());
  };
  const ImportResult result = import_as("made by a program, UNITS=cm");
  EXPECT_NEAR(result.report.solid_mm3, 27000, 27);
  EXPECT_THAT(result.report.warnings, Contains("the file says that its unit is cm; --units overrides it"));
  EXPECT_EQ(result.bone.notes().at("import_units"), "cm");
  for (Vec3& p : cube.points) p *= 10;
  const ImportResult unknown = import_as("UNITS=furlongs SPACE=LPS");
  EXPECT_NEAR(unknown.report.solid_mm3, 27000, 27);
  EXPECT_THAT(unknown.report.warnings,
              Contains("the file says that its unit is 'furlong', which kerf does not know: mm was assumed; --units "
                       "states another"));
  EXPECT_THAT(import_as("units: see the manual").report.warnings, IsEmpty());
  EXPECT_THAT(MessageOf([&] { import_as("units: m"); }),
              HasSubstr("kerf imports up to 1000 mm; the file says that its unit is m; --units overrides it"));
}

TEST(SurfaceUnits, OfSurfacesThatKerfWroteAreKnown) {
  TriangleMesh splinter;
  AddBox(splinter, 3, false);
  for (Vec3& p : splinter.points) p.z *= 12.6;  // 38 mm long
  const Folder folder;
  for (const char* name : {"a.stl", "a.obj", "a.ply"}) {
    WriteMesh(splinter, folder.file(name));
    EXPECT_NEAR(Import(folder.file(name), Coarse()).report.solid_mm3, 9 * 37.8, 9) << name;
    // --units wins. The bone is then too large for these voxels.
    ImportOptions metres = Coarse();
    metres.mesh_units = "m";
    EXPECT_THAT(MessageOf([&] { Import(folder.file(name), metres); }), HasSubstr("kerf imports up to 1000 mm"));
  }
  EXPECT_THAT(MessageOf([&] { ImportVolume(splinter, Coarse()); }), HasSubstr("--units mm or --units cm"));
}

TEST(SurfaceFrame, IsThatOfTheFileUnlessAnotherIsStated) {
  // A box with x from 0 to 20, y from 0 to 12 and z from 0 to 9.
  TriangleMesh box;
  AddBox(box, 1, false, Vec3(0.5));
  for (Vec3& p : box.points) p *= Vec3(20, 12, 9);
  const Folder folder;
  const auto import = [&](const std::string& header, const std::string& frame) {
    WriteForeignStl(box, header, folder.file("a.stl"));
    ImportOptions options = Coarse();
    options.frame = frame;
    ImportResult result = Import(folder.file("a.stl"), options);
    EXPECT_NEAR(result.report.solid_mm3, 20 * 12 * 9, 20);
    return result;
  };
  const auto corner = [&](const std::string& header, const std::string& frame) {
    return import(header, frame).report.box.lower;
  };
  const auto is_near = [](const Vec3& a, const Vec3& b) { return glm::length(a - b) < 0.01; };
  EXPECT_TRUE(is_near(corner("made by x", ""), Vec3(0)));
  EXPECT_TRUE(is_near(corner("3D Slicer output. SPACE=LPS", ""), Vec3(0)));
  EXPECT_TRUE(is_near(corner("3D Slicer output. SPACE=RAS", ""), Vec3(-20, -12, 0)));
  EXPECT_TRUE(is_near(corner("3D Slicer output. SPACE=RAS", "LPS"), Vec3(0)));
  EXPECT_TRUE(is_near(corner("3D Slicer output. SPACE=RAS", "RAS"), Vec3(-20, -12, 0)));
  EXPECT_THAT(import("SPACE=LPS", "").report.warnings, IsEmpty());
  EXPECT_THAT(import("SPACE=RAS", "RAS").report.warnings, IsEmpty());
  EXPECT_THAT(import("SPACE=RAS", "LPS").report.warnings,
              ElementsAre("the file says SPACE=RAS, but was read as LPS because of --frame"));
  EXPECT_THAT(
      import("SPACE=XYZ", "").report.warnings,
      ElementsAre("the file says SPACE=XYZ, which kerf does not know: LPS was assumed; --frame states another"));
  EXPECT_THAT(import("SPACE=XYZ", "RAS").report.warnings, IsEmpty());
  const ImportResult turned = import("SPACE=RAS", "");
  const std::string said = "the file says SPACE=RAS, so x and y were turned to LPS";
  EXPECT_THAT(turned.report.warnings, ElementsAre(said));
  EXPECT_THAT(turned.bone.notes().at("import_warnings"), HasSubstr(said));
}

TEST(SurfaceFaults, WhatWasFoundWhileReadingIsPartOfTheMessage) {
  const Folder folder;
  WriteForeignStl(Boxes({{30, false}}), "", folder.file("a.stl"));
  std::string bytes = test::ReadBytes(folder.file("a.stl"));
  bytes.resize(bytes.size() - 100);  // without the last two triangles
  test::WriteBytes(folder.file("a.stl"), bytes);
  EXPECT_THAT(
      MessageOf([&] { Import(folder.file("a.stl"), Coarse()); }),
      AllOf(HasSubstr("the surface is not closed"), HasSubstr("; the STL states 12 triangles, but its length is "
                                                              "that of 10; it was read by its length")));
}

TEST(SurfaceSize, TooLargeVolumeIsRefusedBeforeVoxelisation) {
  const auto message = [](double edge, double voxel_mm) {
    ImportOptions options = Coarse();
    options.voxel_mm = voxel_mm;
    return MessageOf([&] { ImportVolume(Boxes({{edge, false}}), options); });
  };
  EXPECT_THAT(message(500, 0.1),
              HasSubstr("a.stl: the surface encloses 125.0 litres, but with voxels of 0.1 mm kerf imports up to 2.0: "
                        "check its unit (--units) or use --voxel 1 or more"));
  EXPECT_THAT(message(130, 0.1), HasSubstr("or use --voxel 0.3 or more"));  // 2.2 litres
  EXPECT_THAT(message(2e30, 0.1),
              HasSubstr("the largest side of the surface is more than 1 km; kerf imports up to 1000 mm"));
}

TEST(SurfaceOptions, CtOptionsAreRefused) {
  ImportOptions options = Coarse();
  options.isolate.keep_W = {{0, 0, 0}};
  EXPECT_THAT(MessageOf([&] {
                ImportVolume(Boxes({{30, false}}), options);
              }),
              HasSubstr("points to keep or to drop select bone in a CT; a surface is imported whole"));
}

// There are two voxels just above the iso value within dense bone. A cubic spline through them falls below that value
// between them, so the level set has a void where no voxel of the CT is below iso.
TEST(ImportedVoids, VoidsSmallerThanCtVoxelsAreFilledAndCounted) {
  Volume ct = test::MakeCt({30, 28, 26}, {1, 1, 1}, {-15, -14, -13}, glm::dmat3(1), test::Ball({0, 0, 0}, 11), 1500);
  const std::vector<std::array<int, 3>> places = {{12, 13, 12}, {17, 13, 12}, {12, 17, 15}};
  for (const auto& [i, j, k] : places) {
    ct.hu[ct.Index(i, j, k)] = 305;
    ct.hu[ct.Index(i + 1, j, k)] = 305;
  }
  const Folder folder;
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  ImportOptions options;
  options.voxel_mm = 0.2;
  options.isolate.isolate = false;
  options.isolate.smallest_piece_mm3 = 0;
  const ImportResult filled = Import(folder.file("a.nrrd"), options);
  EXPECT_EQ(filled.report.filled_mm3, 0);  // the CT itself has no voids
  EXPECT_EQ(filled.report.voids.count, places.size());
  EXPECT_EQ(CloseSurface(ExtractSurface(filled.bone), false, "surface").report.shells, 1u);
  options.fill = false;
  const ImportResult hollow = Import(folder.file("a.nrrd"), options);
  EXPECT_EQ(hollow.report.voids.count, 0u);
  const SurfaceReport shells = CloseSurface(ExtractSurface(hollow.bone), false, "surface").report;
  EXPECT_EQ(shells.hollow_shells, places.size());
  // The voids are two or three voxels wide, so counting voxels gives their volume only to within a factor of 2.5.
  EXPECT_GT(filled.report.voids.mm3, shells.hollow_mm3 / 2.5);
  EXPECT_LT(filled.report.voids.mm3, shells.hollow_mm3 * 2.5);
  EXPECT_NEAR(filled.report.solid_mm3 - hollow.report.solid_mm3, shells.hollow_mm3, 0.35 * shells.hollow_mm3);
}

}  // namespace
}  // namespace kerf
