// The imported surface matches that of the scanned body to a fraction of a voxel, for any lattice.
#include <gmock/gmock.h>

#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "bone/import/image_file.h"
#include "bone/import/import.h"
#include "bone/mesh/meshfile.h"
#include "ct_files.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

using test::Ball;
using test::Folder;
using test::MessageOf;
using ::testing::HasSubstr;

double BallVolume(double r) {
  return 4.0 / 3.0 * std::numbers::pi * r * r * r;
}

ImportOptions AllBone(double voxel_mm) {
  ImportOptions options;
  options.voxel_mm = voxel_mm;
  options.isolate.isolate = false;
  options.isolate.smallest_piece_mm3 = 0;
  options.isolate.iso_hu = 500;  // half the ball's value: the true surface of a blurred edge
  return options;
}

// A ball whose centre is not a lattice point, on a lattice with the given axes.
struct Lattice {
  const char* name;
  Vec3 spacing_mm;
  glm::dmat3 axes_W;
};

std::vector<Lattice> Lattices() {
  const glm::dmat3 straight(1);
  const glm::dmat3 oblique = glm::mat3_cast(glm::angleAxis(0.6, glm::normalize(Vec3(1, -1, 2))));
  glm::dmat3 sheared(1);
  sheared[2] = glm::normalize(Vec3(0, 0.3, 1));
  return {{"1 mm", {1, 1, 1}, straight},
          {"thick slices", {0.5, 0.5, 2}, straight},
          {"oblique", {1, 0.8, 1.2}, oblique},
          {"tilted gantry", {1, 1, 1}, sheared}};
}

TEST(ImportedSurface, BallHasItsVolumeAndPosition) {
  constexpr double kBallRadius = 12;
  const Vec3 centre(3.217, -41.63, 77.41);
  for (const Lattice& lattice : Lattices()) {
    const Folder folder;
    std::array<int, 3> size{};
    Vec3 middle;
    for (int a = 0; a < 3; ++a) {
      size[a] = static_cast<int>(std::ceil(40 / lattice.spacing_mm[a]));
      middle[a] = 0.5 * (size[a] - 1) * lattice.spacing_mm[a] + 0.3;
    }
    const Volume ct = test::MakeCt(size, lattice.spacing_mm, centre - lattice.axes_W * middle, lattice.axes_W,
                                   Ball(centre, kBallRadius));
    test::WriteNrrd(ct, folder.file("ball.nrrd"));
    const ImportResult result = Import(folder.file("ball.nrrd"), AllBone(0.3));
    EXPECT_NEAR(result.report.solid_mm3 / BallVolume(kBallRadius), 1, 0.01) << lattice.name;
    EXPECT_EQ(result.report.pieces, 1u);
    Vec3 sum{0};
    double worst = 0;
    const TriangleMesh surface = ExtractSurface(result.bone);
    for (const Vec3& p : surface.points) {
      sum += p;
      worst = std::max(worst, std::abs(glm::length(p - centre) - kBallRadius));
    }
    // The tolerance is a tenth of the finest spacing for the centre, and a quarter of the coarsest for the whole
    // surface.
    EXPECT_LT(glm::length(sum / static_cast<double>(surface.points.size()) - centre), 0.05) << lattice.name;
    EXPECT_LT(worst, 0.25 * std::max({lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z}))
        << lattice.name;
  }
}

TEST(ImportedSurface, NrrdAndNiftiGiveTheSameBone) {
  const Folder folder;
  const Volume ct = test::MakeCt({30, 28, 26}, {1, 1, 1}, {-15, 20, 100}, glm::dmat3(1), Ball({-0.3, 33.7, 112.2}, 9));
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  test::WriteNifti(ct, folder.file("a.nii"));
  test::WriteDicom(ct, folder.path());
  const ImportResult nrrd = Import(folder.file("a.nrrd"), AllBone(0.5));
  const ImportResult nifti = Import(folder.file("a.nii"), AllBone(0.5));
  EXPECT_EQ(nrrd.bone.CalcHash(), nifti.bone.CalcHash());
  EXPECT_EQ(nrrd.report.input_hash, nifti.report.input_hash);
  std::filesystem::remove(folder.file("a.nrrd"));
  const ImportResult dicom = Import(folder.path(), AllBone(0.5));
  EXPECT_EQ(dicom.bone.CalcHash(), nrrd.bone.CalcHash());
}

