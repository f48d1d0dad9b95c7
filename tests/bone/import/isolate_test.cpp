// Separation of the wanted bone from bone that it touches.
#include "bone/import/isolate.h"

#include <gmock/gmock.h>

#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "bone/import/import.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/patient_frame.h"
#include "bone/models/mandible.h"
#include "ct_files.h"
#include "kerf/surface.h"
#include "support/jaw_ct.h"

namespace kerf {
namespace {

using test::Ball;
using test::Folder;
using test::MessageOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Two balls of 10 and 13 mm radius, next to each other along a skew line, that overlap in a neck of about 4 mm radius.
const Vec3 kSmall(-9, -3, 4);
const Vec3 kLarge = kSmall + 21.4 * glm::normalize(Vec3(2, 1, -0.5));

Volume TouchingBalls() {
  const auto a = Ball(kSmall, 10);
  const auto b = Ball(kLarge, 13);
  return test::MakeCt(
      {70, 56, 48}, {1, 1, 1}, {-28, -22, -22}, glm::dmat3(1), [=](const Vec3& p) { return std::min(a(p), b(p)); },
      900);
}

IsolateOptions Steered() {
  IsolateOptions options;
  options.iso_hu = 450;
  options.check_shape = false;
  options.keep_W = {kSmall};
  options.drop_W = {kLarge};
  return options;
}

TEST(Isolate, KeepAndDropPointsSeparateTouchingBallsAtTheirNeck) {
  const double ball_mm3 = 4.0 / 3.0 * std::numbers::pi * 1000;
  const Isolation isolation = Isolate(TouchingBalls(), Steered(), {});
  // The overlap is a lens of 28 mm3, and the border is known to one voxel, which makes 50 mm2 of neck times 1 mm.
  EXPECT_NEAR(isolation.iso_volume_mm3, ball_mm3, 80);
  EXPECT_GT(isolation.contact_mm2, 20);
  EXPECT_LT(isolation.contact_mm2, 150);
  IsolateOptions other = Steered();
  std::swap(other.keep_W, other.drop_W);
  const Isolation rest = Isolate(TouchingBalls(), other, {});
  EXPECT_NEAR(rest.iso_volume_mm3, ball_mm3 * 2.197, 100);
  // No voxel is lost or assigned twice.
  IsolateOptions all = Steered();
  all.isolate = false;
  EXPECT_EQ(isolation.iso_volume_mm3 + rest.iso_volume_mm3, Isolate(TouchingBalls(), all, {}).iso_volume_mm3);
}

TEST(Isolate, ResultingBoneIsOnePieceWithASmoothCut) {
  const Folder folder;
  test::WriteNrrd(TouchingBalls(), folder.file("a.nrrd"));
  ImportOptions options;
  options.voxel_mm = 0.4;
  options.isolate = Steered();
  const ImportResult result = Import(folder.file("a.nrrd"), options);
  EXPECT_EQ(result.report.pieces, 1u);
  EXPECT_NEAR(result.report.solid_mm3, 4.0 / 3.0 * std::numbers::pi * 1000, 100);
  const Vec3 toward = glm::normalize(kLarge - kSmall);
  for (const Vec3& p : ExtractSurface(result.bone).points) {
    EXPECT_LT(glm::length(p - kSmall), 11.5);
    EXPECT_LT(glm::dot(p - kSmall, toward), 10.5);
  }
}

TEST(Isolate, APointOffTheBoneOrOffTheScanIsNamed) {
  IsolateOptions options = Steered();
  options.keep_W = {{30, 25, 20}};
  EXPECT_THAT(
      MessageOf([&] { Isolate(TouchingBalls(), options, {}); }),
      HasSubstr("--keep (30.0, 25.0, 20.0): the point is not in bone; nothing above 450 HU is within 4 mm of it"));
  options = Steered();
  options.drop_W = {{500, 0, 0}};
  EXPECT_THAT(MessageOf([&] { Isolate(TouchingBalls(), options, {}); }),
              HasSubstr("--drop (500.0, 0.0, 0.0): the point lies outside the scan"));
  options.drop_W = options.keep_W;
  EXPECT_THAT(MessageOf([&] { Isolate(TouchingBalls(), options, {}); }),
              HasSubstr("a --keep point lies at the same place"));
}

TEST(Isolate, OtherBoneIsRefusedWithAListOfWhatWasFound) {
  IsolateOptions options;
  options.iso_hu = 450;
  const std::string message = MessageOf([&] { Isolate(TouchingBalls(), options, {}); });
  EXPECT_THAT(message, HasSubstr("the mandible can't be distinguished from the other bone"));
  EXPECT_THAT(message, HasSubstr("'kerf picture INPUT --axes -o ct.png'"));
  EXPECT_THAT(message, HasSubstr("1. 13.4 cm3, centre ("));
  EXPECT_THAT(message, HasSubstr("--keep x,y,z"));
  EXPECT_THAT(message, Not(HasSubstr("points alone")));
  // One kind of point is not enough, whatever the shape may be.
  options.check_shape = false;
  options.keep_W = Steered().keep_W;
  EXPECT_THAT(MessageOf([&] { Isolate(TouchingBalls(), options, {}); }),
              HasSubstr("; --keep points alone only correct a piece that is found without them: give both"));
  options = Steered();
  options.check_shape = true;
  EXPECT_THAT(MessageOf([&] { Isolate(TouchingBalls(), options, {}); }),
              HasSubstr("does not look like a mandible: its volume of 4.16 cm3 is below 8"));
}

TEST(Isolate, AVolumeWithoutBoneIsRefused) {
  const Volume water = test::MakeCt({20, 20, 20}, {1, 1, 1}, {0, 0, 0}, glm::dmat3(1), Ball({10, 10, 10}, 8), 120);
  EXPECT_THAT(
      MessageOf([&] { Isolate(water, IsolateOptions{}, {}); }),
      HasSubstr(
          "the scan contains no bone: nothing above 300 HU is larger than 1 cm3 (the brightest voxel has 120 HU)"));
}

glm::dmat3 TurnAbout(const Vec3& axis, double degrees) {
  return glm::mat3_cast(glm::angleAxis(degrees / kDegreesPerRad, glm::normalize(axis)));
}

// The distance from a rod of radius `r` with round ends.
double Rod(const Vec3& p, const Vec3& a, const Vec3& b, double r) {
  const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
  return glm::length(p - a - t * (b - a)) - r;
}

// Returns a tube along a horseshoe with two uprights, which has the features of a mandible that the shape test checks.
// `up_left` and `up_right` are the uprights' heights; `bridge` closes the back, and `roof` closes the top.
std::function<double(const Vec3&)> Horseshoe(double up_left, double up_right, bool bridge, bool roof) {
  return [=](const Vec3& p) {
    double d = Rod(p, {-12, -40, 0}, {12, -40, 0}, 7);
    d = std::min(d, Rod(p, {12, -40, 0}, {45, 25, 5}, 7));
    d = std::min(d, Rod(p, {-12, -40, 0}, {-45, 25, 5}, 7));
    d = std::min(d, Rod(p, {45, 25, 5}, {48, 30, up_left}, 6));
    d = std::min(d, Rod(p, {-45, 25, 5}, {-48, 30, up_right}, 6));
    if (bridge) d = std::min(d, Rod(p, {-45, 25, 5}, {45, 25, 5}, 7));
    if (roof) d = std::min(d, Rod(p, {-48, 30, up_right}, {48, 30, up_left}, 7));
    return d;
  };
}

Volume HorseshoeCt(const std::function<double(const Vec3&)>& shape) {
  return test::MakeCt({62, 50, 46}, {2, 2, 2}, {-61, -54, -14}, glm::dmat3(1), shape);
}

MandibleLikeness ShapeOf(const Volume& ct) {
  const Components all = FindComponents(ct, [&](std::size_t v) { return ct.hu[v] > 500; });
  return CheckMandibleLikeness(ct, all.labels, 1, all.list.front());
}

TEST(MandibleLikeness, ArchWithTwoRamiPassesAndItsCounterexamplesFail) {
  EXPECT_EQ(ShapeOf(HorseshoeCt(Horseshoe(60, 60, false, false))).objection, "");
  EXPECT_THAT(ShapeOf(HorseshoeCt(Horseshoe(60, 60, true, false))).objection, HasSubstr("not open to the back"));
  EXPECT_FALSE(ShapeOf(HorseshoeCt(Horseshoe(60, 60, false, true))).is_mandible);
  EXPECT_THAT(ShapeOf(HorseshoeCt(Horseshoe(60, 20, false, false))).objection,
              HasSubstr("only one side reaches up to a condyle"));
  EXPECT_THAT(ShapeOf(HorseshoeCt(Horseshoe(15, 15, false, false))).objection, HasSubstr("height"));
}

TEST(MandibleLikeness, UpsideDownOrBackToFrontFails) {
  const auto shape = Horseshoe(60, 60, false, false);
  EXPECT_FALSE(ShapeOf(HorseshoeCt([&](const Vec3& p) { return shape({p.x, p.y, 62 - p.z}); })).is_mandible);
  EXPECT_FALSE(ShapeOf(HorseshoeCt([&](const Vec3& p) { return shape({p.x, -8 - p.y, p.z}); })).is_mandible);
}

// A child's pelvis without its sacrum, of about 102 x 60 x 92 mm: symphysis, rami, sockets, wings.
double Pelvis(const Vec3& at) {
  const Vec3 p(std::abs(at.x), at.y, at.z);
  double d = std::min(Rod(p, {0, -24, 8}, {8, -24, 6}, 6), Rod(p, {8, -24, 10}, {36, -6, 30}, 5));
  d = std::min({d, Rod(p, {8, -22, 4}, {26, 4, 4}, 4), Rod(p, {28, 6, 6}, {36, 0, 30}, 7)});
  d = std::min(d, Rod(p, {36, 0, 30}, {34, 8, 44}, 9));
  for (double t = 0; t <= 1; t += 0.1) {
    const Vec3 low = glm::mix(Vec3(36, -4, 40), Vec3(26, 22, 48), t);
    const Vec3 middle = glm::mix(Vec3(47, -16, 70), Vec3(26, 27, 74), t);
    d = std::min({d, Rod(p, low, middle, 3.5), Rod(p, middle, glm::mix(Vec3(46, -6, 86), Vec3(34, 20, 88), t), 3.5)});
  }
  return d;
}

TEST(MandibleLikeness, PelvisFails) {
  for (const double pitch_deg : {-35.0, -20.0, 0.0, 20.0, 35.0}) {
    for (const Vec3& size : {Vec3(1), Vec3(1.15, 1, 0.9), Vec3(1, 1.3, 1)}) {
      const glm::dmat3 turn = TurnAbout({1, 0, 0}, pitch_deg);
      const Vec3 middle_W(0, 0, 45);
      const Volume ct = test::MakeCt({76, 76, 76}, {2, 2, 2}, middle_W - 75.0, glm::dmat3(1),
                                     [&](const Vec3& p) { return Pelvis((middle_W + turn * (p - middle_W)) / size); });
      EXPECT_FALSE(ShapeOf(ct).is_mandible) << pitch_deg << ' ' << size.x << ' ' << size.y;
    }
  }
  const Volume ct = test::MakeCt({76, 76, 76}, {2, 2, 2}, {-75, -75, -30}, glm::dmat3(1), Pelvis);
  EXPECT_THAT(ShapeOf(ct).objection, HasSubstr("it has no chin"));
}

// Without teeth, of a child, cut above the notch, with another angle, and with the mouth open.
TEST(MandibleLikeness, JawsOfOtherShapesPass) {
  MandibleParams low, steep;
  low.symphysis_height_mm = 24;
  low.mental_foramen_height_mm = 21;
  low.first_molar_height_mm = 22;
  steep.ramus_height_mm = 38;
  steep.coronoid_height_mm = 50;
  steep.condyle_height_mm = 46;
  steep.gonial_angle_deg = 135;
  const auto pass = [](const MandibleParams& params, bool teeth, double scale, double top_mm, double pitch_deg) {
    const MandibleShape shape(params);
    const glm::dmat3 turn = TurnAbout({1, 0, 0}, pitch_deg);
    const Vec3 middle_W(0, 43, -2);
    return ShapeOf(test::MakeCt({84, 84, 84}, {2, 2, 2}, middle_W - 83.0, glm::dmat3(1),
                                [&](const Vec3& p) {
                                  const Vec3 at = (middle_W + turn * (p - middle_W)) / scale;
                                  const double d = teeth ? shape.Value(at) : shape.BoneValue(at);
                                  return std::max(d, at.z - top_mm);
                                }))
        .is_mandible;
  };
  EXPECT_TRUE(pass({}, false, 1, 99, 0));
  EXPECT_TRUE(pass(low, false, 1, 99, 0));
  EXPECT_TRUE(pass(low, false, 1, 99, -35));
  EXPECT_TRUE(pass(steep, true, 1, 99, 0));
  EXPECT_TRUE(pass({}, true, 0.72, 99, 0));
  EXPECT_TRUE(pass(steep, true, 0.75, 99, 0));
  EXPECT_TRUE(pass({}, true, 1, 22, 0));
  EXPECT_TRUE(pass({}, true, 1, 99, 35));
  EXPECT_TRUE(pass({}, true, 1, 99, -35));
}

// Returns a scan of the arch whose coordinates are in `frame`, although its header states LPS.
Volume HorseshoeIn(const std::string& frame) {
  Volume ct = HorseshoeCt(Horseshoe(60, 60, false, false));
  ReinterpretFrame(frame, ct);  // its inverse is meant, but each of the frames below is its own inverse
  ct.frame = "LPS";
  return ct;
}

TEST(MandibleLikeness, NamesTheRotationThatWouldGiveAMandible) {
  for (const auto& [frame, how] :
       {std::pair("RAS", "faces backwards, as when RAS is read as LPS"), std::pair("RPI", "is upside down:"),
        std::pair("LAI", "is upside down and faces backwards"), std::pair("SAL", "has its axes in another order")}) {
    const Volume ct = HorseshoeIn(frame);
    const MandibleLikeness likeness = ShapeOf(ct);
    EXPECT_FALSE(likeness.is_mandible);
    const std::string said = Describe(likeness, "LPS");
    EXPECT_THAT(said, HasSubstr(fmt::format("; it looks like a mandible that {}", how)));
    EXPECT_THAT(said, HasSubstr(frame));
    // The refusal contains the same text, and stating the suggested frame gives the arch.
    EXPECT_THAT(MessageOf([&] { Isolate(ct, IsolateOptions{}, {}); }), HasSubstr(DescribeRotations(likeness, "LPS")));
    Volume stated = ct;
    ReinterpretFrame(frame, stated);
    EXPECT_TRUE(Isolate(stated, IsolateOptions{}, {}).mandible);
  }
  const MandibleLikeness backwards = ShapeOf(HorseshoeIn("RAS"));
  EXPECT_THAT(Describe(backwards, "LPS"), HasSubstr("are likely RAS, or LAS if mirrored, and not LPS"));
  // For a file read as RAS, the suggested frame is that of the file's own coordinates.
  EXPECT_THAT(Describe(backwards, "RAS"), HasSubstr("are likely LPS, or RPS if mirrored, and not RAS"));
  // The arch does not pass when it lies on its back, so there is one frame.
  EXPECT_THAT(Describe(ShapeOf(HorseshoeIn("SAL")), "LPS"), HasSubstr("are likely SAL, or SAR if mirrored, and not"));
  EXPECT_EQ(DescribeRotations(ShapeOf(HorseshoeIn("LPS")), "LPS"), "");
}

// This mirrors the patient, and hardly changes what the two sides of the jaw look like.
TEST(Isolate, JawWithExchangedAxesIsRefused) {
  for (const char* frame : {"LSP", "RSP"}) {
    Volume ct = test::JawCt();
    ReinterpretFrame(frame, ct);
    EXPECT_THAT(MessageOf([&] { Isolate(StoreAlongPatient(ct), IsolateOptions{}, {}); }), HasSubstr("--frame"))
        << frame;
  }
}

TEST(Isolate, RotationIsAlsoNamedWithKeepAndDropPoints) {
  Volume ct = HorseshoeIn("RAS");
  const Vec3 other(0, -36, 64);  // in bone separate from the arch
  for (int side = 0; side < 5 * 5 * 5; ++side) {
    const Vec3 at = glm::round(ct.VoxelFromWorld(other)) + Vec3(side % 5 - 2, side / 5 % 5 - 2, side / 25 - 2);
    ct.hu[ct.Index(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))] = 1200;
  }
  IsolateOptions options;
  options.keep_W = {{0, 40, 0}};
  options.drop_W = {other};
  EXPECT_THAT(MessageOf([&] { Isolate(ct, options, {}); }), HasSubstr("does not look like a mandible: "));
  EXPECT_THAT(MessageOf([&] { Isolate(ct, options, {}); }), HasSubstr("are likely RAS, or LAS if mirrored"));
}

TEST(Isolate, AutomaticIsolationSeparatesTheArchFromAWeaklyJoinedBlock) {
  // A block of bone above the rami, joined to them by bridges of 500 HU; the arch itself has 1000 HU.
  const auto arch = Horseshoe(56, 56, false, false);
  Volume ct = HorseshoeCt(arch);
  std::size_t alone = 0;
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {
    if (ct.hu[v] >= 300) ++alone;
    const Vec3 p = ct.WorldFromVoxel(
        {static_cast<double>(v % 62), static_cast<double>(v / 62 % 50), static_cast<double>(v / (62 * 50))});
    if (std::abs(p.x) < 56 && p.y > 20 && p.y < 40 && p.z > 66 && p.z < 74) ct.hu[v] = 1200;
    if (std::abs(p.x) > 44 && std::abs(p.x) < 50 && p.y > 28 && p.y < 34 && p.z > 60 && p.z <= 66) ct.hu[v] = 500;
  }
  const Isolation isolation = Isolate(ct, IsolateOptions{}, {});
  EXPECT_TRUE(isolation.mandible);
  EXPECT_GT(isolation.marker_hu, 500);
  // The arch's own volume, plus at most the dim bridges: 2 x 6 x 6 x 6 mm.
  EXPECT_NEAR(isolation.iso_volume_mm3, static_cast<double>(alone) * 8, 600);
}

// Its surface would be open, and the inside of the bone would have no end.
TEST(Isolate, DimBoneThatGoesOnBesideTheArchIsRefused) {
  const auto arch = Horseshoe(56, 56, false, false);
  Volume ct = test::MakeCt({62, 70, 46}, {2, 2, 2}, {-61, -54, -14}, glm::dmat3(1), arch);
  const auto alone = static_cast<double>(std::count_if(ct.hu.begin(), ct.hu.end(), [](auto hu) { return hu >= 300; }));
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {
    const Vec3 p = ct.WorldFromVoxel(
        {static_cast<double>(v % 62), static_cast<double>(v / 62 % 70), static_cast<double>(v / (62 * 70))});
    if (std::abs(p.x) < 48 && p.y > 25 && p.y < 75 && std::abs(p.z - 5) < 4 && ct.hu[v] < 400) ct.hu[v] = 400;
  }
  IsolateOptions options;
  options.check_shape = false;
  EXPECT_THAT(MessageOf([&] { Isolate(ct, options, {}); }),
              HasSubstr("the bone goes on for more than 10 mm beside the part that was recognised"));
  for (double x = -44; x <= 44; x += 8) options.drop_W.emplace_back(x, 42, 5);
  EXPECT_GT(Isolate(ct, options, {}).iso_volume_mm3,
            0.9 * alone * 8);  // mm3 of a voxel; drop points also take their surroundings
}

// A head that `head_from_world` turns, on a lattice of 2 mm along `axes_W`, both about the middle of the jaw.
Volume TurnedJaw(const glm::dmat3& axes_W, const glm::dmat3& head_from_world = glm::dmat3(1)) {
  const Vec3 middle_W(0, 43, -2);
  Volume lattice;
  lattice.size = {90, 90, 80};
  lattice.spacing_mm = Vec3(2);
  lattice.axes_W = axes_W;
  lattice.origin_W = middle_W - axes_W * (0.5 * lattice.spacing_mm * Vec3(89, 89, 79));
  const auto hu = test::JawHu();
  for (std::size_t v = 0; v < lattice.count(); ++v) {
    const Vec3 p_W = lattice.WorldFromVoxel(
        {static_cast<double>(v % 90), static_cast<double>(v / 90 % 90), static_cast<double>(v / 8100)});
    lattice.hu.push_back(static_cast<std::int16_t>(std::lround(hu(middle_W + head_from_world * (p_W - middle_W)))));
  }
  return lattice;
}

// The size of the jaw is measured along the patient's axes, not along those of the scan.
TEST(Isolate, TurnedAndTiltedGridsGiveTheSameJaw) {
  const Isolation upright = Isolate(TurnedJaw(glm::dmat3(1)), IsolateOptions{}, {});
  std::vector<glm::dmat3> grids;
  grids.push_back(TurnAbout({1, 0, 0}, -30));
  grids.push_back(TurnAbout({0, 0, 1}, 44));
  grids.push_back(TurnAbout({1, -1, 2}, 40));
  for (const double tilt_deg : {-15.0, -25.0}) {
    glm::dmat3 tilted(1);
    tilted[1] = {0, std::cos(tilt_deg / kDegreesPerRad), std::sin(tilt_deg / kDegreesPerRad)};
    grids.push_back(tilted);
  }
  for (const glm::dmat3& axes_W : grids) {
    const Volume ct = StoreAlongPatient(TurnedJaw(axes_W));
    const Isolation turned = Isolate(ct, IsolateOptions{}, {});
    EXPECT_TRUE(turned.mandible);
    // The volume of a body counted in voxels of a lattice is known to a few of them per cm2; the tilt shears voxels.
    EXPECT_NEAR(turned.iso_volume_mm3 / upright.iso_volume_mm3, 1, 0.02);
    const Components all = FindComponents(ct, [&](std::size_t v) { return ct.hu[v] >= 300; });
    const Components of_upright = FindComponents(upright.ct, [&](std::size_t v) { return upright.ct.hu[v] >= 300; });
    const Vec3 difference = all.list.front().box_W.size() - of_upright.list.front().box_W.size();
    // Each end is known to a voxel of 2 mm, which measures up to 2 x sqrt(3) mm in a turned grid.
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(difference[a], 0, 2 + 2 * std::sqrt(3.0));
  }
}

TEST(Isolate, HeadMayBeTurned) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 0), Vec3(1, -2, 1)}) {
    for (const double degrees : {-45.0, 40.0}) {
      const glm::dmat3 head_from_world = TurnAbout(axis, degrees);
      const Isolation turned = Isolate(TurnedJaw(glm::dmat3(1), head_from_world), IsolateOptions{}, {});
      EXPECT_TRUE(turned.mandible);
      EXPECT_THAT(turned.how, HasSubstr("the head is turned by"));
      // A mandible looks much the same when it nods a little.
      EXPECT_GT(glm::dot(turned.up_W, glm::transpose(head_from_world) * Vec3(0, 0, 1)), std::cos(20 / kDegreesPerRad))
          << axis.x << ' ' << axis.y << ' ' << axis.z << ' ' << degrees;
    }
  }
}

