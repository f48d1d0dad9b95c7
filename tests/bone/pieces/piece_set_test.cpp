#include "bone/pieces/piece_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "bone/grid/grids.h"
#include "bone/pieces/measure.h"
#include "kerf/error.h"
#include "support/folder.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Makes a bar along x, 12 x 4 x 4 mm, without the bone within 0.3 mm of x = -2 and of x = 3, which leaves pieces of
/// 3.7, 4.4 and 2.7 mm.
Bone MakeCutBar() {
  Bone bar = test::MakeBox({}, {12, 4, 4}, 0.2);
  openvdb::FloatGrid& grid = *GridsOf(bar).phi;
  auto values = grid.getAccessor();
  for (int x = -35; x <= 35; ++x) {
    for (int y = -15; y <= 15; ++y) {
      for (int z = -15; z <= 15; ++z) {
        const double off = std::min(std::abs(0.2 * x + 2), std::abs(0.2 * x - 3)) - 0.3;
        const openvdb::Coord at(x, y, z);
        // The value is copied, because setting a value replaces the tile to which a reference would point.
        const float cut = std::max(float{values.getValue(at)}, static_cast<float>(std::min(-off, bar.band_mm())));
        values.setValue(at, cut);
      }
    }
  }
  FinishLevelSet(grid);
  return bar;
}

struct PieceDraw {
  explicit PieceDraw(unsigned seed) : random(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  int Below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }
  Vec3 Vector(double reach) { return {In(-reach, reach), In(-reach, reach), In(-reach, reach)}; }
  std::mt19937 random;
};

void ExpectSame(const Pose& a, const Pose& b, double mm = 1e-9) {
  EXPECT_LT(glm::length(a.p_AB - b.p_AB), mm);
  EXPECT_NEAR(std::abs(glm::dot(a.R_AB, b.R_AB)), 1, 1e-12);
}

TEST(PieceSet, ContainsThePiecesOfTheBoneLargestFirst) {
  const PieceSet set(MakeCutBar());
  ASSERT_EQ(set.size(), 3);
  EXPECT_EQ(set.piece(0).name, "piece 1");
  EXPECT_NEAR(set.piece(0).volume_mm3, 4.4 * 16, 1);
  EXPECT_NEAR(set.piece(1).volume_mm3, 3.7 * 16, 1);
  EXPECT_NEAR(set.piece(2).volume_mm3, 2.7 * 16, 1);
  EXPECT_NEAR(glm::length(set.CalcCentroid(0) - Vec3(0.5, 0, 0)), 0, 0.02);
  EXPECT_NEAR(glm::length(set.CalcCentroid(2) - Vec3(4.65, 0, 0)), 0, 0.02);
  EXPECT_EQ(set.Find("piece 2"), 1);
  EXPECT_EQ(set.Find("piece 9"), -1);
}

TEST(PieceSet, PiecesArePickedAtTheirCurrentPose) {
  PieceSet set(MakeCutBar());
  const auto pick = set.Pick({0.5, 0, 20}, {0, 0, -2});
  ASSERT_TRUE(pick);
  EXPECT_EQ(pick->piece, 0);
  EXPECT_NEAR(pick->p_W_mm.z, 2, 0.02);
  EXPECT_NEAR(pick->distance_mm, 18, 0.02);
  EXPECT_FALSE(set.Pick({0.5, 5, 20}, {0, 0, -1}));
  set.Move(2, {-4.15, 0, 10});  // above the first piece
  EXPECT_EQ(set.Pick({0.5, 0, 20}, {0, 0, -1})->piece, 2);
  EXPECT_NEAR(set.Pick({0.5, 0, 20}, {0, 0, -1})->p_W_mm.z, 12, 0.02);
  set.SetHidden(2, true);
  EXPECT_EQ(set.Pick({0.5, 0, 20}, {0, 0, -1})->piece, 0);
  set.Delete(0);
  EXPECT_FALSE(set.Pick({0.5, 0, 20}, {0, 0, -1}));
  // After a quarter turn about its middle, the bar's first piece stands upright.
  set.Undo();
  set.Rotate(0, {0.5, 0, 0}, glm::angleAxis(1.5707963267948966, Vec3(0, 1, 0)));
  EXPECT_NEAR(set.Pick({0.5, 0, 20}, {0, 0, -1})->p_W_mm.z, 2.2, 0.03);
}

