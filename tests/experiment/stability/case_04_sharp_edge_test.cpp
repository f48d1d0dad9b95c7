// Hard case 4: sharp edges and corners of 90 and 30 degrees, which the saw cuts into, rests on and moves across.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;
using test::Verdict;
using test::WatchedTool;

constexpr double kSharpEdgeDt_s = 0.001;

/// Returns a ridge along y of the block's frame, with its edge at the origin and `degrees` between its sides; a pyramid
/// if `corner`.
Bone MakeRidge(const Pose& X_WB, double degrees, double voxel_mm, bool corner) {
  const double half_rad = 0.5 * degrees * std::numbers::pi / 180;
  SolidField field;
  field.value = [=](const Vec3& p_W) {
    const Vec3 p = X_WB.InversePoint(p_W);
    const double across = std::abs(p.x) * std::cos(half_rad) + p.z * std::sin(half_rad);
    const double ends = corner ? std::abs(p.y) * std::cos(half_rad) + p.z * std::sin(half_rad) : std::abs(p.y) - 4;
    return std::max({across, ends, -p.z - 6});
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Box3 box{X_WB.p_AB - Vec3(13), X_WB.p_AB + Vec3(13)};
  return MakeBone(field, box, {voxel_mm, voxel_mm, {}}, test::OneRegionTable());
}

/// Turns the disc's plane across the ridge, or along it.
Pose TurnDisc(const Pose& X_WB, bool along) {
  return {along ? X_WB.R_AB * glm::angleAxis(std::numbers::pi / 2, Vec3(0, 0, 1)) : X_WB.R_AB, X_WB.p_AB};
}

struct Entry {
  std::vector<Vec3> f;  // on the hand, in the disc's frame: z up
  double side_fraction = 0;
  double skated_mm = 0;
};
Entry CutInto(double degrees, double voxel_mm, bool corner, bool along, double offset_mm, const char* law) {
  const Pose X_WB = BlockPoses(voxel_mm)[5];
  const Pose X_WD = TurnDisc(X_WB, along);
  CoupledParams params = test::DiscParams();
  params.law = ForceLaw(law);
  const auto handle = [&](double z) { return DiscPose(X_WD, along ? Vec3(0, offset_mm, z) : Vec3(offset_mm, 0, z)); };
  WatchedTool tool(MakeRidge(X_WB, degrees, voxel_mm, corner), params, handle(kR + 0.3));
  Entry entry;
  for (int i = 1; i <= 800; ++i) {
    const Pose X_WH = handle(kR + 0.3 - 0.005 * i);
    const CoupledOutput out = tool.Tick(X_WH);
    entry.f.push_back(X_WD.InverseVector(out.f_H_W_N));
    const Vec3& f = entry.f.back();
    if (glm::length(f) > 0.5)
      entry.side_fraction = std::max(entry.side_fraction, std::hypot(f.x, f.y) / glm::length(f));
    entry.skated_mm = std::max(entry.skated_mm, std::abs(glm::dot(out.X_WT.p_AB - X_WH.p_AB, X_WD.Vector({0, 1, 0}))));
  }
  tool.invariants.CheckBone();
  return entry;
}

TEST(HardCase04, ForceBeginsWithoutAJumpAndKeepsItsDirection) {
  Verdict verdict(
      "holds, but at the tip of a 30 degree edge, which is thinner than a voxel, the force jumps by up to 0.2 N");
  std::map<double, double> jump_JND;
  double turn_deg = 0, noise_N = 0, side_fraction = 0, skated_mm = 0, tip_N = 0;
  for (const double h : {0.2, 0.4}) {
    for (const double degrees : {90.0, 30.0}) {
      for (const bool corner : {false, true}) {
        for (const bool along : {false, true}) {
          if (corner && along) continue;  // a pyramid is the same in both directions
          for (const auto& [offset_mm, law] : std::initializer_list<std::pair<double, const char*>>{
                   {0.0, "hertz_chip"}, {0.5, "hertz_chip"}, {0.05, "edge_plus_chip"}}) {
            SCOPED_TRACE(testing::Message()
                         << h << " " << degrees << " " << corner << along << " " << offset_mm << law);
            const Entry entry = CutInto(degrees, h, corner, along, offset_mm, law);
            EXPECT_GT(glm::length(entry.f.back()), 1);
            const TickSteps steps = CalcTickSteps(entry.f);
            double& jump = jump_JND[degrees];
            jump = std::max(jump, steps.max);
            for (std::size_t i = 1; i < entry.f.size(); ++i) {
              tip_N = std::max(tip_N, glm::length(entry.f[i] - entry.f[i - 1]));
            }
            turn_deg = std::max(turn_deg, CalcTurn_deg(entry.f, 0.99));
            noise_N = std::max(noise_N, CalcNoise(entry.f, kSharpEdgeDt_s));
            side_fraction = std::max(side_fraction, entry.side_fraction);
            skated_mm = std::max(skated_mm, entry.skated_mm);
          }
        }
      }
    }
  }
  verdict.AtMost("turn of the force per tick, p99", turn_deg, 1, "degrees");
  verdict.AtMost("90 degrees: largest force step", jump_JND[90], 2, "JND");
  verdict.AtMost("30 degrees: largest force step", tip_N, 0.2, "N");
  verdict.AtMost("noise above 20 Hz", 1000 * noise_N, 20, "mN");
  verdict.AtMost("force across the feed relative to the total force, above 0.5 N", side_fraction, 0.1);
  verdict.AtMost("distance skated off the edge", skated_mm, 0.1, "mm");
}

TEST(HardCase04, ForceIsAtMostAsSteepAsTheCoupling) {
  // I19 on the force itself, from two runs that differ only in the handle's position in the last tick. The coupling is
  // the only spring between bone and hand. So |dF| <= K |dx| for any bone, cutting or stopped, also on edges, where
  // normals change abruptly.
  Verdict verdict("holds");
  std::mt19937_64 random(4);
  const auto roll = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double h = 0.4;
  const Pose X_WB = BlockPoses(h)[5];
  double steepest = 0, smallest = 1e9;
  for (const double degrees : {30.0, 90.0}) {
    const Bone bone = MakeRidge(X_WB, degrees, h, false);
    for (const double rpm : {0.0, 7500.0}) {
      for (const bool along : {false, true}) {
        const Pose X_WD = TurnDisc(X_WB, along);
        double largest = 0;
        const int probes =
            std::max(10, static_cast<int>(10 * test::Effort()));  // with fewer, there might be no contact
        for (int probe = 0; probe < probes; ++probe) {
          CoupledParams params = test::DiscParams();
          params.coupling.stiffness_N_per_mm = probe % 2 == 0 ? 1 : 5;
          const int last = 30 + static_cast<int>(120 * roll());
          const double length_mm = std::pow(10, -4 + 3 * roll());
          const Vec3 direction = glm::normalize(Vec3(roll() - 0.5, roll() - 0.5, roll() - 0.5));
          Vec3 f[2];
          for (int run = 0; run < 2; ++run) {
            CoupledSimulation simulation(bone, params, DiscPose(X_WD, {0.1, 0.1, kR + 0.3}));
            for (int i = 1; i <= last; ++i) {
              Pose X_WH = DiscPose(X_WD, {0.1 + 0.003 * i, 0.1, kR + 0.3 - 0.01 * i});
              if (run == 1 && i == last) X_WH.p_AB += length_mm * direction;
              f[run] = simulation.Tick(test::Handle(X_WH, rpm)).f_H_W_N;
            }
          }
          const double steep = glm::length(f[1] - f[0]) / (length_mm * params.coupling.stiffness_N_per_mm);
          largest = std::max(largest, steep);
        }
        steepest = std::max(steepest, largest);
        smallest = std::min(smallest, largest);
      }
    }
  }
  EXPECT_GT(smallest, 0.2);  // there was contact
  verdict.AtMost("largest |dF| / (K |dx|)", steepest, 1.001);
}

TEST(HardCase04, StoppedRimGlidesAcrossAnEdgeAgainstFrictionAlone) {
  // The stopped disc is moved over a face from outside it at 20 mm/s, with the handle `depth` below the face. The rim
  // touches the block's edge at an angle of acos(1 - depth / R) and rides up on it. The only forces are those of the
  // spring and of Coulomb friction. Along the face they are at most N tan(angle + atan(mu)), with N = K depth.
  Verdict verdict("holds");
  double over = 0, lift_off = 0, step_N = 0;
  for (const double h : {0.2, 0.4}) {
    for (const std::size_t n : {0u, 5u}) {
      for (const double mu : {0.0, 0.2}) {
        for (const double depth : {1e-9, 1e-3, 0.1, 0.4}) {
          SCOPED_TRACE(testing::Message() << h << " " << n << " " << mu << " " << depth);
          const Pose X_WB = BlockPoses(h)[n];
          Pose X_WC = X_WB;
          X_WC.p_AB = X_WB.Point({0, 0, -3});
          CoupledParams params = test::DiscParams();
          SetEffect(params.effects, "kerf_friction", "coefficient", mu);
          WatchedTool tool(test::MakeBox(X_WC, {8, 4, 6}, h), params, DiscPose(X_WB, {-8, 0, kR - depth}));
          const double angle = std::acos(1 - depth / kR);
          const double max_N = depth * std::tan(angle + std::atan(mu));
          Vec3 before(0);
          for (double x = -8; x < 8; x += 0.02) {
            const CoupledOutput out = tool.Tick(DiscPose(X_WB, {x, 0, kR - depth}), 0);
            const Vec3 f = X_WB.InverseVector(out.f_H_W_N);
            over = std::max(over, (std::hypot(f.x, f.y) - max_N) / std::max(depth, 1e-3));
            step_N = std::max(step_N, glm::length(f - before));
            before = f;
            EXPECT_GE(f.z, -1e-6);
            if (std::abs(x) < 3) lift_off = std::max(lift_off, std::abs(f.z - depth) / std::max(depth, 1e-3));
            EXPECT_EQ(out.removed_mm3, 0);
          }
          tool.invariants.CheckBone();
        }
      }
    }
  }
  verdict.AtMost("force along the face in excess of friction and slope relative to the force on it", over, 0.1);
  // One point of the rim has 1000 N/mm, the coupling 1 N/mm.
  verdict.AtMost("relative difference of the force on the face from the spring force", lift_off, 0.0015);
  verdict.AtMost("largest force step", step_N, 0.1, "N");
}

}  // namespace
}  // namespace kerf
