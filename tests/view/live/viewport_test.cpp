// Tests of pixels of the window with known values. With KERF_VIEW_PICTURES=folder in the environment, the pictures are
// written there for inspection.
#include "view/live/viewport.h"

#include <gtest/gtest.h>
#include <vtkRenderWindow.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "bone/grid/ct_modulus.h"
#include "bone/grid/set_leaf.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "support/chunks.h"
#include "view/live/slice_view.h"
#include "view/live/surface_worker.h"
#include "view/picture/offscreen.h"

namespace kerf {
namespace {

void Leave(const Image& image, const std::string& name) {
  if (const char* folder = std::getenv("KERF_VIEW_PICTURES"))
    WritePng(image, std::string(folder) + "/" + name + ".png");
}

void Upload(Viewport& view, SurfaceWorker& worker) {
  worker.WaitIdle();
  for (auto meshes = worker.Fetch(1000); !meshes.empty(); meshes = worker.Fetch(1000)) {
    for (const ChunkMesh& mesh : meshes) view.SetChunk(mesh);
  }
}

// A view of a plate of 16 x 10 x 10 mm with its top at z = 0, with the panels off.
class OnePlate : public ::testing::Test {
 protected:
  static constexpr int kWidth = 640;
  static constexpr int kHeight = 400;
  static constexpr double kHeight_mm = 40;
  static constexpr double kMmPerPixel = kHeight_mm / kHeight;

  OnePlate() : bone(test::MakePlate(0.25)), offscreen(kWidth, kHeight), view(offscreen.window()), worker(bone, 2) {
    view.BeginBone(bone.materials(), worker.origin_W(), worker.bounds_W(), bone.voxel_mm());
    Upload(view, worker);
    view.set_show_handpiece(false);
    view.SetFineness(0.5, 0.5, 1'000'000);
    view.camera().set_parallel(true);
    view.camera().Look(View::kTop);
    view.camera().set_target_W({0, 0, 0});
    view.camera().set_height_mm(kHeight_mm);
  }
  Image Draw() {
    view.Render();
    return view.Grab();
  }
  // Number and centroid of the pixels above the status line in which two pictures differ.
  struct Difference {
    double count = 0;
    double x = 0;
    double y = 0;
  };
  static Difference Compare(const Image& a, const Image& b) {
    Difference d;
    for (int row = 0; row < a.height - 30; ++row) {
      for (int column = 0; column < a.width; ++column) {
        if (a.At(column, row) == b.At(column, row)) continue;
        ++d.count;
        d.x += column + 0.5;
        d.y += row + 0.5;
      }
    }
    if (d.count > 0) {
      d.x /= d.count;
      d.y /= d.count;
    }
    return d;
  }

