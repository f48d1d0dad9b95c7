#include "experiment/study/case_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "base/core/hash.h"
#include "bone/grid/build.h"
#include "cut/effects/heat/heat.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"
#include "session/run/loop_setup.h"

namespace kerf {
namespace {

// A study also converges towards rates that a loop does not reach.
constexpr Range kCaseRateRange_hz{kTickRateRange_hz.lower / 5, 5 * kTickRateRange_hz.upper};
constexpr std::size_t kTicksBetweenRefills = 1024;
constexpr double kHeatPool_MB = 256;  // more than the heated volume of any path
// Maximum deviation of a path from the slab's plane and direction; it is less than a voxel.
constexpr double kInPlane_mm = 0.05;
constexpr double kInPlane_rad = 0.01;

double Sum(const std::array<double, 256>& by_region) {
  double sum = 0;
  for (const double mm3 : by_region) sum += mm3;
  return sum;
}

EffectChoices MakeEffects(const StudySettings& settings) {
  EffectChoices effects;  // empty, or only heat and what it needs, as in a scene that names no other effects
  if (settings.heat_grid_mm > 0) {
    effects.emplace_back("tangential_force");
    effects.emplace_back("heat");
    effects.back().Set("voxel_mm", settings.heat_grid_mm);
    effects.back().Set("max_MB", kHeatPool_MB);
  }
  return effects;
}

SimulationParams MakeParams(const StudyPath& path, const StudySettings& settings) {
  SimulationParams params;
  params.tool = path.saw;
  params.law = MakeCaseLaw(path, settings);
  params.effects = MakeEffects(settings);
  params.rim_samples_per_pitch = settings.rim_samples_per_pitch;
  params.substeps = settings.substeps;
  params.carve_interval_ticks = settings.carve_interval_ticks;
  return params;
}

double FindTemperature_C(const EffectPlan& plan, const Vec3& p_W) {
  const auto* heat = dynamic_cast<const HeatEffect*>(plan.Find("heat"));
  if (!heat) return std::numeric_limits<double>::quiet_NaN();
  if (heat->figures().full) throw Error("the heat grid has too many cells for the memory reserved for it");
  return heat->CalcTemperature(p_W);
}

class HandSubject final : public CaseSubject {
 public:
  HandSubject(const StudyPath& path, const StudySettings& settings, Bone bone)
      : simulation_(MakeSimulation(path, settings, std::move(bone))), dt_s_(1 / settings.rate_hz), rpm_(path.rpm) {
    if (settings.method == "coarse") simulation_.SetFidelity(Fidelity::kCoarse);
  }

  Vec3 Tick(const CaseInput& in) override {
    CoupledInput input;
    input.X_WH = in.X_W;
    input.v_H_W_mm_per_s = in.v_W_mm_per_s;
    input.w_H_W_rad_per_s = in.w_W_rad_per_s;
    input.dt_s = dt_s_;
    input.rpm = rpm_;
    const CoupledOutput out = simulation_.Tick(input);
    status_ |= out.status;
    contact_ = out.engaged_teeth > 0;
    return out.f_H_W_N;
  }
  bool has_contact() const override { return contact_; }
  void SetDown(const Pose& X_W) override {
    if (!simulation_.SetDown(X_W)) throw Error("the handle's pose was refused");
  }
  // In the loop, readers read the changed leaves and clear them between ticks; this does the same.
  void BetweenTicks() override {
    simulation_.ClearChanged();
    if (status_ & kCoupledLeavesUsedUp) throw Error("no spare leaves were left, and the tool stopped at uncut bone");
    if (status_ & kCoupledBadPose) throw Error("the handle's pose was refused");
  }
  double CalcTemperature_C(const Vec3& p_W) override {
    return FindTemperature_C(EffectsOf(std::as_const(simulation_)), p_W);
  }
  double CalcRemoved_mm3() override { return Sum(simulation_.CalcRemovedByRegion()); }
  std::size_t CalcMemoryBytes() override {
    return simulation_.CalcMemoryBytes() + simulation_.UpdateBone().CalcMemoryBytes();
  }
  std::optional<Bone> TakeBone() override { return std::move(simulation_).TakeBone(); }