TEST(PieceSet, MotionsHaveTheStatedEffect) {
  PieceSet set(MakeCutBar());
  set.MoveAlong(0, {0, 0, 5}, 3);
  ExpectSame(set.state(0).X_WP, {Quat(1, 0, 0, 0), {0, 0, 3}});
  const Vec3 p(1, 2, 3);
  const Vec3 axis(0, 2, 0);
  const Vec3 before = set.CalcCentroid(0);
  set.RotateAbout(0, p, axis, 90);
  // A quarter turn about y maps z to x and x to -z.
  const Vec3 arm = before - p;
  EXPECT_LT(glm::length(set.CalcCentroid(0) - (p + Vec3(arm.z, arm.y, -arm.x))), 1e-9);
  EXPECT_NEAR(CalcRotationAngle(set.state(0).X_WP), 90, 1e-9);
  set.Reset(0);
  ExpectSame(set.state(0).X_WP, Pose{});
  set.Place(1, {Quat(0, 1, 0, 0), {1, 1, 1}});
  ExpectSame(set.state(1).X_WP, {Quat(0, 1, 0, 0), {1, 1, 1}});
  EXPECT_THAT(MessageOf([&] { set.MoveAlong(0, {0, 0, 0}, 3); }), HasSubstr("no direction"));
  EXPECT_THAT(MessageOf([&] { set.Move(0, {0, std::nan(""), 0}); }), HasSubstr("can't be moved there"));
  EXPECT_THAT(MessageOf([&] { set.Move(7, {0, 0, 0}); }), HasSubstr("no piece 7"));
  set.Delete(1);
  EXPECT_THAT(MessageOf([&] { set.Move(1, {0, 0, 1}); }), HasSubstr("piece 2 is deleted"));
}

/// All actions can be undone and redone bit for bit.
TEST(PieceSet, EverythingIsUndoneAndDoneAgain) {
  PieceSet set(MakeCutBar());
  PieceDraw draw(1);
  std::vector<std::vector<PieceState>> states;
  const auto now = [&] {
    std::vector<PieceState> all;
    for (int i = 0; i < set.size(); ++i) all.push_back(set.state(i));
    return all;
  };
  states.push_back(now());
  for (int k = 0; k < 200; ++k) {
    const int i = draw.Below(3);
    if (set.state(i).deleted) continue;
    switch (draw.Below(9)) {
      case 0:
        set.SetHidden(i, !set.state(i).hidden);
        break;
      case 1:
        set.Move(i, draw.Vector(5));
        break;
      case 2:
        set.Rotate(i, draw.Vector(5), glm::angleAxis(draw.In(-3, 3), glm::normalize(draw.Vector(1))));
        break;
      case 3:
        set.MoveAlong(i, draw.Vector(5), draw.In(-5, 5));
        break;
      case 4:
        set.RotateAbout(i, draw.Vector(5), draw.Vector(5), draw.In(-180, 180));
        break;
      case 5:
        set.Reset(i);
        break;
      case 6:
        set.Checkpoint("here");
        break;
      case 7:
        set.GoTo("here");
        break;
      case 8:
        if (k % 50 == 0) set.Delete(i);
        if (k % 50 == 1) set.ResetAll();
        break;
    }
    if (now() != states.back()) states.push_back(now());
  }
  ASSERT_GT(states.size(), 50u);
  EXPECT_EQ(set.actions().size(), states.size() - 1);
  for (std::size_t k = states.size() - 1; k > 0; --k) {
    EXPECT_EQ(now(), states[k]);
    ASSERT_TRUE(set.Undo());
  }
  EXPECT_EQ(now(), states[0]);
  EXPECT_FALSE(set.Undo());
  for (std::size_t k = 1; k < states.size(); ++k) {
    ASSERT_TRUE(set.Redo());
    EXPECT_EQ(now(), states[k]);
  }
  EXPECT_FALSE(set.Redo());
  set.Undo();
  set.SetHidden(0, !set.state(0).hidden);  // after a new action, the undone one can no longer be redone
  EXPECT_FALSE(set.Redo());
}