  Bone bone;
  OffscreenWindow offscreen;
  Viewport view;
  SurfaceWorker worker;
};

TEST_F(OnePlate, PlateCoversItsAreaWithoutGaps) {
  const Image with = Draw();
  view.set_bone_hidden(true);
  const Difference d = Compare(with, Draw());
  // The face is 16 x 10 mm. Along its outline of 52 mm, each pixel may count or not.
  EXPECT_NEAR(d.count * kMmPerPixel * kMmPerPixel, 160, 52 * kMmPerPixel);
  EXPECT_NEAR(d.x, 0.5 * kWidth, 1);
  EXPECT_NEAR(d.y, 0.5 * kHeight, 1);
  EXPECT_GT(view.stats().surface_bytes, 10000u);
}

// The panels show the force of this frame; its label must not be that of the last picture.
TEST_F(OnePlate, LabelsAreThoseOfTheLatestState) {
  view.SetForce(ForceArrow{.p_W = {0, 0, 1}, .f_W_N = {0, 0, 2}, .label = "2.0 N"});
  ASSERT_EQ(view.ListLabels().size(), 1u);
  EXPECT_EQ(view.ListLabels()[0].text, "2.0 N");
  Draw();
  view.SetForce(ForceArrow{.p_W = {0, 0, 1}, .f_W_N = {0, 0, 7}, .label = "7.0 N"});
  view.SetAlarms({{{1, 2, 3}, AlarmLevel::kNotice, "nerve"}, {{3, 2, 1}, AlarmLevel::kDanger, "tooth"}});
  view.SetPlanes({{.name = "plane 1"}});
  const std::vector<SceneLabel> labels = view.ListLabels();
  ASSERT_EQ(labels.size(), 4u);
  const auto expect = [&](std::size_t i, const char* text, bool matters) {
    EXPECT_EQ(labels[i].text, text);
    EXPECT_EQ(labels[i].matters, matters) << text;
  };
  expect(0, "tooth", true);  // the greatest danger first
  expect(1, "nerve", false);
  expect(2, "7.0 N", true);
  expect(3, "plane 1", false);
  view.SetForce(std::nullopt);
  EXPECT_EQ(view.ListLabels().size(), 3u);
}

// A line of 3.2 points with a casing of 6 points.
TEST_F(OnePlate, MeasuringLineIsThickerThanAHair) {
  for (const double scale : {1.0, 2.0}) {
    view.Resize(kWidth, kHeight, scale);
    view.SetMeasures({});
    const Image without = Draw();
    view.SetMeasures({{{{-5, 0, 1}, {5, 0, 1}}, "10.0 mm"}});
    const Image with = Draw();
    int rows = 0;
    for (int row = 0; row < with.height; ++row) {
      rows += with.At(kWidth / 2, row) == without.At(kWidth / 2, row) ? 0 : 1;
    }
    EXPECT_NEAR(rows, 6 * scale, 1.5) << scale;
  }
}

TEST_F(OnePlate, KnowsWhetherThePictureHasChanged) {
  EXPECT_TRUE(view.has_changed()) << "nothing was drawn yet";
  view.SetTool(DiscSaw{});
  const Pose X_WT{Quat{1, 0, 0, 0}, {0, 0, 5}};
  const std::vector<PlaneOverlay> planes{{.name = "p"}};
  const std::vector<PointOverlay> points{{.p_W = {1, 2, 3}}};
  const std::vector<AlarmOverlay> alarms{{.p_W = {1, 2, 3}, .level = AlarmLevel::kDanger}};
  const ForceArrow force{.p_W = {0, 0, 1}, .f_W_N = {0, 0, 2}};
  const auto set_all = [&] {
    view.SetToolPose(X_WT, 0, 0.5);
    view.SetPlanes(planes);
    view.SetPoints(points);
    view.SetAlarms(alarms);
    view.SetForce(force);
    view.SetContact(Vec3{1, 0, 0});
    view.SetGhost(std::nullopt);
    view.set_translucent(false);
    view.AdvanceDust(0.1);
    view.camera().set_height_mm(kHeight_mm);
  };
  set_all();
  view.Render();
  set_all();
  EXPECT_FALSE(view.has_changed()) << "everything was set to what it was";

  const auto changes = [&](const std::function<void()>& change) {
    set_all();
    view.Render();
    change();
    const bool changed = view.has_changed();
    set_all();
    return changed;
  };
  EXPECT_TRUE(changes([&] { view.SetToolPose({X_WT.R_AB, {0, 0, 5.001}}, 0, 0.5); }));
  EXPECT_TRUE(changes([&] { view.SetToolPose(X_WT, 0, 0.51); }));
  EXPECT_TRUE(changes([&] { view.SetPlanes({}); }));
  EXPECT_TRUE(changes([&] { view.SetPoints({}); }));
  EXPECT_TRUE(changes([&] { view.SetAlarms({}); }));
  EXPECT_TRUE(changes([&] { view.SetForce(std::nullopt); }));
  EXPECT_TRUE(changes([&] { view.SetContact(std::nullopt); }));
  EXPECT_TRUE(changes([&] { view.SetGhost(X_WT); }));
  EXPECT_TRUE(changes([&] { view.set_translucent(true); }));
  EXPECT_TRUE(changes([&] { view.camera().Orbit(3, 0); }));
  EXPECT_TRUE(changes([&] { view.camera().Zoom(1.1, {10, 10}); }));
  EXPECT_TRUE(changes([&] { view.set_theme(Theme::kDark); }));
  // A disc that is drawn blurred looks the same at every angle.
  view.SetToolPose(X_WT, 7500, 0);
  view.Render();
  view.SetToolPose(X_WT, 7500, 1);
  EXPECT_FALSE(view.has_changed());
  // Dust moves until it is gone.
  view.AddDust({0, 0, 5}, {10, 0, 0}, 1);
  view.AdvanceDust(0.1);
  EXPECT_TRUE(view.has_changed());
  view.AdvanceDust(10);
  view.Render();
  view.AdvanceDust(0.1);
  EXPECT_FALSE(view.has_changed());
}

TEST_F(OnePlate, AllFacesTowardsTheEyeAreDrawn) {
  // The chunks are 3.2 mm long: some lie within a face, and all their triangles face the same way.
  const Bone fine = test::MakePlate(0.1);
  SurfaceWorker fine_worker(fine, 2);
  view.BeginBone(fine.materials(), fine_worker.origin_W(), fine_worker.bounds_W(), fine.voxel_mm());
  Upload(view, fine_worker);
  view.camera().set_target_W({0, 0, -5});
  std::size_t fewest = 1'000'000;
  for (const bool parallel : {true, false}) {
    view.camera().set_parallel(parallel);
    for (const Vec3& toward :
         {Vec3{0.2, -0.3, 1}, Vec3{1, -0.4, 0.1}, Vec3{0.5, 1, 0.15}, Vec3{-1, 0.05, -0.3}, Vec3{-0.4, -0.5, -1}}) {
      view.camera().Look(toward, {0.1, 0.2, 0.9});
      view.set_bone_hidden(false);
      const Image with = Draw();
      fewest = std::min(fewest, view.stats().drawn);
      view.set_bone_hidden(true);
      const double mm2 = Compare(with, Draw()).count * kMmPerPixel * kMmPerPixel;
      const Vec3 d = glm::normalize(toward);
      const double shadow = 160 * std::abs(d.z) + 160 * std::abs(d.y) + 100 * std::abs(d.x);
      // The tolerance is a pixel along an outline of at most 60 mm. In perspective, nearer parts are up to a fifth
      // larger.
      EXPECT_GT(mm2, (parallel ? 1.0 : 0.9) * shadow - 60 * kMmPerPixel);
      EXPECT_LT(mm2, (parallel ? 1.0 : 1.2) * shadow + 60 * kMmPerPixel);
    }
  }
  EXPECT_LT(fewest, view.stats().chunks);
}

TEST_F(OnePlate, BoneOfAnEarlierSessionIsDrawnInItsPlaceAgain) {
  // Only 20 mm are left of a bar 400 mm long, until undo brings back the rest.
  BlockParams params;
  params.size_mm = {400, 10, 10};
  params.layers = {{10, 24}};
  params.voxel_mm = 0.25;
  const Bone bar = MakeBlock(params, DefaultMandibleTable());
  Bone rest = bar;
  CutAway(rest, bar.CalcBounds().Grown(1), [](const Vec3& p_W) { return std::abs(p_W.x) - 10; });
  SurfaceWorker again(rest, 2, &bar);
  ASSERT_LT(again.bounds_W().size().x, 21);
  view.BeginBone(bar.materials(), again.origin_W(), again.drawn_bounds_W(), bar.voxel_mm());
  for (int x = -101; x <= 101; ++x) {  // leaves of 2 mm
    for (int y = -3; y <= 3; ++y) {
      for (int z = -6; z <= 1; ++z) {
        LeafMessage leaf{.index = {x, y, z}};
        GetCut(bar, leaf.index, leaf.values);
        again.Offer(leaf);
      }
    }
  }
  Upload(view, again);
  view.camera().set_target_W({195, 0, 0});
  const Image with = Draw();
  view.set_bone_hidden(true);
  // The bar's last 37 mm lie in the picture: 32 to the left of its middle, 5 to the right.
  EXPECT_NEAR(Compare(with, Draw()).count * kMmPerPixel * kMmPerPixel, 37 * 10, 84 * kMmPerPixel);
}

TEST_F(OnePlate, DiscIsDrawnAtItsProjection) {
  view.set_bone_hidden(true);
  const Image without = Draw();
  DiscSaw saw;
  saw.diameter_mm = 12;
  view.SetTool(saw);
  for (const double rpm : {0.0, 7500.0}) {
    for (const Vec3& p_W : {Vec3{0, 0, 5}, Vec3{-14, 6, 2}, Vec3{12, -9, 8}}) {
      view.SetToolPose({{1, 0, 0, 0}, p_W}, rpm, 0.4);
      const Difference d = Compare(Draw(), without);
      const auto at = view.camera().Project(p_W);
      ASSERT_TRUE(at);
      // At rest the area is that of the circle without half of its gullets, which are at most a tenth of the radius
      // deep. When the saw turns, it is that of the whole circle.
      const double area = std::numbers::pi * 36 / (kMmPerPixel * kMmPerPixel);
      // The outline is drawn over the rim, 0.8 points to each side with smooth edges of half a pixel.
      EXPECT_LT(d.count, area + 1.3 * 2 * std::numbers::pi * 6 / kMmPerPixel);
      EXPECT_GT(d.count, (rpm > 0 ? 0.97 : 0.8) * area);
      EXPECT_NEAR(d.x, at->x, 1.5);
      EXPECT_NEAR(d.y, at->y, 1.5);
    }
  }
  view.ClearTool();
  EXPECT_EQ(Compare(Draw(), without).count, 0);
}

TEST_F(OnePlate, BladeIsDrawnWhereItsStrokeHasIt) {
  view.set_bone_hidden(true);
  const Image without = Draw();
  const ReciprocatingBlade blade{.length_mm = 12, .width_mm = 4, .stroke_mm = 6};
  view.SetTool(blade);
  const Pose X_WT{{1, 0, 0, 0}, {2, 1, 5}};
  const auto centre = view.camera().Project(X_WT.Point({-2, 0, 0}));
  ASSERT_TRUE(centre);
  const auto draw = [&](double rpm, double displacement_mm) {
    view.SetToolPose(X_WT, rpm, 0, displacement_mm);
    return Compare(Draw(), without);
  };
  const Difference middle = draw(60, 0), ahead = draw(60, 2.5);
  EXPECT_NEAR(std::abs(ahead.y - middle.y), 2.5 / kMmPerPixel, 1);
  EXPECT_NEAR(middle.x, ahead.x, 1);
  // A fast stroke shows all that it passes, at any displacement.
  for (const double displacement_mm : {-3.0, 0.0, 3.0}) {
    const Difference passed = draw(15000, displacement_mm);
    EXPECT_NEAR(passed.count * kMmPerPixel * kMmPerPixel, 18 * 4, 0.1 * 18 * 4);
    EXPECT_NEAR(passed.x, centre->x, 2);
    EXPECT_NEAR(passed.y, centre->y, 2);
  }
  EXPECT_LT(middle.count * kMmPerPixel * kMmPerPixel, 12 * 4 * 1.1);
  const ScreenBox box = view.CalcToolBox();
  EXPECT_NEAR(box.width * kMmPerPixel, 4, 0.01);
  EXPECT_NEAR(box.height * kMmPerPixel, 18, 0.01);
  EXPECT_TRUE(view.IsOnTool(*view.camera().Project({1, 9, 5})));
  EXPECT_FALSE(view.IsOnTool(*view.camera().Project({3, 0, 5})));
}

TEST_F(OnePlate, CutShowsTheExposedTissues) {
  Leave(Draw(), "plate");
  EXPECT_TRUE(view.legend().empty());
  DiscSaw saw;
  saw.thickness_mm = 3;
  SimulationParams params;
  params.tool = saw;
  Pose start{{std::sqrt(0.5), 0, std::sqrt(0.5), 0}, {0, 0, 15}};
  Simulation simulation(bone, params, start);
  for (int i = 1; i <= 120; ++i) {
    TickInput in;
    in.X_WT = start;
    in.X_WT.p_AB.z -= 0.1 * i;
    simulation.Tick(in);
  }
  LeafMessage message;
  for (int i = 0; i < simulation.changed_count(); ++i) {
    message.index = simulation.changed(i).index;
    std::copy_n(simulation.changed(i).cut, 512, message.values.begin());
    worker.Offer(message);
  }
  Upload(view, worker);
  view.camera().Look({0.9, -0.2, 0.7}, {0, 0, 1});
  const Image image = Draw();
  Leave(image, "cut");
  // The lower part of the kerf's far wall is cancellous, which is redder than any uncut bone.
  std::size_t cancellous = 0;
  for (const Rgb8& c : image.pixels) cancellous += c[0] > c[2] + 60 && c[0] > 1.35 * c[1] ? 1 : 0;
  EXPECT_GT(cancellous, 100u);
  const auto legend = view.legend();
  ASSERT_EQ(legend.size(), 2u);
  EXPECT_EQ(legend[0].text, "cortical");
  EXPECT_EQ(legend[1].text, "cancellous");
}

TEST_F(OnePlate, CanalIsVisibleThroughTranslucentBone) {
  InnerSurfaces inner;
  inner.canal_W = *test::MakeCube({0, 0, -5}, 2);
  view.SetInnerSurfaces(inner);
  const auto most_purple = [](const Image& image) {
    int most = -255;
    for (const Rgb8& c : image.pixels) most = std::max(most, std::min(c[0], c[2]) - c[1]);
    return most;
  };
  const int solid = most_purple(Draw());
  view.set_translucent(true);
  const Image through = Draw();
  EXPECT_GT(most_purple(through), solid + 40);
  view.set_translucent(false);
  EXPECT_EQ(most_purple(Draw()), solid);
}

TEST_F(OnePlate, RegionsAreColouredOnDemandWithoutNewMeshes) {
  view.set_colour_by(ColourBy::kRegion);
  const Image image = Draw();
  const Rgb8& middle = image.At(kWidth / 2, kHeight / 2);
  const Rgb8 colour = RegionColour(24);
  // The bone is lit from the front; the hue does not depend on the light.
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (colour[i] > colour[j] + 20) {
        EXPECT_GT(middle[i], middle[j]);
      }
    }
  }
  EXPECT_EQ(view.legend().size(), 2u);
  view.set_colour_by(ColourBy::kPlain);
  EXPECT_TRUE(view.legend().empty());
}

