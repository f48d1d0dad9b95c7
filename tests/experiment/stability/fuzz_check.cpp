#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/core/heap_guard.h"
#include "bone/grid/field.h"
#include "cut/hand_sim/coupling.h"
#include "experiment/stability/fuzz.h"
#include "experiment/stability/invariants.h"

namespace kerf::test {
namespace {

constexpr int kTicksInBox = 16;

/// Returns true if a tick must accept the input. Written independently of coupled.h.
bool IsGood(const Tool& tool, const CoupledInput& in) {
  const auto within = [](const Vec3& v, double limit) {
    return IsFinite(v) && std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) <= limit;
  };
  return within(in.X_WH.p_AB, kWorldReach_mm) && std::abs(std::pow(glm::length(in.X_WH.R_AB), 2) - 1) <= 2e-6 &&
         within(in.v_H_W_mm_per_s, 1e6) && within(in.w_H_W_rad_per_s, 1e6) && in.dt_s >= 0 && in.dt_s <= 1 &&
         std::abs(in.rpm) <= std::max(1e6, CalcRateRange(tool).upper);
}

double CalcAngle(const Quat& a, const Quat& b) {
  const Quat q = glm::conjugate(a) * b;
  return 2 * std::atan2(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z), std::abs(q.w));
}

/// Returns the bounding box of the tool at a pose.
Box3 CalcToolBox(const Tool& tool, const Pose& X) {
  Vec3 half(CalcReach(tool));
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    const Vec3 n = X.Vector({0, 0, 1});
    for (int i = 0; i < 3; ++i) {
      half[i] =
          disc->radius_mm() * std::sqrt(std::max(0.0, 1 - n[i] * n[i])) + 0.5 * disc->thickness_mm * std::abs(n[i]);
    }
  }
  return {X.p_AB - half, X.p_AB + half};
}

void Include(Box3& box, const Box3& other) {
  box.Include(other.lower);
  box.Include(other.upper);
}

}  // namespace

Box3 CalcCutBox(const Tool& tool, const Pose& from, const Pose& to, int substeps, double voxel_mm) {
  Box3 box;
  if (CalcAngle(from.R_AB, to.R_AB) < 1e-3) {
    Include(box, CalcToolBox(tool, from));
    Include(box, CalcToolBox(tool, to));
  } else {
    const Vec3 reach(CalcReach(tool));
    box.Include(from.p_AB - reach);
    box.Include(from.p_AB + reach);
    box.Include(to.p_AB - reach);
    box.Include(to.p_AB + reach);
  }
  // The margin is the band plus the sideways distance that the substeps may have moved the tool: half a voxel each, and
  // a quarter along the spindle.
  return box.Grown((3.01 + 0.75 * substeps) * voxel_mm + 1e-3 * CalcReach(tool));
}

// ---- the bone

struct BoneWitness::State {
  Bone bone;  // as it was; a field must not outlive it
  std::vector<Box3> boxes;
};

BoneWitness::BoneWitness(const Bone& bone) : state_(std::make_unique<State>()) {
  state_->bone = bone;
}
BoneWitness::~BoneWitness() = default;

void BoneWitness::Allow(const Box3& box) {
  state_->boxes.push_back(box);
}

std::string BoneWitness::Compare(const Bone& bone) {
  Bone now = bone;
  const BoneField was_field(state_->bone, 0);
  const BoneField now_field(now, 0);
  const double h = bone.voxel_mm();
  const LeafIndex low = was_field.lowest();
  const LeafIndex high = was_field.highest();
  std::string wrong;
  for (int x = low.x; x <= high.x && wrong.empty(); ++x) {
    for (int y = low.y; y <= high.y && wrong.empty(); ++y) {
      for (int z = low.z; z <= high.z && wrong.empty(); ++z) {
        const float* before = was_field.Read({x, y, z});
        const float* after = now_field.Read({x, y, z});
        if (std::equal(before, before + BoneField::kLeafVoxels, after)) continue;
        for (int i = 0; i < BoneField::kLeafVoxels; ++i) {
          if (after[i] == before[i]) continue;
          if (!(after[i] > before[i])) {
            wrong = fmt::format("I5: phi falls from {} to {}", before[i], after[i]);
            break;
          }
          const Vec3 p = was_field.p_WF_mm() + h * Vec3(8 * x + i / 64, 8 * y + i / 8 % 8, 8 * z + i % 8);
          const bool allowed = std::any_of(state_->boxes.begin(), state_->boxes.end(), [&](const Box3& box) {
            return glm::all(glm::greaterThanEqual(p, box.lower)) && glm::all(glm::lessThanEqual(p, box.upper));
          });
          if (!allowed) {
            wrong = fmt::format("I6: phi rises from {} to {} at {} {} {}, where the tool never was", before[i],
                                after[i], p.x, p.y, p.z);
            break;
          }
        }
      }
    }
  }
  state_->boxes.clear();
  state_->bone = std::move(now);
  return wrong;
}