TEST(PieceSet, AGestureIsOneStep) {
  PieceSet set(MakeCutBar());
  for (int k = 0; k < 10; ++k) set.Move(0, {0.1, 0, 0}, 7);
  set.Move(0, {0, 1, 0}, 8);
  EXPECT_EQ(set.actions().size(), 2u);
  EXPECT_NEAR(set.actions()[0].X_WW.p_AB.x, 1, 1e-12);
  EXPECT_EQ(set.actions()[1].what, "move");
  EXPECT_EQ(set.actions()[1].piece, "piece 1");
  set.Undo();
  ExpectSame(set.state(0).X_WP, {Quat(1, 0, 0, 0), {1, 0, 0}});
  set.Undo();
  ExpectSame(set.state(0).X_WP, {});
  // An action that changes nothing is not recorded.
  set.Move(0, {0, 0, 0});
  set.SetHidden(0, false);
  EXPECT_EQ(set.actions().size(), 0u);
}

TEST(PieceSet, OverlapAndGapFollowTheMotion) {
  PieceSet set(MakeCutBar());
  std::vector<PieceContact> contacts = set.CalcContacts(0);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_EQ(contacts[0].other, 1);
  EXPECT_EQ(contacts[0].overlap_mm3, 0);
  EXPECT_NEAR(contacts[0].gap->gap_mm, 0.6, 0.02);
  // The neighbour moves along the bar by 1 mm: it overlaps by 0.4 mm over 4 x 4 mm, less h^2 / 10 along its 33.6 mm of
  // edges, with h the voxel size.
  set.MoveAlong(1, {1, 0, 0}, 1);
  contacts = set.CalcContacts(0);
  EXPECT_NEAR(contacts[0].overlap_mm3, 0.4 * 16, 0.02 * 0.4 * 16 + 0.14);
  EXPECT_EQ(contacts[0].gap->gap_mm, 0);
  EXPECT_NEAR(set.CalcContacts(1)[0].overlap_mm3, contacts[0].overlap_mm3, 1e-3 * contacts[0].overlap_mm3);
  set.Delete(1);
  EXPECT_EQ(set.CalcContacts(0).size(), 1u);
  const Facing facing = set.CalcFacingTo(0, 2);
  EXPECT_NEAR(facing.mean_mm, 0.6, 0.03);
  EXPECT_NEAR(facing.area_mm2, 16, 0.2 * 16);
}

TEST(PieceSet, PieceThatIsCutFurtherKeepsItsPose) {
  const Bone whole = test::MakeBox({}, {12, 4, 4}, 0.2);
  PieceSet set(whole);
  ASSERT_EQ(set.size(), 1);
  set.Move(0, {0, 10, 0});
  set.Checkpoint("moved");
  const std::vector<int> parts = set.Recut(0, MakeCutBar());
  EXPECT_THAT(parts, ElementsAre(0, 1, 2));
  EXPECT_NEAR(set.piece(0).volume_mm3, 4.4 * 16, 1);
  for (const int i : parts) ExpectSame(set.state(i).X_WP, {Quat(1, 0, 0, 0), {0, 10, 0}});
  EXPECT_EQ(set.Pick({0.5, 10, 20}, {0, 0, -1})->piece, 0);
  EXPECT_FALSE(set.Pick({-2, 10, 20}, {0, 0, -1}));  // the ray passes through the kerf
  set.Undo();
  for (const int i : parts) ExpectSame(set.state(i).X_WP, {});
  EXPECT_EQ(set.Add(test::MakeSphere({0, 0, 20}, 2, 0.2)), 3);
  EXPECT_EQ(set.piece(3).name, "piece 4");
  EXPECT_TRUE(set.Redo());
  ExpectSame(set.state(3).X_WP, {});
}

TEST(PieceSet, FileRoundTripKeepsTheStates) {
  PieceSet set(MakeCutBar());
  set.RotateAbout(0, {1, 2, 3}, {1, 1, 0}, 33);
  set.Checkpoint("one \"<turned>\"");
  set.MoveAlong(2, {1, 0, 0}, 4);
  set.SetHidden(1, true);
  set.Delete(2);
  const std::string text = set.FormatJson();
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["frame"], "LPS");
  EXPECT_EQ(json["units"], "mm");
  ASSERT_EQ(json["actions"].size(), 4u);
  EXPECT_EQ(json["actions"][0]["what"], "rotate about");
  PieceSet other(MakeCutBar());
  other.Restore(text, "pieces.json");
  for (int i = 0; i < 3; ++i) {
    ExpectSame(other.state(i).X_WP, set.state(i).X_WP);
    EXPECT_EQ(other.state(i).hidden, set.state(i).hidden);
    EXPECT_EQ(other.state(i).deleted, set.state(i).deleted);
  }
  EXPECT_THAT(other.checkpoints(), ElementsAre("one \"<turned>\""));
  EXPECT_TRUE(other.GoTo("one \"<turned>\""));
  EXPECT_FALSE(other.state(2).deleted);
  EXPECT_TRUE(other.Undo());
  EXPECT_TRUE(other.state(2).deleted);
  EXPECT_TRUE(other.Undo());
  ExpectSame(other.state(0).X_WP, {});
}