TEST_F(OnePlate, PiecesAreDrawnWhereTheyAre) {
  PieceShape piece;
  piece.id = 7;
  piece.mesh_W = test::MakeCube({0, 0, 0}, 4);
  piece.X_WP.p_AB = {10, 3, 6};
  const Image before = Draw();
  view.SetPieces({piece});
  const Image with = Draw();
  const Difference d = Compare(with, before);
  EXPECT_NEAR(d.count * kMmPerPixel * kMmPerPixel, 16, 16 * kMmPerPixel);
  const Ray ray = view.camera().CalcRay({d.x, d.y});  // through the middle of the piece's upper face
  const Vec3 on_face = ray.origin_W + (8 - ray.origin_W.z) / ray.direction_W.z * ray.direction_W;
  EXPECT_NEAR(glm::length(on_face - Vec3(10, 3, 8)), 0, 0.15);
  piece.selected = true;
  view.SetPieces({piece});
  EXPECT_GT(Compare(Draw(), with).count, 0.9 * d.count);
  piece.hidden = true;
  view.SetPieces({piece});
  EXPECT_EQ(Compare(Draw(), before).count, 0);
  const auto on_bone = worker.Pick(view.camera().CalcRay({0.5 * kWidth, 0.5 * kHeight}));
  ASSERT_TRUE(on_bone);
  EXPECT_NEAR(on_bone->z, 0, 1e-3);
}

