// Hard case 26: a bone and a saw a kilometre or more from the origin, and denormal numbers.
#include <limits>

#include "bone/grid/grids.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/error.h"
#include "loop/haptics/held_saw.h"
#include "support/message_of.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::Handle;

const Vec3 kFarAwaySize(22, 2, 8);

/// Returns the same block, voxel for voxel, moved by `shift_vox` voxels.
Bone BlockAt(const Vec3& shift_vox, double h) {
  SolidField field;
  // Finds the index first, so that rounding is the same everywhere.
  field.value = [=](const Vec3& p) {
    const Vec3 index = glm::round(p / h) - shift_vox;
    const Vec3 off = p - h * glm::round(p / h);
    return test::BoxDistance(h * index + (glm::length(off) < 1e-6 ? Vec3(0) : off), 0.5 * kFarAwaySize);
  };
  const auto value = field.value;
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Vec3 middle = h * shift_vox;
  return MakeBone(field, Box3{middle - 0.5 * kFarAwaySize, middle + 0.5 * kFarAwaySize}.Grown(6 * h), {h, h, {}},
                  test::OneRegionTable());
}

/// Returns the motion of the handle: down into the block, sideways against the kerf's walls, tilted, along, stopped,
/// and out. Its positions lie on a lattice that a double represents exactly up to 10^6.
CoupledInput Script(int i, const Vec3& shift_mm) {
  const double t = 0.001 * i;
  Vec3 p(0, 0, 4 + kR + 0.2 - 3 * std::min(t, 1.2));
  if (t > 1) p += Vec3(2 * std::min(t - 1, 0.8), 0.5 * std::sin(5 * (t - 1)), 0);
  if (t > 2.2) p.z += 10 * (t - 2.2);
  p = glm::round(p * 1048576.0) / 1048576.0;
  CoupledInput in = Handle(DiscPose(Pose{}, p), t > 1.7 && t < 1.9 ? 0 : 7500);
  in.X_WH.R_AB = glm::normalize(in.X_WH.R_AB * glm::angleAxis(0.003 * std::sin(3 * t), glm::normalize(Vec3(1, 2, 3))));
  in.X_WH.p_AB += shift_mm;
  return in;
}

struct Ran {
  std::vector<CoupledOutput> out;
  Bone bone;
};

Ran RunAt(const Vec3& shift_vox, double h, const CoupledParams& params = DiscParams()) {
  const Vec3 shift_mm = h * shift_vox;
  const Pose start = Script(0, shift_mm).X_WH;
  CoupledSimulation simulation(BlockAt(shift_vox, h), params, start);
  test::Invariants watch(simulation, start);
  Ran ran;
  for (int i = 1; i <= 3000; ++i) {
    const CoupledInput in = Script(i, shift_mm);
    ran.out.push_back(simulation.Tick(in));
    watch.Tick(in, ran.out.back());
  }
  watch.CheckBone();
  ran.bone = simulation.UpdateBone();
  return ran;
}

/// Returns the largest difference between `here` and `there`, which is moved by `shift_vox`; counts the differing
/// voxels.
double CalcLargestDifference(const Bone& here, const Bone& there, const Vec3& shift_vox, int& differing) {
  const auto& a = GridsOf(here).phi->constTree();
  const auto& b = GridsOf(there).phi->constTree();
  const openvdb::Coord shift(static_cast<int>(shift_vox.x), static_cast<int>(shift_vox.y),
                             static_cast<int>(shift_vox.z));
  double largest = 0;
  for (auto leaf = a.cbeginLeaf(); leaf; ++leaf) {
    for (openvdb::Index i = 0; i < 512; ++i) {
      const double off = static_cast<double>(leaf->getValue(i)) -
                         static_cast<double>(b.getValue(leaf->offsetToGlobalCoord(i) + shift));
      differing += off != 0 ? 1 : 0;
      largest = std::max(largest, std::abs(off));
    }
  }
  return largest;
}

TEST(HardCase26, EverythingIsBitIdenticalAKilometreAway) {
  test::Verdict verdict("holds: the tick works in a frame near the bone");
  constexpr double h = 0.25;
  const Ran here = RunAt(Vec3(0), h);
  double max_N = 0;
  for (const CoupledOutput& out : here.out) max_N = std::max(max_N, glm::length(out.f_H_W_N));
  ASSERT_GT(max_N, 0.5);
  int forces = 0;
  int voxels = 0;
  // The shifts are multiples of 2^17 voxels; on some axes there is none.
  for (const Vec3& shift_vox : {131072.0 * Vec3(30, -30, 17), 131072.0 * Vec3(0, 1, -30)}) {
    ASSERT_LT(glm::length(shift_vox) * h, 1.8e6);
    const Ran there = RunAt(shift_vox, h);
    double max_off_mm = 0;
    for (std::size_t i = 0; i < here.out.size(); ++i) {
      const CoupledOutput& a = here.out[i];
      const CoupledOutput& b = there.out[i];
      forces += a.f_H_W_N != b.f_H_W_N || a.tau_H_W_Nmm != b.tau_H_W_Nmm || a.f_cut_W_N != b.f_cut_W_N ||
                        a.f_face_W_N != b.f_face_W_N || a.f_friction_W_N != b.f_friction_W_N ||
                        a.removed_mm3 != b.removed_mm3 || a.engaged_teeth != b.engaged_teeth ||
                        a.hand_mJ != b.hand_mJ || a.X_WT.R_AB != b.X_WT.R_AB || a.status != b.status
                    ? 1
                    : 0;
      max_off_mm = std::max(max_off_mm, glm::length(b.X_WT.p_AB - h * shift_vox - a.X_WT.p_AB));
    }
    CalcLargestDifference(here.bone, there.bone, shift_vox, voxels);
    // The tolerance is half a unit in the last place of 10^6 along each axis.
    EXPECT_LE(max_off_mm, 2e-10);
  }
  verdict.Equal("ticks in which any force or energy differs", forces, 0);
  verdict.Equal("voxels that differ", voxels, 0);
}