TEST(Isolate, HeadMayBeTurnedAboutTwoAxes) {
  for (const double a : {-45.0, 45.0}) {
    for (const double b : {-45.0, 45.0}) {
      EXPECT_TRUE(
          Isolate(TurnedJaw(glm::dmat3(1), TurnAbout({0, 0, 1}, a) * TurnAbout({1, 0, 0}, b)), {}, {}).mandible);
      EXPECT_TRUE(
          Isolate(TurnedJaw(glm::dmat3(1), TurnAbout({0, 1, 0}, a) * TurnAbout({1, 0, 0}, b)), {}, {}).mandible);
    }
  }
}

TEST(MandibleLikeness, CounterexamplesFailInATurnedHeadToo) {
  for (const auto& shape : {Horseshoe(60, 60, true, false), Horseshoe(60, 60, false, true),
                            Horseshoe(60, 20, false, false), Horseshoe(15, 15, false, false)}) {
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, -2, 1)}) {
      for (const double degrees : {0.0, 20.0, 40.0}) {
        const glm::dmat3 turn = TurnAbout(axis, degrees);
        const Vec3 middle_W(0, -8, 30);
        const Volume ct = test::MakeCt({76, 76, 76}, {2, 2, 2}, middle_W - 75.0, glm::dmat3(1),
                                       [&](const Vec3& p) { return shape(middle_W + turn * (p - middle_W)); });
        const MandibleLikeness likeness = ShapeOf(ct);
        EXPECT_FALSE(likeness.is_mandible && likeness.turn_deg > 0)
            << axis.x << ' ' << axis.y << ' ' << axis.z << ' ' << degrees;
      }
    }
  }
}