TEST_F(OnePlate, ThePictureDoesNotChangeWhenNothingDoes) {
  const Image once = Draw();
  EXPECT_EQ(Compare(Draw(), once).count, 0);
  view.Resize(0, 0, 1);  // minimised
  EXPECT_EQ(Compare(Draw(), once).count, 0);
  EXPECT_THROW(view.Resize(800, 500, 0.5), Error);
  view.Resize(800, 500, 1);
  EXPECT_EQ(Draw().width, 800);
  view.Resize(kWidth, kHeight, 1);
  EXPECT_EQ(Compare(Draw(), once).count, 0);
}

// A disc on the plate, seen from above: the handle lies between the eye and the disc.
TEST_F(OnePlate, HandpieceNeverHidesTheCut) {
  const Vec3 contact{0, -4.5, 0};
  const auto at = view.camera().Project(contact);
  ASSERT_TRUE(at);
  const auto seen = [&] { return Draw().At(static_cast<int>(at->x), static_cast<int>(at->y)); };
  const auto difference = [](const Rgb8& a, const Rgb8& b) {
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  };
  const Rgb8 bone_there = seen();
  view.SetTool(DiscSaw{.diameter_mm = 12});
  view.SetToolPose({glm::angleAxis(0.12, Vec3{1, 0, 0}), {0, 0, 0.2}}, 7500, 0);
  const Image without = Draw();
  view.set_show_handpiece(true);
  const Image with = Draw();
  Leave(with, "handpiece");
  EXPECT_GT(Compare(without, with).count, 2000);
  const Rgb8 covered = seen();
  view.SetContact(contact);
  Leave(Draw(), "handpiece_contact");
  // With a contact, the pixel is nearer to that of bone than to that of the tool.
  EXPECT_LT(difference(seen(), bone_there), 0.5 * difference(covered, bone_there));
}