 private:
  static CoupledSimulation MakeSimulation(const StudyPath& path, const StudySettings& settings, Bone bone) {
    ComparedParams params{{MakeParams(path, settings)}};
    params.coupling = path.coupling;
    params.precision_bits = settings.precision_bits;
    params.spare_leaves = CountSpareLeaves(bone);
    return MakeComparedSimulation(std::move(bone), params, path.pose(Holding::kHand, 0));
  }

  CoupledSimulation simulation_;
  double dt_s_;
  double rpm_;
  std::uint32_t status_ = 0;
  bool contact_ = false;
};

class PathSubject final : public CaseSubject {
 public:
  PathSubject(const StudyPath& path, const StudySettings& settings, Bone bone)
      : simulation_(MakeSimulation(path, settings, std::move(bone))), dt_s_(1 / settings.rate_hz), rpm_(path.rpm) {}

  Vec3 Tick(const CaseInput& in) override {
    const TickOutput out = simulation_.Tick({in.X_W, dt_s_, rpm_});
    status_ |= out.status;
    contact_ = out.engaged_teeth > 0;
    return out.f_T_W_N;
  }
  bool has_contact() const override { return contact_; }
  void SetDown(const Pose& X_W) override {
    if (!simulation_.SetDown(X_W)) throw Error("the tool's pose was refused");
  }
  void BetweenTicks() override {
    simulation_.ClearChanged();
    if (++ticks_ % kTicksBetweenRefills == 0) simulation_.Refill();
    if (status_ & kTickBadPose) throw Error("the tool's pose was refused");
  }
  double CalcTemperature_C(const Vec3& p_W) override {
    return FindTemperature_C(EffectsOf(std::as_const(simulation_)), p_W);
  }
  double CalcRemoved_mm3() override { return Sum(simulation_.CalcRemovedByRegion()); }
  std::size_t CalcMemoryBytes() override { return simulation_.UpdateBone().CalcMemoryBytes(); }
  std::optional<Bone> TakeBone() override { return std::move(simulation_).TakeBone(); }

 private:
  static Simulation MakeSimulation(const StudyPath& path, const StudySettings& settings, Bone bone) {
    return {std::move(bone), MakeParams(path, settings), path.pose(Holding::kPath, 0)};
  }

  Simulation simulation_;
  double dt_s_;
  double rpm_;
  std::uint32_t status_ = 0;
  std::size_t ticks_ = 0;
  bool contact_ = false;
};

/// Returns the line along which a path moves; nullopt if it leaves its plane or its line.
std::optional<Vec3> FindRail(const StudyPath& path, Holding holding) {
  const Pose X_start = path.pose(holding, 0);
  const Vec3 normal = X_start.Vector({0, 0, 1});
  constexpr int kSamples = 200;
  Vec3 furthest(0);
  for (int i = 0; i <= kSamples; ++i) {
    const Pose X = path.pose(holding, path.duration_s * i / kSamples);
    const Vec3 moved = X.p_AB - X_start.p_AB;
    if (std::abs(glm::dot(moved, normal)) > kInPlane_mm) return std::nullopt;
    if (glm::length(glm::cross(X.Vector({0, 0, 1}), normal)) > kInPlane_rad) return std::nullopt;
    if (glm::length(moved) > glm::length(furthest)) furthest = moved;
  }
  if (glm::length(furthest) < 2 * kInPlane_mm) return std::nullopt;
  const Vec3 rail = glm::normalize(furthest - glm::dot(furthest, normal) * normal);
  for (int i = 0; i <= kSamples; ++i) {
    const Vec3 moved = path.pose(holding, path.duration_s * i / kSamples).p_AB - X_start.p_AB;
    if (glm::length(moved - glm::dot(moved, rail) * rail) > kInPlane_mm) return std::nullopt;
  }
  return rail;
}

class SlabSubject final : public CaseSubject {
 public:
  SlabSubject(const StudyPath& path, Holding holding, const StudySettings& settings, const Bone& bone)
      : simulation_(MakeSimulation(path, holding, bone)), dt_s_(1 / settings.rate_hz), rpm_(path.rpm) {}