TEST(HardCase26, UnavoidableRoundingIsThatOfTheInput) {
  test::Verdict verdict("holds");
  // Because 0.2 is not a binary fraction, the positions of the handle and of the block are rounded to 1e-10 mm.
  constexpr double h = 0.2;
  // Distances are accurate to 4e-7 of the disc's radius: the tool's are floats, with steps of 2^-20 mm from 8 mm on.
  const double distance_mm = 4e-7 * kR;
  struct Case {
    const char* law;
    double leaves_N;
    double leaves_mm;
  };
  // With Hertz's law no distance near the tool is rounded differently. The spring of 1 N/mm, the lever arm of the
  // torsion spring and the walls of 3000 N/mm per point let 1e-10 mm of rounding grow to about 1e-9 N. The default law
  // cuts deeper, and some distances are rounded to the next step. The tool rests on that bone, so that it is off by a
  // few times as much, and the spring's force with it; in the air it is where it was.
  for (const auto& [law, leaves_N, leaves_mm] :
       {Case{"hertz_chip", 1e-7, 1e-6}, Case{"two_component", 5 * distance_mm, distance_mm}}) {
    CoupledParams params = DiscParams();
    params.law = ForceLaw(law);
    const Ran here = RunAt(Vec3(0), h, params);
    double max_off_N[2] = {0, 0};
    double max_off_mm[2] = {0, 0};
    double last_off_N = 0;
    // The bone is moved by whole leaves, and by voxels. If it is moved by voxels, each distance is rounded to a float
    // relative to another leaf's corner.
    for (const bool leaves : {true, false}) {
      for (const Vec3& shift_vox : {Vec3(4999800, -4999800, 4999800), Vec3(8, 65536 * 8, 1234568)}) {
        const Vec3 shift = leaves ? shift_vox : shift_vox + Vec3(3, -1, 2);
        const Ran there = RunAt(shift, h, params);
        int differing = 0;
        for (std::size_t i = 0; i < here.out.size(); ++i) {
          last_off_N = glm::length(here.out[i].f_H_W_N - there.out[i].f_H_W_N);
          max_off_N[leaves ? 0 : 1] = std::max(max_off_N[leaves ? 0 : 1], last_off_N);
        }
        EXPECT_EQ(last_off_N, 0) << law;
        max_off_mm[leaves ? 0 : 1] =
            std::max(max_off_mm[leaves ? 0 : 1], CalcLargestDifference(here.bone, there.bone, shift, differing));
      }
    }
    verdict.AtMost(fmt::format("force deviation, bone moved by whole leaves, {}", law), max_off_N[0], leaves_N, "N");
    verdict.AtMost(fmt::format("deviation of the bone, moved by whole leaves, {}", law), max_off_mm[0], leaves_mm,
                   "mm");
    // At a stiff wall that accuracy is 0.01 N per point, wherever the bone is. About twelve of the 48 points of the
    // outermost ring are in the kerf.
    verdict.AtMost(fmt::format("force deviation, bone moved by voxels, {}", law), max_off_N[1], 0.13, "N");
  }
}