TEST_F(OnePlate, AHandpieceInTheBoneIsTranslucent) {
  const Image without = Draw();
  view.SetTool(DiscSaw{.diameter_mm = 12});
  view.SetToolPose({glm::angleAxis(0.12, Vec3{1, 0, 0}), {0, 0, 0.2}}, 7500, 0);
  view.set_show_handpiece(true);
  const auto sum = [&without](const Image& image) {
    double difference = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) difference += std::abs(image.pixels[i][c] - without.pixels[i][c]);
    }
    return difference;
  };
  const double opaque = sum(Draw());
  view.SetHandpieceInBone(true);
  const Image ghostly = Draw();
  Leave(ghostly, "handpiece_in_bone");
  EXPECT_LT(sum(ghostly), 0.8 * opaque);  // the disc is as before
  view.SetHandpieceInBone(false);
  EXPECT_EQ(sum(Draw()), opaque);
}

TEST_F(OnePlate, HiddenPointsAreWeakerButVisible) {
  const Image plain = Draw();
  const auto strength = [&](const Vec3& p_W) {
    view.SetPoints({{.p_W = p_W, .kind = PointKind::kPlan}});
    const Image with = Draw();
    const auto at = view.camera().Project(p_W);
    const Rgb8& a = with.At(static_cast<int>(at->x), static_cast<int>(at->y));
    const Rgb8& b = plain.At(static_cast<int>(at->x), static_cast<int>(at->y));
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  };
  const double front = strength({2, 1, 1});
  const double behind = strength({2, 1, -4});
  EXPECT_GT(behind, 40);
  EXPECT_GT(front, 1.5 * behind);
  view.SetPoints({});
  EXPECT_EQ(Compare(Draw(), plain).count, 0);
}