TEST(PieceSet, InvalidFilesAreRefusedAndChangeNothing) {
  PieceSet set(MakeCutBar());
  const std::string good = set.FormatJson();
  const auto message = [&](const std::function<void(nlohmann::json&)>& change) {
    auto json = nlohmann::json::parse(good);
    change(json);
    return MessageOf([&] { set.Restore(json.dump(), "a.json"); });
  };
  EXPECT_EQ(message([](nlohmann::json&) {}), "");
  EXPECT_THAT(MessageOf([&] { set.Restore("{", "a.json"); }), HasSubstr("not valid JSON"));
  EXPECT_THAT(MessageOf([&] { set.Restore("[]", "a.json"); }), HasSubstr("not a pieces file"));
  EXPECT_THAT(message([](auto& j) { j["version"] = 9; }), HasSubstr("later version"));
  EXPECT_THAT(message([](auto& j) { j.erase("pieces"); }), HasSubstr("no list 'pieces'"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["name"] = "x"; }), HasSubstr("no x here"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["volume_mm3"] = 1; }), HasSubstr("a different volume"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["transform"][0] = 2; }), HasSubstr("not a rigid motion"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["transform"][0] = "a"; }), HasSubstr("not a list of 16 numbers"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["transform"][3] = 1e9; }), HasSubstr("out of the world"));
  EXPECT_THAT(message([](auto& j) { j["pieces"][0]["hidden"] = 1; }), HasSubstr("neither true nor false"));
  EXPECT_THAT(message([](auto& j) { j["checkpoints"] = {{{"name", 3}}}; }), HasSubstr("checkpoint has no name"));
  EXPECT_FALSE(set.Undo());
}

TEST(ConstrainToAxis, MotionStaysOnTheAxis) {
  PieceDraw draw(3);
  for (int k = 0; k < 100; ++k) {
    const Vec3 p = draw.Vector(10);
    const Vec3 axis = draw.Vector(3);
    const Pose free{glm::angleAxis(draw.In(-3, 3), glm::normalize(draw.Vector(1))), draw.Vector(10)};
    const Pose held = ConstrainToAxis(free, p, axis);
    // A point of the axis stays on the axis and moves along it as far as in the free motion.
    const Vec3 n = glm::normalize(axis);
    const Vec3 motion = held.Point(p) - p;
    EXPECT_LT(glm::length(motion - glm::dot(n, free.Point(p) - p) * n), 1e-9);
    EXPECT_LT(glm::length(held.Vector(n) - n), 1e-9);
    // A motion that already satisfies the constraint is left unchanged.
    ExpectSame(ConstrainToAxis(held, p, axis), held);
  }
}

TEST(Measure, DistancesAndAngles) {
  EXPECT_NEAR(CalcDistance(Vec3(1, 2, 3), Vec3(4, 6, 3)), 5, 1e-12);
  EXPECT_NEAR(*CalcAngle(Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(0, 2, 0)), 90, 1e-12);
  EXPECT_NEAR(*CalcAngle(Vec3(2, 1, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)), 180, 1e-12);
  EXPECT_FALSE(CalcAngle(Vec3(1, 0, 0), Vec3(1, 0, 0), Vec3(0, 2, 0)));
  EXPECT_NEAR(CalcAngle(CutPlane{{}, {1, 0, 0}}, CutPlane{{}, glm::normalize(Vec3(-1, 1, 0))}), 45, 1e-12);
  EXPECT_NEAR(CalcDistance(Vec3(0, 0, 5), CutPlane{{0, 0, 1}, {0, 0, -1}}), -4, 1e-12);
}

}  // namespace
}  // namespace kerf