TEST(ImportedSurface, CavityIsFilledOrLeftHollow) {
  const Folder folder;
  // A shell from 6 to 10 mm, with a canal of 1.5 mm radius that leads out of its cavity.
  const Volume ct = test::MakeCt({30, 30, 30}, {1, 1, 1}, {-14.4, -14.6, -14.3}, glm::dmat3(1), [](const Vec3& p) {
    const double shell = std::abs(glm::length(p) - 8) - 2;
    const double canal = 1.5 - std::hypot(p.x, p.y);
    return p.z > 0 ? std::max(shell, canal) : shell;
  });
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  ImportOptions options = AllBone(0.4);
  const ImportResult filled = Import(folder.file("a.nrrd"), options);
  options.fill = false;
  const ImportResult hollow = Import(folder.file("a.nrrd"), options);
  const double canal_mm3 = std::numbers::pi * 1.5 * 1.5 * 4;
  // The mouth of the canal may or may not count as cavity, so the tolerance includes its volume. Blurred corners add a
  // little.
  EXPECT_NEAR(filled.report.solid_mm3, BallVolume(10), canal_mm3 + 0.01 * BallVolume(10));
  EXPECT_NEAR(hollow.report.solid_mm3, BallVolume(10) - BallVolume(6) - canal_mm3, 0.015 * BallVolume(10));
  EXPECT_NEAR(filled.report.filled_mm3, BallVolume(6), 0.5 * canal_mm3 + 0.05 * BallVolume(6));
  EXPECT_EQ(hollow.report.filled_mm3, 0);
}

TEST(ImportedSurface, BoneCutByTheScanIsClosedAndReported) {
  const Folder folder;
  const Volume ct = test::MakeCt({30, 30, 12}, {1, 1, 1}, {-15, -15, 0}, glm::dmat3(1), Ball({0, 0, 0}, 10));
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  const ImportResult result = Import(folder.file("a.nrrd"), AllBone(0.5));
  EXPECT_TRUE(result.report.cut_by_scan);
  EXPECT_EQ(CountOpenEdges(ExtractSurface(result.bone)), 0u);
  // The bone is half a ball plus half a voxel, by which the first slice extends outward.
  EXPECT_NEAR(result.report.solid_mm3, 0.5 * BallVolume(10) + 0.5 * std::numbers::pi * 100, 0.03 * BallVolume(10));
}

TEST(ImportedTissues, DependOnHuDepthAndEnamel) {
  const Folder folder;
  // Marrow of 400 HU in a cortex of 1500 HU and 3 mm thickness, and a lump of enamel on top.
  Volume ct = test::MakeCt({44, 44, 50}, {1, 1, 1}, {-22, -22, -22}, glm::dmat3(1), Ball({0, 0, 0}, 15), 1500);
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {
    const Vec3 p = ct.WorldFromVoxel(
        {static_cast<double>(v % 44), static_cast<double>(v / 44 % 44), static_cast<double>(v / (44 * 44))});
    if (glm::length(p) < 12) ct.hu[v] = 400;
    if (glm::length(p - Vec3(0, 0, 18)) < 4) ct.hu[v] = 2500;
  }
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  ImportOptions options = AllBone(0.5);
  options.isolate.iso_hu = 300;
  const ImportResult result = Import(folder.file("a.nrrd"), options);
  const Bone& bone = result.bone;
  EXPECT_EQ(bone.RegionAt({0, 0, 0}), 32);
  EXPECT_EQ(bone.RegionAt({0, 9, 0}), 32);
  EXPECT_EQ(bone.RegionAt({0, 13.5, 0}), 1);
  EXPECT_EQ(bone.RegionAt({0, 14.9, 0}), 1);  // blurred with soft tissue, but near the surface, so cortical
  EXPECT_EQ(bone.RegionAt({0, 0, 18}), 33);
  EXPECT_EQ(bone.RegionAt({0, 0, 21.9}), 33);  // on the surface of the tooth itself
  EXPECT_EQ(bone.RegionAt({0, 0, -40}), 0);
  EXPECT_EQ(bone.materials().At(33).tissue, Tissue::kTooth);
  double sum = 0;
  for (const auto& [id, mm3] : result.report.region_mm3) sum += mm3;
  EXPECT_NEAR(sum, result.report.solid_mm3, 1e-6 * result.report.solid_mm3);
  // The user sets the threshold; if marrow is above it, there is no cancellous bone.
  options.tissue.cortical_hu = 350;
  EXPECT_EQ(Import(folder.file("a.nrrd"), options).bone.RegionAt({0, 0, 0}), 1);
}

