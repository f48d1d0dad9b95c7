#include "kerf/tick_warnings.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "cut/force/measured.h"
#include "cut/tool/drive.h"
#include "session/run/cutting_energy.h"
#include "session/run/effect_record.h"
#include "session/run/run_loop.h"
#include "session/run/run_warnings.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

void Append(std::vector<std::string> more, std::vector<std::string>& warnings) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

EffectRecord MakeRecord(const std::vector<std::string>& channels) {
  EffectRecord record;
  for (const std::string& channel : channels) {
    const std::size_t dot = channel.find('.');
    record.figures.push_back({channel.substr(0, dot), channel.substr(dot + 1)});
  }
  return record;
}

}  // namespace

struct TickWarnings::State {
  State(const SimulationParams& the_params, const Bone& bone, const Pose& X_WT_start,
        const std::vector<std::string>& channels)
      : params(the_params),
        voxel_mm(bone.voxel_mm()),
        knows_direction(bone.materials().osteon_direction().has_value()),
        p_WT_mm(X_WT_start.p_AB),
        effects(MakeRecord(channels)) {}

  /// Adds what a tick on a path and one in a hand have in common.
  void Add(double dt_s, double rpm, const TeethOutput& out, std::span<const double> channels) {
    const double turns_per_s = std::abs(rpm) < kMinRpm ? 0 : std::abs(rpm) / 60;
    const bool cuts = out.engaged_teeth > 0;
    ++ticks;
    turned = turned || turns_per_s > 0;
    findings.touched = findings.touched || cuts;
    if (std::exchange(set_down, false) && out.removed_mm3 > kInBone_mm3) findings.starts_in_bone = true;
    sums.thrust_J += out.thrust_W * dt_s;
    sums.simulated_s += dt_s;
    sums.cutting_J += out.cutting_W * dt_s;
    if (cuts) sums.cutting_turns += turns_per_s * dt_s;
    if (channels.size() == effects.figures.size()) effects.Take(channels);
  }
  std::vector<std::string> FindEnergy(double removed_mm3) const {
    if (restored) return {};
    CuttingSums all = sums;
    all.removed_mm3 = removed_mm3;
    return FindEnergyWarnings(params.law, CalcCuttingEnergy(params, effects, all));
  }

  SimulationParams params;
  std::optional<int> spare_leaves;  // of a tool in a hand
  double voxel_mm;
  bool knows_direction;  // of the osteons
  Vec3 p_WT_mm;          // of the tool after the last tick
  bool set_down = true;  // since the last tick
  bool turned = false;   // the spindle turned in some tick
  bool restored = false;
  std::size_t ticks = 0;
  double max_bite_mm = 0;
  TickFindings findings;
  CuttingSums sums;
  EffectRecord effects;
  // Of a tool in a hand.
  double rate_hz = 1000;
  double hand_J = 0, spindle_J = 0, numerical_J = 0;
  std::optional<double> leaves_used_up_s;
  std::optional<double> metal_touched_s;
};

TickWarnings::TickWarnings(const SimulationParams& params, const Bone& bone, const Pose& X_WT_start,
                           const std::vector<std::string>& channels)
    : state_(std::make_unique<State>(params, bone, X_WT_start, channels)) {}
TickWarnings::TickWarnings(const CoupledParams& params, const Bone& bone, const std::vector<std::string>& channels)
    : state_(std::make_unique<State>(params, bone, Pose{}, channels)) {
  state_->spare_leaves = params.spare_leaves;
}
TickWarnings::~TickWarnings() = default;
TickWarnings::TickWarnings(TickWarnings&&) noexcept = default;
TickWarnings& TickWarnings::operator=(TickWarnings&&) noexcept = default;