TEST(HardCase26, PositionBeyondTheWorldIsRefusedWithAMessage) {
  test::Verdict verdict(
      "holds: the world extends to 10^6 mm along each axis; a position beyond it is bad input and gives zero force");
  const Bone bone = test::MakeBox(Pose{}, {6, 2, 4}, 0.4);
  const Pose start = DiscPose(Pose{}, {0, 0, 2 + kR + 0.1});
  CoupledSimulation simulation(bone, DiscParams(), start);
  Simulation path(bone, {}, start);
  simulation.Tick(Handle(start));
  test::HeldSaw saw;
  const double inf = std::numeric_limits<double>::infinity();
  for (const double far_mm : {std::nextafter(1e6, inf), 1e9, 1e12, 1e300, inf}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        Pose X = start;
        X.p_AB[axis] = sign * far_mm;
        const CoupledOutput out = simulation.Tick(Handle(X));
        EXPECT_EQ(out.status, kCoupledBadPose);
        EXPECT_EQ(out.f_H_W_N, Vec3(0));
        EXPECT_EQ(out.X_WT.p_AB, start.p_AB);
        EXPECT_FALSE(simulation.SetDown(X));
        EXPECT_EQ(path.Tick({X, 0.001, 7500}).status, kTickBadPose);
        EXPECT_FALSE(path.SetDown(X));
        EXPECT_THROW(CoupledSimulation(bone, DiscParams(), X), Error);
        EXPECT_THROW(Simulation(bone, {}, X), Error);
      }
    }
  }
  // Positions on the border are still accepted.
  Pose X = start;
  X.p_AB = Vec3(1e6, -1e6, 1e6);
  for (int i = 0; i < 5; ++i) simulation.Tick(Handle(X));
  EXPECT_EQ(simulation.Tick(Handle(X)).status, kCoupledAsleep);
  EXPECT_EQ(simulation.Tick(Handle(X)).X_WT.p_AB, X.p_AB);
  for (const double far_mm : {1.1e6, 1e9, 1e12, 1e300}) {
    const SolidField ball = test::SphereField(Vec3(far_mm, 0, 0), 1);
    EXPECT_THROW(
        MakeBone(ball, Box3{Vec3(far_mm - 2, -2, -2), Vec3(far_mm + 2, 2, 2)}, {0.4, 0.4, {}}, test::OneRegionTable()),
        Error)
        << far_mm;
  }
  EXPECT_EQ(test::MessageOf([&] {
              CoupledSimulation(bone, DiscParams(), DiscPose(Pose{}, {0, 1e9, 0}));
            }),
            "the tool's start position is more than 1000000 mm from the world origin");
}

TEST(HardCase26, JumpsAcrossTheWorldInATickDoNoHarm) {
  test::Verdict verdict("holds");
  const Bone bone = test::MakeBox(Pose{}, {6, 2, 4}, 0.4);
  const Pose start = DiscPose(Pose{}, {0, 0, 2 + kR + 0.1});
  CoupledSimulation simulation(bone, DiscParams(), start);
  test::Invariants watch(simulation, start, {false, true});
  CoupledOutput out;
  const auto to = [&](const Pose& X, double rpm) {
    const CoupledInput in = Handle(X, rpm);
    out = simulation.Tick(in);
    watch.Tick(in, out);
  };
  double max_N = 0;
  for (int i = 0; i < 200; ++i) {
    Pose X = start;
    X.p_AB += (i % 2 == 0 ? 9e5 : -9e5) * Vec3(i % 3 - 1, i % 5 - 2 == 0 ? 1 : 0, i % 7 - 3 == 0 ? 1 : -1);
    to(X, i % 4 == 0 ? 0 : 7500);
    max_N = std::max(max_N, glm::length(out.f_H_W_N));
  }
  // Back at the bone, the saw cuts as before.
  for (int i = 0; i < 4000; ++i) to(start, 7500);
  EXPECT_EQ(out.X_WT.p_AB, start.p_AB);
  for (int i = 1; i <= 400; ++i) to(DiscPose(Pose{}, {0, 0.6, 2 + kR + 0.1 - 0.003 * i}), 7500);
  EXPECT_GT(out.engaged_teeth, 0.3);
  verdict.AtMost("largest force", max_N, 40 * (1 + 1e-12), "N");
}

TEST(HardCase26, DenormalNumbersActAsZero) {
  test::Verdict verdict("holds");
  const double tiny = std::numeric_limits<double>::denorm_min();
  const Bone bone = test::MakeBox(Pose{}, {22, 2, 8}, 0.25);
  const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR + 0.1});
  CoupledParams params = DiscParams();
  params.coupling.damping_Ns_per_mm = 0.001;
  CoupledSimulation plain(bone, params, start);
  CoupledSimulation denormal(bone, params, start);
  double max_off_N = 0;
  double max_N = 0;
  for (int i = 1; i <= 1200; ++i) {
    CoupledInput in = Handle(DiscPose(Pose{}, {0, 0, 4 + kR + 0.1 - 0.002 * i}), i > 1000 ? 0 : 7500);
    const CoupledOutput a = plain.Tick(in);
    const double sign = i % 2 == 0 ? tiny : -tiny;
    in.X_WH.p_AB += Vec3(sign, sign, 0);
    in.X_WH.R_AB.y += sign;
    in.v_H_W_mm_per_s += Vec3(sign, -sign, sign);
    in.w_H_W_rad_per_s += Vec3(sign);
    if (in.rpm == 0) in.rpm = sign;
    const CoupledOutput b = denormal.Tick(in);
    EXPECT_EQ(a.status, b.status);
    max_off_N = std::max(max_off_N, glm::length(a.f_H_W_N - b.f_H_W_N));
    max_N = std::max(max_N, glm::length(a.f_H_W_N));
  }
  EXPECT_GT(max_N, 0.3);
  verdict.AtMost("force deviation due to denormals", max_off_N, 1e-12, "N");
}

}  // namespace
}  // namespace kerf