TEST(ImportedTissues, ATableThatLacksARegionIsRefused) {
  const Folder folder;
  test::WriteNrrd(test::MakeCt({24, 24, 24}, {1, 1, 1}, {-12, -12, -12}, glm::dmat3(1), Ball({0, 0, 0}, 9)),
                  folder.file("a.nrrd"));
  ImportOptions options = AllBone(0.5);
  MaterialTable table;
  Region cortex;
  cortex.id = 1;
  cortex.name = "cortex";
  cortex.E_MPa = 15000;
  cortex.nu = 0.3;
  table.Add(cortex);
  options.materials = table;
  options.materials_name = "mine.csv";
  EXPECT_THAT(MessageOf([&] { Import(folder.file("a.nrrd"), options); }),
              HasSubstr("mine.csv: the table lacks region 32, 33, which the import uses"));
}

TEST(ImportProvenance, NotesDescribeTheImportWithoutPersonalNames) {
  const Folder folder;
  test::WriteDicom(test::MakeCt({24, 24, 24}, {1, 1, 1}, {-12, -12, -12}, glm::dmat3(1), Ball({0, 0, 0}, 9)),
                   folder.path());
  const ImportResult result = Import(folder.path(), AllBone(0.5));
  const auto& notes = result.bone.notes();
  EXPECT_EQ(notes.at("import_input"), "DICOM");
  EXPECT_EQ(notes.at("import_series_uid"), "1.2.3.4.5");
  EXPECT_EQ(notes.at("import_iso_HU"), "500");
  EXPECT_EQ(notes.at("import_input_hash").size(), 16u);
  for (const auto& [key, value] : notes) EXPECT_EQ(value.find("SECRET"), std::string::npos) << key;
}

TEST(ImportOptionsRange, IsCheckedBeforeAnythingIsRead) {
  ImportOptions options;
  options.voxel_mm = 0.04;
  EXPECT_THAT(MessageOf([&] { Import("/nowhere", options); }),
              HasSubstr("voxel_mm = 0.04 is below 0.05; valid range 0.05 to 2 mm"));
  options.voxel_mm = std::nan("");
  EXPECT_THAT(MessageOf([&] { Import("/nowhere", options); }), HasSubstr("valid range"));
  options.voxel_mm = 0.2;
  options.isolate.keep_W = {{0, std::nan(""), 0}};
  EXPECT_THAT(MessageOf([&] { Import("/nowhere", options); }), HasSubstr("a coordinate that is not a finite number"));
  EXPECT_THAT(MessageOf([&] { Import("/nowhere", ImportOptions{}); }), HasSubstr("/nowhere: no such file or folder"));
  const Folder folder;
  test::WriteBytes(folder.file("scan.tiff"), "x");
  EXPECT_THAT(MessageOf([&] { Import(folder.file("scan.tiff"), ImportOptions{}); }), HasSubstr("unknown file type"));
}