TEST_F(OnePlate, OnTheBladeOnlyTheSymbolOfAHandleIsFound) {
  view.SetTool(DiscSaw{});
  view.SetToolPose({{1, 0, 0, 0}, {0, 0, 5}}, 0, 0);
  const ScreenPoint at = *view.camera().Project({0, 0, 5});
  const ScreenPoint rim = *view.camera().Project({DiscSaw{}.diameter_mm / 2, 0, 5});
  EXPECT_TRUE(view.IsOnTool(at));
  EXPECT_TRUE(view.IsOnTool({rim.x + 0.1 * (at.x - rim.x), rim.y + 0.1 * (at.y - rim.y)}));
  EXPECT_FALSE(view.IsOnTool({rim.x - 0.1 * (at.x - rim.x), rim.y - 0.1 * (at.y - rim.y)}));
  view.SetPlaneHandles({{{0, 0, 5}, HandleKind::kMove, false}});
  EXPECT_EQ(view.PickHandle({at.x + 6, at.y}), std::optional<int>(0));
  EXPECT_FALSE(view.PickHandle({at.x + 12, at.y})) << "the blade is meant";
  view.ClearTool();
  EXPECT_FALSE(view.IsOnTool(at));
  EXPECT_EQ(view.PickHandle({at.x + 12, at.y}), std::optional<int>(0));
}

TEST_F(OnePlate, ABurIsFoundOnItsHeadOnly) {
  const FissureBur bur;
  view.SetTool(bur);
  // It lies along x with its tip at x = -2.
  view.SetToolPose({glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0)), {-2, 0, 5}}, 0, 0);
  const auto is_on = [&](double x, double y) { return view.IsOnTool(*view.camera().Project({x, y, 5})); };
  EXPECT_TRUE(is_on(2, 0) && is_on(2, 0.8 * bur.radius_mm()) && is_on(-1.8, -0.8 * bur.radius_mm()));
  EXPECT_FALSE(is_on(2, 1.3 * bur.radius_mm()) || is_on(2, -1.3 * bur.radius_mm()));
  EXPECT_FALSE(is_on(-2.3, 0) || is_on(bur.length_mm - 1.7, 0));
  const ScreenBox box = view.CalcToolBox();
  EXPECT_NEAR(box.width * kMmPerPixel, bur.length_mm, 0.01);
  EXPECT_NEAR(box.height * kMmPerPixel, bur.diameter_mm, 0.05);
}

TEST_F(OnePlate, PointsAndHandlesAreFoundWhereTheyAreDrawn) {
  const Vec3 a{-5, 2, 0};
  const Vec3 b{5, -2, -6};
  view.SetPoints({{.p_W = a, .kind = PointKind::kPlan, .label = "1"}, {.p_W = b, .kind = PointKind::kMark}});
  view.SetPlaneHandles({{a, HandleKind::kMove, false}, {b, HandleKind::kSize, true}});
  for (const bool parallel : {true, false}) {
    view.camera().set_parallel(parallel);
    const auto pa = view.camera().Project(a);
    const auto pb = view.camera().Project(b);
    EXPECT_EQ(view.PickPoint({pa->x + 3, pa->y - 4}, 5.01), std::optional<int>(0));
    EXPECT_FALSE(view.PickPoint({pa->x + 3, pa->y - 4}, 4.99));
    EXPECT_EQ(view.PickPoint(*pb, 8), std::optional<int>(1));
    EXPECT_EQ(view.PickHandle({pb->x + 2, pb->y}), std::optional<int>(1));
    EXPECT_FALSE(view.PickHandle({pb->x + 60, pb->y}));
  }
  // Nearest first; of two at the same place, the later one.
  view.SetPoints({{.p_W = a}, {.p_W = a}, {.p_W = b}});
  EXPECT_EQ(view.PickPoint(*view.camera().Project(a), 8), std::optional<int>(1));
  view.SetPoints({});
  EXPECT_FALSE(view.PickPoint(*view.camera().Project(a), 800));
}

