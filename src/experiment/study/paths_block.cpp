// The built-in paths in blocks and plates, for which there are exact formulas.
#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "bone/material/region_table.h"
#include "experiment/study/hand_path.h"
#include "experiment/study/paths.h"

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kCortical = 24;

/// Returns a pose that is rotated relative to the grid and offset by a fraction of a voxel at any voxel size, so that
/// no size is favoured.
Pose StandAskew() {
  return {glm::angleAxis(0.5, glm::normalize(Vec3(1, 2, 0.5))), {0.337, -0.1273, 0.2191}};
}

/// Returns the distance to a disc, mm; B may be any frame.
double CalcDiscDistance(const DiscSaw& saw, const Pose& X_BT, const Vec3& p_B) {
  const Vec3 p_T = X_BT.InversePoint(p_B);
  const double across = std::hypot(p_T.x, p_T.y) - saw.radius_mm();
  const double along = std::abs(p_T.z) - 0.5 * saw.thickness_mm;
  return across > 0 && along > 0 ? std::hypot(across, along) : std::max(across, along);
}

struct BlockPlan {
  const char* title;
  Vec3 size_mm;
  std::vector<MaterialLayer> layers;
  double duration_s;
  UprightMotion hand;
  UprightMotion tool;
};

StudyPath MakePath(const std::string& name, const BlockPlan& plan,
                   const std::function<Pose(Holding, double)>& pose_B = nullptr) {
  StudyPath path = MakePlainPath(name, plan.title);
  BlockParams block;
  block.size_mm = plan.size_mm;
  block.layers = plan.layers;
  block.X_WB = StandAskew();
  path.duration_s = plan.duration_s;
  const DiscSaw saw = path.saw;
  path.pose = [X_WB = block.X_WB, pose_B, saw, hand = plan.hand, tool = plan.tool](Holding holding, double t_s) {
    const Pose X_BT =
        pose_B ? pose_B(holding, t_s) : CalcUprightPose(holding == Holding::kHand ? hand : tool, saw, t_s);
    return Pose{glm::normalize(X_WB.R_AB * X_BT.R_AB), X_WB.Point(X_BT.p_AB)};
  };
  SetBlock(path, block);
  return path;
}

/// Returns a motion that accelerates from rest at `start` to `speed` within 0.1 s, keeps this speed until 0.1 s before
/// `end_s`, and is at rest again at `end_s`.
Way MoveOff(double start, double speed, double end_s) {
  return {start, {{0, 0}, {0.1, speed}, {end_s - 0.1, speed}, {end_s, 0}}};
}

// Depths are those of the disc's lowest point. On a prescribed path the tool cuts at 1 to 5 mm/s. In a hand, the handle
// is ahead of the tool by 1 mm per newton of force, so it moves further and faster than the tool.

BlockPlan PlanIdle() {
  const Way along(-1.5, {{0, 3}});
  return {"in air, 0.3 mm above the bone", {12, 3, 4}, {}, 1, {along, Way(-0.3), Way(), Way()},
          {along, Way(-0.3), Way(), Way()}};
}

BlockPlan PlanEntry() {
  return {"from the air into cortical bone, up to 1.5 mm deep",
          {20, 3, 5},
          {},
          1.2,
          {Way(), MoveOff(-0.4, 8, 1.2), Way(), Way()},
          {Way(), MoveOff(-0.4, 1.75, 1.2), Way(), Way()}};
}

BlockPlan PlanSlot() {
  // The rim touches the end face first; at a depth of 3 mm it is 7.55 mm ahead of the disc's centre.
  return {"into the end face and along a slot 3 mm deep",
          {20, 3, 6},
          {},
          2.4,
          {MoveOff(-18, 8, 2.4), Way(3, {{0, 0}, {0.3, 2}, {1.6, 2}, {1.8, 0}}), Way(), Way()},
          {MoveOff(-18, 4, 2.4), Way(3), Way(), Way()}};
}