// ---- the saw

struct FuzzedSaw::State {
  explicit State(const FuzzScene& scene)
      : simulation(MakeComparedSimulation(scene.bone, scene.params, scene.start)),
        params(scene.params),
        h(scene.voxel_mm),
        invariants(simulation, scene.start, {.watch_bone = false, .report = false}),
        witness(scene.bone),
        volume_mm3(scene.bone.CalcVolume()) {
    last.X_WT = scene.start;
  }

  std::string Tick(const CoupledInput& in);
  std::string CheckRefused(const Pose& X_before, const CoupledOutput& out) const;
  std::string CheckStatus(const CoupledInput& in, const CoupledOutput& out) const;
  void Watch(const Pose& X_before, const CoupledInput& in, const CoupledOutput& out);
  void Note(const CoupledOutput& out);

  CoupledSimulation simulation;
  CoupledParams params;
  double h;
  Invariants invariants;
  BoneWitness witness;
  double volume_mm3;
  CoupledOutput last;
  std::uint64_t hash = 0;
  Counts counts;
  bool slab_asked = false;
  Box3 box;  // region that the tool may have cut since the last Allow()
  int ticks_in_box = 0;
};

FuzzedSaw::FuzzedSaw(const FuzzScene& scene) : state_(std::make_unique<State>(scene)) {}
FuzzedSaw::~FuzzedSaw() = default;
const Pose& FuzzedSaw::X_WT() const {
  return state_->last.X_WT;
}
const CoupledOutput& FuzzedSaw::last() const {
  return state_->last;
}
std::uint64_t FuzzedSaw::hash() const {
  return state_->hash;
}
const FuzzedSaw::Counts& FuzzedSaw::counts() const {
  return state_->counts;
}

std::string FuzzedSaw::State::CheckRefused(const Pose& X_before, const CoupledOutput& out) const {
  if (out.status != kCoupledBadPose) return fmt::format("bad input, but status {}", out.status);
  if (out.X_WT.p_AB != X_before.p_AB || out.X_WT.R_AB != X_before.R_AB) return "bad input moves the tool";
  if (out.f_H_W_N != Vec3(0) || out.tau_H_W_Nmm != Vec3(0)) return "bad input gives a force";
  if (out.removed_mm3 != 0 || out.hand_mJ != 0 || out.spindle_mJ != 0 || out.stored_mJ != 0 || out.numerical_mJ != 0) {
    return "bad input does work";
  }
  return "";
}

/// Checks the status bits of a tick, which the invariants do not cover.
std::string FuzzedSaw::State::CheckStatus(const CoupledInput& in, const CoupledOutput& out) const {
  if ((out.status & kCoupledBadPose) != 0) return "a good input is refused";
  if (out.status >= 2 * kCoupledNoTime) return "undefined status bits";
  const bool no_time = in.dt_s < 1e-6;
  if (no_time != ((out.status & kCoupledNoTime) != 0)) return "wrong no-time status";
  if (no_time) return "";
  const bool stopped = std::abs(in.rpm) < 1;
  if (stopped != ((out.status & kCoupledSpindleStopped) != 0)) return "the spindle's status is wrong";
  const auto* disc = std::get_if<DiscSaw>(&params.tool);
  if (disc && out.engaged_teeth > disc->teeth * (1 + 1e-9))
    return fmt::format("{} teeth are engaged", out.engaged_teeth);
  return "";
}