TEST_F(OnePlate, RimIsDashedWhereBoneHidesIt) {
  // An upright disc, seen from the side through the plate: its lower part is in the bone.
  view.camera().Look(View::kFront);
  view.SetTool(DiscSaw{.diameter_mm = 16, .thickness_mm = 0.4});
  view.SetToolPose({glm::angleAxis(std::numbers::pi / 2, Vec3{1, 0, 0}), {0, 0, 1}}, 0, 0);
  const Image image = Draw();
  Leave(image, "rim");
  // Along the hidden lower half of the circle, dark dashes alternate with light gaps.
  int dark = 0, light = 0, changes = 0;
  bool last = false;
  for (int i = 0; i < 400; ++i) {
    const double angle = std::numbers::pi * (1.2 + 0.6 * i / 400.0);
    const auto at = view.camera().Project({8 * std::cos(angle), 0, 1 + 8 * std::sin(angle)});
    const Rgb8& c = image.At(static_cast<int>(at->x), static_cast<int>(at->y));
    const bool is_dark = c[0] + c[1] + c[2] < 330;
    (is_dark ? dark : light) += 1;
    changes += is_dark != last ? 1 : 0;
    last = is_dark;
  }
  EXPECT_GT(dark, 80);
  EXPECT_GT(light, 80);
  EXPECT_GT(changes, 8);
}

TEST_F(OnePlate, MarkIsSolidInTranslucentBoneAndHiddenInSolidBone) {
  const MarkOverlay mark{{{-6, 0, -5}, {6, 0, -5}}, 1.2, {0, 114, 178}, "nerve", false};
  const Image plain = Draw();
  view.SetMarks({mark});
  // Only the label differs, which is drawn beside the mark's first point.
  const auto at = view.camera().Project({2, 0, -5});
  const auto pixel = [&](const Image& image) { return image.At(static_cast<int>(at->x), static_cast<int>(at->y)); };
  EXPECT_EQ(pixel(Draw()), pixel(plain));
  view.set_translucent(true);
  const Rgb8 seen = pixel(Draw());
  EXPECT_GT(seen[2], seen[0] + 40);
  view.set_translucent(false);
  view.SetMarks({});
  EXPECT_EQ(Compare(Draw(), plain).count, 0);
}

TEST_F(OnePlate, DustIsDrawnAndCanBeSwitchedOff) {
  const Image plain = Draw();
  view.AddDust({0, 0, 1}, {0, 60, 60}, 3);
  view.AdvanceDust(0.05);
  const Image dusty = Draw();
  Leave(dusty, "dust");
  EXPECT_GT(Compare(dusty, plain).count, 100);
  view.set_show_dust(false);
  EXPECT_EQ(Compare(Draw(), plain).count, 0);
  view.AddDust({0, 0, 1}, {0, 60, 60}, 3);
  EXPECT_EQ(Compare(Draw(), plain).count, 0);
}

TEST_F(OnePlate, SceneIsFittedBesideThePanelsOfTheWindow) {
  view.SetAreas({300, 60, kWidth - 300, kHeight - 60}, {});
  view.camera().Look(View::kTop);
  view.FitAll();
  const Image with = Draw();
  view.set_bone_hidden(true);
  const Image without = Draw();
  int inside = 0, outside = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      if (with.At(column, row) == without.At(column, row)) continue;
      (column >= 300 && row >= 60 ? inside : outside) += 1;
    }
  }
  EXPECT_GT(inside, 20000);
  EXPECT_EQ(outside, 0);
}

TEST_F(OnePlate, ThemeChangesTheBackgroundOnly) {
  const auto corner = [&] { return Draw().At(5, 5); };
  const Rgb8 light = corner();
  view.set_theme(Theme::kDark);
  const Rgb8 dark = corner();
  EXPECT_LT(dark[0] + 60, light[0]);
  EXPECT_EQ(view.theme(), Theme::kDark);
  view.set_theme(Theme::kLight);
  EXPECT_EQ(corner(), light);
}