BlockPlan PlanPlunge() {
  return {"straight down, a pause, and up again",
          {24, 3, 8},
          {},
          2.2,
          {Way(), Way(-0.3, {{0, 0}, {0.1, 12}, {1.2, 12}, {1.3, 0}, {1.6, 0}, {1.75, -40}, {2.05, -40}, {2.2, 0}}),
           Way(), Way()},
          {Way(), Way(-0.3, {{0, 0}, {0.1, 2.5}, {1.4, 2.5}, {1.5, 0}, {1.7, 0}, {1.8, -9}, {2.1, -9}, {2.2, 0}}),
           Way(), Way()}};
}

BlockPlan PlanGraze() {
  return {"the rim 0.3 mm deep along a face",
          {16, 3, 4},
          {},
          1.6,
          {MoveOff(-12.2, 5, 1.6), Way(0.6), Way(), Way()},
          {MoveOff(-11.2, 5, 1.6), Way(0.3), Way(), Way()}};
}

BlockPlan PlanBorder() {
  return {"through 1.5 mm of cortical into cancellous bone", {26, 3, 10},
          {{1.5, kCortical}, {8.5, kCancellousRegion}},      1.8,
          {Way(), MoveOff(-0.3, 9, 1.8), Way(), Way()},      {Way(), MoveOff(-0.3, 2.2, 1.8), Way(), Way()}};
}

BlockPlan PlanBreakthrough() {
  return {"down through a plate 4.5 mm thick and 10 mm long, and out on the far side",
          {10, 3, 4.5},
          {},
          2.5,
          {Way(), MoveOff(-0.3, 10, 2.5), Way(), Way()},
          {Way(), MoveOff(-0.3, 2.8, 2.5), Way(), Way()}};
}

BlockPlan PlanTilt() {
  const Way tilt_hand(0, {{0, 0}, {0.7, 0}, {0.8, 3 * kDegree}, {1.8, 3 * kDegree}, {1.9, 0}});
  const Way tilt_tool(0, {{0, 0}, {0.7, 0}, {0.8, 1.5 * kDegree}, {1.8, 1.5 * kDegree}, {1.9, 0}});
  return {"down, the handle tilting as it cuts",
          {22, 4, 7},
          {},
          2,
          {Way(), MoveOff(-0.3, 9, 2), Way(), tilt_hand},
          {Way(), MoveOff(-0.3, 1.8, 2), Way(), tilt_tool}};
}

BlockPlan PlanReentry() {
  return {
      "into the bone, out of the kerf, back in and deeper",
      {22, 3, 7},
      {},
      2.5,
      {Way(),
       Way(-0.3, {{0, 0}, {0.1, 10}, {0.9, 10}, {1.0, 0}, {1.1, -30}, {1.4, -30}, {1.5, 0}, {1.6, 16}, {2.5, 16}}),
       Way(), Way()},
      {Way(), Way(-0.3, {{0, 0}, {0.1, 2.5}, {0.9, 2.5}, {1.0, 0}, {1.1, -5}, {1.4, -5}, {1.5, 0}, {1.6, 3}, {2.5, 3}}),
       Way(), Way()}};
}

BlockPlan PlanWorst() {
  return {"the whole disc buried in bone, starting in a kerf of its own shape",
          {28, 3, 28},
          {},
          1.2,
          {MoveOff(-1, 10, 1.2), Way(25), Way(), Way()},
          {MoveOff(-1, 3, 1.2), Way(25), Way(), Way()}};
}

/// Makes the path of PlanWorst(). A disc can be inside bone only if it has cut its way there, so the bone at its start
/// pose has already been removed.
StudyPath MakeWorstPath(const std::string& name) {
  StudyPath path = MakePath(name, PlanWorst());
  BlockParams block;
  block.size_mm = PlanWorst().size_mm;
  block.X_WB = StandAskew();
  const Pose X_WT = path.pose(Holding::kPath, 0);
  SetBlock(path, block, {.shape = nullptr, .was_cut = [saw = path.saw, X_WT](const Vec3& p_W) {
                           return -CalcDiscDistance(saw, X_WT, p_W);
                         }});
  return path;
}

BlockPlan PlanThinPlate() {
  return {"down through a plate 0.8 mm thick and 8 mm long, and out on the far side",
          {8, 3, 0.8},
          {},
          1,
          {Way(), MoveOff(-0.3, 8, 1), Way(), Way()},
          {Way(), MoveOff(-0.3, 4, 1), Way(), Way()}};
}