void FuzzedSaw::State::Watch(const Pose& X_before, const CoupledInput& in, const CoupledOutput& out) {
  if (std::abs(in.rpm) >= 1 || slab_asked) Include(box, CalcCutBox(params.tool, X_before, out.X_WT, out.substeps, h));
  // Bone that the slab passed is removed later, along a path with fewer poses, so a single box covers all of it.
  if (++ticks_in_box < kTicksInBox || slab_asked) return;
  if (!box.empty()) witness.Allow(box);
  box = {};
  ticks_in_box = 0;
}

void FuzzedSaw::State::Note(const CoupledOutput& out) {
  for (const double value : {out.f_H_W_N.x, out.f_H_W_N.y, out.f_H_W_N.z, out.tau_H_W_Nmm.x, out.X_WT.p_AB.z,
                             out.removed_mm3, out.numerical_mJ}) {
    hash = std::rotl(hash, 5) ^ std::bit_cast<std::uint64_t>(value);
  }
  hash ^= out.status;
  ++counts.ticks;
  counts.touched += out.f_H_W_N != Vec3(0);
  counts.refused += (out.status & kCoupledBadPose) != 0;
  counts.cut += out.removed_mm3 > 0;
  counts.used_up += (out.status & kCoupledSubstepsUsedUp) != 0;
  counts.unsolved += (out.status & kCoupledIterationsUsedUp) != 0;
  counts.out_of_leaves += (out.status & kCoupledLeavesUsedUp) != 0;
  counts.slab += out.fidelity == Fidelity::kSlab;
}

std::string FuzzedSaw::State::Tick(const CoupledInput& in) {
  const Pose X_before = last.X_WT;
  const HeapUseCounter heap;
  {
    const HeapGuard guard;
    last = simulation.Tick(in);
  }
  Note(last);
  if (heap.count() != 0) return fmt::format("{} heap calls in the tick", heap.count());
  if (!IsGood(params.tool, in)) {
    std::string wrong = CheckRefused(X_before, last);
    if (!wrong.empty()) return wrong;
  }
  if (IsGood(params.tool, in)) {
    if (in.dt_s >= 1e-6) Watch(X_before, in, last);
    std::string wrong = CheckStatus(in, last);
    if (!wrong.empty()) return wrong;
  }
  invariants.Tick(in, last);
  return invariants.ok() ? "" : invariants.violations().begin()->second;
}

std::string FuzzedSaw::Do(const FuzzCall& call) {
  State& s = *state_;
  switch (call.kind) {
    case FuzzCall::Kind::kTick:
      return s.Tick(call.in);
    case FuzzCall::Kind::kSetDown: {
      const Pose& X = call.in.X_WH;
      const bool good = std::abs(std::pow(glm::length(X.R_AB), 2) - 1) <= 2e-6 && IsInWorld(X.p_AB);
      if (s.simulation.SetDown(X) != good) return good ? "a good pose is refused" : "a bad pose is accepted";
      if (!good) return "";
      s.last.X_WT = WithUnitRotation(X);
      s.invariants.SetDown(X);
      return "";
    }
    case FuzzCall::Kind::kRefill:
      s.simulation.Refill();
      return "";
    case FuzzCall::Kind::kFidelity:
      s.simulation.SetFidelity(call.fidelity);
      s.slab_asked = s.slab_asked || call.fidelity == Fidelity::kSlab;
      return "";
    case FuzzCall::Kind::kAccount:
      return Account();
  }
  return "";
}

std::string FuzzedSaw::Account() {
  State& s = *state_;
  const auto by_region = s.simulation.CalcRemovedByRegion();
  double removed = 0;
  for (const double r : by_region) {
    if (!(r >= -1e-9 * s.volume_mm3)) return fmt::format("I4: {} mm3 removed from a region", r);
    removed += r;
  }
  const Bone& bone = s.simulation.UpdateBone();
  const double left = bone.CalcVolume();
  if (!(std::abs(s.volume_mm3 - left - removed) <= 1e-9 * s.volume_mm3)) {
    return fmt::format("I4: {} mm3 at the start, {} left, {} removed", s.volume_mm3, left, removed);
  }
  if (!s.box.empty()) s.witness.Allow(s.box);
  if (!s.slab_asked) s.box = {};
  s.ticks_in_box = 0;
  return s.witness.Compare(bone);
}

}  // namespace kerf::test