// Returns a box with the given edge lengths, centred at the origin.
TriangleMesh Box(const Vec3& size) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.points.push_back(0.5 * size * Vec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TEST(ImportedMesh, HasItsVolumeAndAShellOfCortex) {
  const Folder folder;
  WriteMesh(Box({20, 16, 12}), folder.file("box.stl"));
  ImportOptions options;
  options.mesh_shell_mm = 2;
  const ImportResult result = Import(folder.file("box.stl"), options);
  EXPECT_NEAR(result.report.solid_mm3 / (20 * 16 * 12), 1, 0.005);
  EXPECT_FALSE(result.report.mandible);
  EXPECT_EQ(result.bone.RegionAt({0, 0, 0}), 32);
  EXPECT_EQ(result.bone.RegionAt({0, 0, 5.5}), 1);
  EXPECT_EQ(result.report.surface_error.points, 0);  // only for a CT is there an estimate
  // The core is the region deeper than the shell. Depth is known to a third of the 0.7 mm lattice, which rounds the
  // inner edges.
  const double core = 16.0 * 12 * 8;
  EXPECT_NEAR(result.report.region_mm3.at(32), core, 0.25 * 2 * (16 * 12 + 16 * 8 + 12 * 8));
}

TEST(ImportedMesh, InsideOutMeshGivesTheSameBone) {
  const Folder folder;
  TriangleMesh mesh = Box({20, 16, 12});
  WriteMesh(mesh, folder.file("a.ply"));
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  WriteMesh(mesh, folder.file("b.ply"));
  ImportOptions options;
  options.voxel_mm = 0.5;
  EXPECT_NEAR(Import(folder.file("a.ply"), options).report.solid_mm3,
              Import(folder.file("b.ply"), options).report.solid_mm3, 1e-6);
}

TEST(ImportedMesh, OpenMeshIsRefusedWithItsOpenEdges) {
  const Folder folder;
  TriangleMesh mesh = Box({20, 16, 12});
  mesh.triangles.pop_back();
  WriteMesh(mesh, folder.file("open.obj"));
  EXPECT_THAT(MessageOf([&] { Import(folder.file("open.obj"), ImportOptions{}); }),
              HasSubstr("the surface is not closed: 3 of its edges belong to one triangle only"));
}

// A box of 20 x 16 x 12 mm with a pocket of 8 x 8 x 6 mm behind a square mouth of 0.12 mm, 3 mm long. OpenVDB fills it.
TEST(ImportedMesh, PocketBehindANarrowMouthStaysHollow) {
  TriangleMesh mesh;
  const auto add_square = [&mesh](const Vec3& middle, double x, double y) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (const Vec3& corner : {Vec3(-x, -y, 0), Vec3(x, -y, 0), Vec3(x, y, 0), Vec3(-x, y, 0)})
      mesh.points.push_back(middle + 0.5 * corner);
    return first;
  };
  // Triangles between two squares, seen counter-clockwise if the first encloses the second as seen from above.
  const auto join = [&mesh](std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t e = 0; e < 4; ++e) {
      const std::uint32_t next = (e + 1) % 4;
      mesh.triangles.push_back({a + e, a + next, b + next});
      mesh.triangles.push_back({a + e, b + next, b + e});
    }
  };
  const std::uint32_t outer_below = add_square({0, 0, -6}, 20, 16), outer_above = add_square({0, 0, 6}, 20, 16);
  const std::uint32_t mouth_above = add_square({0.05, 0.05, 6}, 0.12, 0.12);
  const std::uint32_t mouth_below = add_square({0.05, 0.05, 3}, 0.12, 0.12);
  const std::uint32_t pocket_above = add_square({0, 0, 3}, 8, 8), pocket_below = add_square({0, 0, -3}, 8, 8);
  join(outer_below, outer_above);
  join(outer_above, mouth_above);
  join(mouth_above, mouth_below);
  join(mouth_below, pocket_above);
  join(pocket_above, pocket_below);
  mesh.triangles.push_back({pocket_below, pocket_below + 1, pocket_below + 2});
  mesh.triangles.push_back({pocket_below, pocket_below + 2, pocket_below + 3});
  mesh.triangles.push_back({outer_below, outer_below + 2, outer_below + 1});
  mesh.triangles.push_back({outer_below, outer_below + 3, outer_below + 2});
  const Folder folder;
  WriteMesh(mesh, folder.file("pocket.stl"));
  ImportOptions options;
  for (const bool fill : {true, false}) {
    options.fill = fill;
    const ImportResult result = Import(folder.file("pocket.stl"), options);
    EXPECT_NEAR(result.report.solid_mm3 / (20 * 16 * 12 - 8 * 8 * 6), 1, 0.005);
    EXPECT_GT(result.bone.SignedDistance({0, 0, 0}), 0);
  }
}

}  // namespace
}  // namespace kerf