  Vec3 Tick(const CaseInput& in) override {
    const TickOutput out = simulation_.Tick({in.X_W, dt_s_, rpm_});
    contact_ = out.engaged_teeth > 0;
    return out.f_T_W_N;
  }
  bool has_contact() const override { return contact_; }
  void SetDown(const Pose& X_W) override {
    if (!simulation_.SetDown(X_W)) throw Error("the tool's pose was refused");
  }
  std::size_t CalcMemoryBytes() override { return simulation_.CalcMemoryBytes(); }

 private:
  static SlabSimulation MakeSimulation(const StudyPath& path, Holding holding, const Bone& bone) {
    const Pose X_start = path.pose(holding, 0);
    SlabParams params;
    params.saw = path.saw;
    params.direction_W = *FindRail(path, holding);
    params.reading = PaperReading::kCorrected;
    if (holding == Holding::kHand) {
      params.coupling_N_per_mm = path.coupling.stiffness_N_per_mm;
      params.coupling_damping_Ns_per_mm = path.coupling.damping_Ns_per_mm;
    }
    const CutPlane plane{X_start.p_AB, X_start.Vector({0, 0, 1})};
    return {MakeProfile(bone, plane, params), params, X_start};
  }
  static SlabProfile MakeProfile(const Bone& bone, const CutPlane& plane, const SlabParams& params) {
    try {
      return MakeBoneProfile(bone, plane, params.saw.thickness_mm, params.direction_W, params.saw.radius_mm());
    } catch (const Error& error) {
      throw Omission(error.what());
    }
  }

  SlabSimulation simulation_;
  double dt_s_;
  double rpm_;
  bool contact_ = false;
};

}  // namespace

std::uint64_t MixForce(std::uint64_t hash, const Vec3& f_W_N) {
  for (int axis = 0; axis < 3; ++axis) {
    hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(f_W_N[axis] + 0.0));  // + 0.0 turns -0 into 0
  }
  return hash;
}

std::vector<CaseInput> MakeCaseInputs(const StudyPath& path, Holding holding, double rate_hz) {
  const auto count = static_cast<std::size_t>(std::max(1.0, std::round(path.duration_s * rate_hz)));
  std::vector<CaseInput> inputs(count);
  Pose before = path.pose(holding, 0);
  for (std::size_t k = 0; k < count; ++k) {
    CaseInput& in = inputs[k];
    const double end_s = static_cast<double>(k + 1) / rate_hz;
    in.X_W = path.pose(holding, end_s);
    in.set_down = HasLift(path, static_cast<double>(k) / rate_hz, end_s);
    if (in.set_down) {
      before = in.X_W;
      continue;
    }
    const Vec3& p_T = path.coupling.p_TC_mm;
    in.v_W_mm_per_s = rate_hz * (in.X_W.Point(p_T) - before.Point(p_T));
    Quat turn = in.X_W.R_AB * glm::conjugate(before.R_AB);
    if (turn.w < 0) turn = -turn;
    const Vec3 axis(turn.x, turn.y, turn.z);
    const double sine = glm::length(axis);
    if (sine > 0) in.w_W_rad_per_s = (2 * std::atan2(sine, turn.w) * rate_hz / sine) * axis;
    before = in.X_W;
  }
  return inputs;
}

bool HasLift(const StudyPath& path, double from_s, double to_s) {
  const auto next = std::lower_bound(path.lifts_s.begin(), path.lifts_s.end(), from_s - kSameTime_s);
  return next != path.lifts_s.end() && *next < to_s - kSameTime_s;
}

std::string FindOmission(const StudyPath& path, Holding holding, const StudySettings& settings) {
  if (std::find(path.holdings.begin(), path.holdings.end(), holding) == path.holdings.end()) {
    return fmt::format("the path {} does not support the holding \"{}\"", path.name, ToString(holding));
  }
  if (settings.material == "ct" && !path.use_ct) return "the bone has no CT numbers";
  if (settings.method == "coarse" && holding == Holding::kPath) return "a tool on a prescribed path has no coarse mode";
  if (settings.precision_bits != StudySettings{}.precision_bits && holding == Holding::kPath) {
    return "a tool on a prescribed path stores its distances at full float precision";
  }
  if (settings.method == "slab" && !FindRail(path, holding))
    return "the slab moves along one line, and this path does not";
  if (settings.method == "slab" && settings.heat_grid_mm > 0) return "the slab does not simulate heat";
  return "";
}