// All overlays at once, for inspection.
TEST_F(OnePlate, AllOverlaysAtOnce) {
  view.Resize(1280, 720, 1);
  view.SetAreas({240, 40, 1040, 680}, {1160, 600, 110, 110});
  view.set_show_handpiece(true);
  view.SetTool(DiscSaw{});
  const Pose X_WT{{std::sqrt(0.5), 0, std::sqrt(0.5), 0}, {1, 0, 8}};
  view.SetToolPose(X_WT, 7500, 0);
  view.SetContact(Vec3{1, 0, -3});
  view.SetForce(ForceArrow{{1, 0, -3}, {0, 0.5, 12}, ""});
  PlaneOverlay plane{"plane 1", {-4, 0, -5}, {1, 0.1, 0}, 24, 24, {0, 0, 1}, {0, 114, 178}, true};
  view.SetPlanes({plane});
  view.SetPlaneLines({{CalcSectionLines(bone, plane, 0.25), plane.colour, true}});
  view.SetPlaneHandles({{plane.p_W + Vec3{0, 0, 12}, HandleKind::kTilt, false},
                        {plane.p_W, HandleKind::kMove, true},
                        {plane.p_W + Vec3{0, 12, 12}, HandleKind::kSize, false}});
  view.SetPoints({{{-6, -4, 0}, PointKind::kPlan, "1", false},
                  {{-6, 4, 0}, PointKind::kMark, "2", true},
                  {{6, 2, -9}, PointKind::kMeasure, "3", false}});
  view.SetBridges({{{{3, -2, -8}, {3, 2, -8}, {3, 2, -5}, {3, -2, -5}}, {}, {3, 0, -6.5}, "still holds: 12 mm\u00b2"}});
  view.SetMarks({{{{-8, 3, -6}, {0, 2, -6}, {8, 3, -7}}, 0.8, {0, 114, 178}, "nerve", true}});
  view.SetAlarms({{{1, 2, -3}, AlarmLevel::kDanger, "nerve: 0.6 mm"}});
  view.AddDust({1, 0, -2}, {0, 80, 30}, 5);
  view.AdvanceDust(0.15);
  view.camera().set_parallel(false);
  view.camera().Look(View::kThreeQuarter);
  view.FitAll();
  view.camera().set_height_mm(45);
  Leave(Draw(), "overlays_light");
  view.set_translucent(true);
  view.set_theme(Theme::kDark);
  view.SetAlarms({{{1, 2, -3}, AlarmLevel::kWarning, "nerve: 1.6 mm"}});
  Leave(Draw(), "overlays_dark");
  view.Resize(2560, 1440, 2);
  const Image fine = Draw();
  Leave(fine, "overlays_2x");
  EXPECT_EQ(fine.width, 2560);
}

// All contents are shown at once, at both sizes that are supported, for inspection and to check that nothing throws.
TEST_F(OnePlate, EverythingAtOnce) {
  SetHu(
      bone, [](const Vec3& p) { return p.z > -4 ? 1500 : 250 + 60 * std::sin(3 * p.x) * std::cos(2 * p.y + p.z); },
      0.25);
  view.SetTool(DiscSaw{});
  const Pose X_WT{{std::sqrt(0.5), 0, std::sqrt(0.5), 0}, {1, 0, 8}};
  view.SetToolPose(X_WT, 7500, 0);
  view.SetGhost(Pose{X_WT.R_AB, {1, 0, 6}});
  view.SetForce(ForceArrow{{1, 0, -3}, {0, 0.5, 2}});
  view.SetPlanes({{"plane 1", {1, 0, -5}, {1, 0.1, 0}, 24, 24, {0, 0, 1}, {0, 114, 178}, true},
                  {"plane 2", {-5, 0, -5}, {1, 0, 0}, 24, 24, {0, 0, 1}, {204, 121, 167}, false}});
  view.SetDepthStops({{"stop at 6 mm", {1, 0, -6}, {0, 0, 1}, 14, true}});
  view.SetGuides({{{{-8, 3, 0}, {-2, 3, 0}, {4, 2, 0}, {8, 0, 0}}}});
  view.SetMeasures({{{{-8, -5, 0}, {8, -5, 0}}, "16.0 mm"}, {{{8, -5, 0}, {8, 5, 0}, {8, 5, -10}}, "90.0 deg"}});
  view.camera().set_parallel(false);
  view.camera().Look(View::kThreeQuarter);
  view.camera().set_height_mm(50);
  struct Size {
    int width, height;
    double scale;
    const char* name;
  };
  for (const Size& size : {Size{1280, 720, 1, "1x"}, Size{2560, 1440, 2, "2x"}}) {
    view.Resize(size.width, size.height, size.scale);
    view.SetAreas({0, 0, 1.0 * size.width, 1.0 * size.height}, {0.0, 0.0, 100 * size.scale, 100 * size.scale});
    const Image image = Draw();
    EXPECT_EQ(image.width, size.width);
    Leave(image, std::string("all_") + size.name);
    view.set_smooth_edges(true);
    const Image smooth = Draw();
    Leave(smooth, std::string("smooth_") + size.name);
    // Only edges change, so most pixels are equal.
    EXPECT_GT(Compare(smooth, image).count, 100);
    EXPECT_LT(Compare(smooth, image).count, 0.1 * size.width * size.height);
    view.set_smooth_edges(false);
  }
}

}  // namespace
}  // namespace kerf