BlockPlan PlanLamella() {
  return {"down through a lamella 0.4 mm thick and 8 mm long",
          {8, 3, 0.4},
          {},
          1,
          {Way(), MoveOff(-0.3, 6, 1), Way(), Way()},
          {Way(), MoveOff(-0.3, 4, 1), Way(), Way()}};
}

BlockPlan PlanSkim() {
  return {"the rim 0.1 mm deep along a face",
          {16, 3, 4},
          {},
          1.6,
          {MoveOff(-12, 5, 1.6), Way(0.25), Way(), Way()},
          {MoveOff(-10.5, 5, 1.6), Way(0.1), Way(), Way()}};
}

BlockPlan PlanWedge() {
  return {"along a slot 1 mm deep towards the edge of a wedge of 10 degrees, and out on its far side",
          {12, 3, 2.2},
          {},
          2.5,
          {MoveOff(12, -6.5, 2.5), Way(1.4), Way(), Way()},
          {MoveOff(11.2, -6.5, 2.5), Way(1), Way(), Way()}};
}

/// Makes the path of PlanWedge(). The lower face of the block rises to the upper one at x = -6 mm.
StudyPath MakeWedgePath(const std::string& name) {
  StudyPath path = MakePath(name, PlanWedge());
  BlockParams block;
  block.size_mm = PlanWedge().size_mm;
  block.X_WB = StandAskew();
  constexpr double kAngle = 10 * kDegree;
  SetBlock(path, block,
           {.shape =
                [block](const Vec3& p_W) {
                  const Vec3 p_B = block.X_WB.InversePoint(p_W);
                  return -(p_B.z * std::cos(kAngle) + (p_B.x + 0.5 * block.size_mm.x) * std::sin(kAngle));
                },
            .was_cut = nullptr});
  return path;
}

BlockPlan PlanCrossing() {
  BlockPlan plan = PlanSlot();
  plan.title = "into the end face and along a slot 3 mm deep, across a kerf 0.25 mm wide";
  return plan;
}

/// Makes the path of PlanCrossing(). The kerf is across the slot, 4 mm from the end face.
StudyPath MakeCrossingPath(const std::string& name) {
  StudyPath path = MakePath(name, PlanCrossing());
  BlockParams block;
  block.size_mm = PlanCrossing().size_mm;
  block.X_WB = StandAskew();
  SetBlock(path, block, {.shape = nullptr, .was_cut = [block](const Vec3& p_W) {
                           return 0.125 - std::abs(block.X_WB.InversePoint(p_W).x + 6);
                         }});
  return path;
}

BlockPlan PlanFreeForm() {
  return {"strokes of a hand, with tremor, read from a file",
          {24, 4, 8},
          {{2.2, kCortical}, {5.8, kCancellousRegion}},
          0,
          {},
          {}};
}

}  // namespace

std::optional<StudyPath> MakeBlockPath(const std::string& name) {
  static const std::map<std::string, BlockPlan (*)()> plans = {{"idle", PlanIdle},
                                                               {"entry", PlanEntry},
                                                               {"slot", PlanSlot},
                                                               {"plunge", PlanPlunge},
                                                               {"graze", PlanGraze},
                                                               {"border", PlanBorder},
                                                               {"breakthrough", PlanBreakthrough},
                                                               {"tilt", PlanTilt},
                                                               {"reentry", PlanReentry},
                                                               {"thin_plate", PlanThinPlate},
                                                               {"lamella", PlanLamella},
                                                               {"skim", PlanSkim}};
  if (name == "worst") return MakeWorstPath(name);
  if (name == "wedge") return MakeWedgePath(name);
  if (name == "crossing") return MakeCrossingPath(name);
  if (name == "free_form") {
    BlockPlan plan = PlanFreeForm();
    const auto hand = std::make_shared<const HandPath>(FreeFormHandPath());
    plan.duration_s = hand->duration_s();
    const auto tool = std::make_shared<const HandPath>(FreeFormToolPath());
    return MakePath(name, plan, [hand, tool](Holding holding, double t_s) {
      return (holding == Holding::kHand ? hand : tool)->CalcPose(t_s);
    });
  }
  const auto found = plans.find(name);
  if (found == plans.end()) return std::nullopt;
  return MakePath(name, found->second());
}

}  // namespace kerf