ForceLaw MakeCaseLaw(const StudyPath& path, const StudySettings& settings) {
  return settings.law == path.law.name() ? path.law : ForceLaw(settings.law);
}

Bone MakeCaseBone(const StudyPath& path, const StudySettings& settings) {
  Bone bone = path.make_bone(settings.voxel_mm, settings.band_voxels);
  if (settings.material == "uniform") {
    bone.OverrideMaterials(MakeUniformTable(bone.materials(), kUniform_E_MPa, kUniform_nu));
  } else if (settings.material == "ct") {
    if (!path.use_ct) throw Error("the bone has no CT numbers");
    path.use_ct(bone);
  } else if (settings.material != "regions") {
    throw Error(fmt::format("there is no material \"{}\"; the choices are regions, uniform and ct", settings.material));
  }
  RoundDistances(bone, settings.precision_bits);
  return bone;
}

std::unique_ptr<CaseSubject> MakeCaseSubject(const StudyPath& path, Holding holding, const StudySettings& settings,
                                             Bone bone) {
  CheckRange("rate_hz", settings.rate_hz, kCaseRateRange_hz);
  if (settings.method == "slab") return std::make_unique<SlabSubject>(path, holding, settings, bone);
  if (settings.method != "voxel" && settings.method != "coarse") {
    throw Error(fmt::format("there is no method \"{}\"; the choices are voxel, coarse and slab", settings.method));
  }
  if (holding == Holding::kHand) return std::make_unique<HandSubject>(path, settings, std::move(bone));
  return std::make_unique<PathSubject>(path, settings, std::move(bone));
}

std::vector<Vec3> MakeHeatProbes(const StudyPath& path, Holding holding) {
  // These are the diffusion lengths for 2 s and 8 s at a diffusivity of 0.128 mm2/s. At these distances the temperature
  // is smooth.
  constexpr double kBeside_mm[] = {0.5, 1.0};
  constexpr int kTimes = 40, kTurns = 48;
  std::vector<Vec3> probes;
  for (int i = 1; i <= kTimes; ++i) {
    const Pose X = path.pose(holding, path.duration_s * i / kTimes);
    for (int k = 0; k < kTurns; ++k) {
      const double turn_rad = 2 * std::numbers::pi * k / kTurns;
      const Vec3 rim = path.saw.radius_mm() * Vec3(std::cos(turn_rad), std::sin(turn_rad), 0);
      for (const double beside_mm : kBeside_mm) {
        for (const double side : {-1.0, 1.0}) {
          probes.push_back(X.Point(rim + Vec3(0, 0, side * (0.5 * path.saw.thickness_mm + beside_mm))));
        }
      }
    }
  }
  return probes;
}

CasePass RunCasePass(const StudyPath& path, Holding holding, const StudySettings& settings) {
  const std::unique_ptr<CaseSubject> subject = MakeCaseSubject(path, holding, settings, MakeCaseBone(path, settings));
  const std::vector<CaseInput> inputs = MakeCaseInputs(path, holding, settings.rate_hz);
  CasePass pass;
  pass.f_W_N.reserve(inputs.size());
  for (const CaseInput& in : inputs) {
    if (in.set_down) subject->SetDown(in.X_W);
    pass.f_W_N.push_back(in.set_down ? Vec3(0) : subject->Tick(in));
    pass.contact.push_back(!in.set_down && subject->has_contact());
    subject->BetweenTicks();
    pass.force_hash = MixForce(pass.force_hash, pass.f_W_N.back());
  }
  if (settings.heat_grid_mm > 0) {
    for (const Vec3& p_W : MakeHeatProbes(path, holding))
      pass.probe_temperatures_C.push_back(subject->CalcTemperature_C(p_W));
  }
  pass.removed_mm3 = subject->CalcRemoved_mm3();
  pass.bone = subject->TakeBone();
  if (pass.bone) pass.bone_hash = pass.bone->CalcHash();
  return pass;
}

}  // namespace kerf