// A ball with a plate of two voxels, on voxels of 0.2 mm: its blocks have 0.6 mm.
TEST(Isolate, FineScanKeepsThinBoneOnItsOwnVoxels) {
  Volume ct = test::MakeCt({110, 92, 92}, Vec3(0.2), {-9.03, -9.01, -8.97}, glm::dmat3(1), Ball({0, 0, 0}, 7), 900);
  for (int k = 45; k < 47; ++k) {
    for (int j = 40; j < 50; ++j) {
      for (int i = 60; i < 105; ++i) ct.hu[ct.Index(i, j, k)] = 900;
    }
  }
  IsolateOptions options;
  options.iso_hu = 450;
  options.isolate = false;
  options.smallest_piece_mm3 = 10;
  options.check_shape = false;
  ct.hu[ct.Index(2, 2, 2)] = 2000;  // a speck
  const Isolation isolation = Isolate(ct, options, {});
  EXPECT_EQ(isolation.step, (std::array<int, 3>{3, 3, 3}));
  const auto bone = std::count_if(ct.hu.begin(), ct.hu.end(), [](auto hu) { return hu >= 450; });
  EXPECT_NEAR(isolation.iso_volume_mm3, static_cast<double>(bone - 1) * 0.008, 1e-9);
  // Each voxel of the crop is that of the scan at the same place.
  const Volume& fine = isolation.fine();
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(6.1, 0, 0), Vec3(9, 0, 0.1), Vec3(11.7, 0, 0.1)}) {
    const Vec3 a = glm::round(ct.VoxelFromWorld(p)), b = glm::round(fine.VoxelFromWorld(p));
    EXPECT_EQ(ct.hu[ct.Index(static_cast<int>(a.x), static_cast<int>(a.y), static_cast<int>(a.z))],
              fine.hu[fine.Index(static_cast<int>(b.x), static_cast<int>(b.y), static_cast<int>(b.z))]);
    EXPECT_EQ(isolation.keep[isolation.Find(static_cast<int>(b.x), static_cast<int>(b.y), static_cast<int>(b.z))], 1);
  }
}

}  // namespace
}  // namespace kerf