void TickWarnings::Add(const TickInput& in, const TickOutput& out, std::span<const double> channels) {
  State& s = *state_;
  if (out.status != kTickOk) ++s.findings.ticks_with_status;
  if ((out.status & kTickTouchesMetal) != 0) ++s.findings.ticks_at_metal;
  if ((out.status & (kTickBadPose | kTickNoTime)) != 0) return;
  const double speed_mm_per_s = glm::length(in.X_WT.p_AB - s.p_WT_mm) / in.dt_s;
  s.p_WT_mm = in.X_WT.p_AB;
  s.Add(in.dt_s, in.rpm, out, channels);
  if (out.engaged_teeth > 0) {
    s.max_bite_mm = std::max(s.max_bite_mm, speed_mm_per_s / CalcLeastPassRate(s.params.tool, in.rpm));
  }
}

void TickWarnings::Add(const CoupledInput& in, const CoupledOutput& out, std::span<const double> channels) {
  State& s = *state_;
  if ((out.status & (kCoupledBadPose | kCoupledNoTime)) != 0) return;
  s.Add(in.dt_s, in.rpm, out, channels);
  s.rate_hz = 1 / in.dt_s;
  s.hand_J += 1e-3 * out.hand_mJ;
  s.spindle_J += 1e-3 * out.spindle_mJ;
  s.numerical_J += 1e-3 * out.numerical_mJ;
  if ((out.status & kCoupledLeavesUsedUp) != 0 && !s.leaves_used_up_s) s.leaves_used_up_s = s.sums.simulated_s;
  if ((out.status & kCoupledTouchesMetal) != 0 && !s.metal_touched_s) s.metal_touched_s = s.sums.simulated_s;
}

void TickWarnings::SetDown(const Pose& X_WT) {
  state_->p_WT_mm = X_WT.p_AB;
  state_->set_down = true;
}

void TickWarnings::BoneRestored() {
  state_->restored = true;
}

std::vector<std::string> TickWarnings::Find(double removed_mm3) const {
  const State& s = *state_;
  std::vector<std::string> warnings = FindVoxelWarnings(s.params, s.voxel_mm);
  const bool stopped = s.ticks > 0 && !s.turned;
  if (stopped) warnings.emplace_back(kStoppedWarning);
  if (s.spare_leaves) {
    LoopSummary summary;
    summary.touched = s.findings.touched || s.ticks == 0;
    summary.starts_in_bone = s.findings.starts_in_bone;
    summary.rate_hz = s.rate_hz;
    summary.hand_J = s.hand_J;
    summary.spindle_J = s.spindle_J;
    summary.numerical_J = s.numerical_J;
    summary.leaves_used_up_s = s.leaves_used_up_s;
    summary.metal_touched_s = s.metal_touched_s;
    AddLoopWarnings(summary, *s.spare_leaves);
    Append(std::move(summary.warnings), warnings);
    Append(s.FindEnergy(removed_mm3), warnings);
    return warnings;
  }
  if (!stopped) {
    // Before the first cut nothing is said about bites.
    Append(FindLawWarnings(s.params, s.max_bite_mm > 0 ? s.max_bite_mm : FindMinValidBite(s.params.law)), warnings);
    if (s.knows_direction && (MakeToothForce(s.params.law, s.params.tool).reads & kReadsOsteons) == 0) {
      warnings.push_back(DescribeUnusedDirection(s.params.law));
    }
  }
  TickFindings findings = s.findings;
  findings.touched = findings.touched || s.ticks == 0;
  findings.removed_mm3 = removed_mm3;
  findings.tool = NameTool(s.params.tool);
  Append(FindTickWarnings(findings), warnings);
  Append(s.FindEnergy(removed_mm3), warnings);
  Append(FindEffectWarnings(s.params.effects, s.effects), warnings);
  return warnings;
}

std::vector<std::string> FindSlabWarnings(const SceneFile& scene, const SlabState& start, const SlabState* now) {
  SlabSummary summary;
  summary.end = now != nullptr ? *now : start;
  if (now == nullptr) summary.end.deepest_mm = 1;  // nothing is said about bone that was not touched yet
  summary.starts_in_bone = start.depth_mm > kInBone_mm;
  return FindSlabRunWarnings(scene.scene(), summary);
}

}  // namespace kerf
