// The references of a study, refined until the remaining changes are negligible.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/core/hash.h"
#include "cut/tool/shape.h"
#include "experiment/reference/check.h"
#include "experiment/study/case_run.h"
#include "experiment/study/errors.h"
#include "experiment/study/reference_store.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kTick_s = 0.00025;
constexpr int kMaxRefinements = 5;
constexpr int kFirstSteps = 1;
constexpr int kFirstRimPoints = 768;
constexpr double kVolumeByCells = 5e-4;  // error of the removed volume that is due to the finest cells of the reference
constexpr std::uint64_t kMethod = 3;     // must be increased whenever the computation of references changes

ExactSolid MakeVariantSolid(const StudyPath& path, const StudySettings& settings) {
  if (settings.material == "ct") {
    if (!path.use_ct) throw Error("the bone has no CT numbers");
    return path.ct_solid;
  }
  ExactSolid solid = path.solid;
  if (settings.material == "uniform") {
    solid.material = [by_region = path.solid.material](const Vec3& p_W) {
      ExactSolid::Material material = by_region(p_W);
      if (material.region == 0) return material;
      material.E_MPa = kUniform_E_MPa;
      material.nu = kUniform_nu;
      return material;
    };
  }
  return solid;
}

std::vector<Pose> MakePoses(const StudyPath& path, Holding holding) {
  const auto count = static_cast<std::size_t>(std::max(1.0, std::round(path.duration_s / kTick_s)));
  std::vector<Pose> poses(count + 1);
  for (std::size_t k = 0; k <= count; ++k) poses[k] = path.pose(holding, kTick_s * static_cast<double>(k));
  return poses;
}

class InputHash {
 public:
  void Add(double value) { hash_ = MixHash(hash_ ^ std::bit_cast<std::uint64_t>(value + 0.0)); }
  void Add(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) Add(v[axis]);
  }
  void Add(std::string_view text) {
    for (const char c : text) hash_ = MixHash(hash_ ^ static_cast<unsigned char>(c));
    hash_ = MixHash(hash_ ^ text.size());
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = MixHash(kMethod);
};

/// Returns a hash of all inputs of a reference. The solid, which is a function, is sampled on a lattice.
std::uint64_t HashInput(const StudyPath& path, Holding holding, const ReferenceParams& params, const ExactSolid& solid,
                        const std::vector<Pose>& poses) {
  InputHash hash;
  for (const Pose& X : poses) {
    hash.Add(X.p_AB);
    hash.Add(Vec3(X.R_AB.x, X.R_AB.y, X.R_AB.z));
    hash.Add(X.R_AB.w);
  }
  const DiscSaw& saw = params.saw;
  for (const double value :
       {saw.diameter_mm, saw.thickness_mm, static_cast<double>(saw.teeth), saw.E_MPa, saw.nu, params.rpm, params.tick_s,
        params.fineness.edge_mm, params.fineness.flat_spacing_mm, params.fineness.look_ahead_mm}) {
    hash.Add(value);
  }
  hash.Add(std::string_view(params.law.name()));
  for (const double value : params.law.values()) hash.Add(value);
  for (const std::size_t k : params.set_downs) hash.Add(static_cast<double>(k));
  hash.Add(ToString(holding));
  if (holding == Holding::kHand) {
    const CouplingParams& c = params.coupling;
    hash.Add(c.p_TC_mm);
    for (const double value : {c.stiffness_N_per_mm, c.damping_Ns_per_mm, c.torsion_Nmm_per_rad, c.torsion_damping_Nmms,
                               c.max_force_N, c.max_torque_Nmm}) {
      hash.Add(value);
    }
  }
  const ToothForce law = MakeToothForce(params.law, saw);
  if (law.HasCutting()) {
    hash.Add(saw.rake_deg);
    hash.Add(saw.edge_radius_um);
  }
  if (law.table != nullptr) {
    for (const std::vector<ForceTable::Row>& rows : law.table->rows()) {
      for (const ForceTable::Row& row : rows) {
        for (const double value : {row.bite_mm, row.thrust_N_per_mm, row.cutting_N_per_mm}) hash.Add(value);
      }
    }
  }
  const bool reads_tissue = (law.reads & kReadsTissue) != 0;
  constexpr int kSamples = 20;
  for (int i = 0; i < kSamples * kSamples * kSamples; ++i) {
    const Vec3 fraction((i % kSamples + 0.5) / kSamples, (i / kSamples % kSamples + 0.5) / kSamples,
                        (i / kSamples / kSamples + 0.5) / kSamples);
    const Vec3 p_W = path.bounds_W.lower + fraction * path.bounds_W.size();
    const double distance_mm = solid.distance_mm(p_W);
    hash.Add(distance_mm);
    if (distance_mm > 0) continue;
    const ExactSolid::Material material = solid.material(p_W);
    hash.Add(static_cast<double>(material.region));
    hash.Add(material.E_MPa);
    hash.Add(material.nu);
    if (reads_tissue) hash.Add(static_cast<double>(material.tissue));
  }
  return hash.value();
}

/// Returns the exact bone after the motion of the ticks. It is the same whether the ticks were computed or read from a
/// file.
std::shared_ptr<const ExactBone> SweepBone(ExactSolid solid, const ReferenceParams& params, Holding holding,
                                           const Pose& X_start, const std::vector<ReferenceTick>& ticks) {
  auto bone = std::make_shared<ExactBone>(std::move(solid), params.saw);
  if (holding == Holding::kHand) bone->Sweep(X_start, X_start, 0);  // as in the computation, RunReferenceInHand()
  Pose X_before = X_start;
  std::size_t k = 0;
  for (const ReferenceTick& tick : ticks) {
    if (!reference::IsSetDown(params, ++k)) {
      bone->Sweep(X_before, tick.X_WT, GetReferenceEdge_mm(holding, params.saw));
    }
    X_before = tick.X_WT;
  }
  return bone;
}

std::vector<Vec3> TakeForces(const std::vector<ReferenceTick>& ticks) {
  std::vector<Vec3> forces;
  forces.reserve(ticks.size());
  for (const ReferenceTick& tick : ticks) forces.push_back(tick.f_W_N);
  return forces;
}

std::vector<ReferenceTick> WorkOut(Holding holding, const ReferenceParams& params, const ExactSolid& solid,
                                   const std::vector<Pose>& poses, const std::atomic<bool>* stop) {
  if (holding == Holding::kPath) return RunReferenceOnPath(solid, params, poses, stop).ticks;
  return RunReferenceInHand(solid, params, poses, stop).ticks;
}

}  // namespace

double GetReferenceEdge_mm(Holding holding, const DiscSaw& saw) {
  // This is the value in the simulation in the limit of vanishing voxels.
  return holding == Holding::kHand ? CalcToothSide(saw.radius_mm(), 0) : 0;
}

std::string VariantOf(const StudySettings& settings) {
  const StudySettings base;
  std::string variant;
  // The law is that of studies made when it was the default, so that their records are still found.
  if (settings.law != "hertz_chip") variant += "law=" + settings.law;
  if (settings.material != base.material)
    variant.append(variant.empty() ? "" : ",").append("material=").append(settings.material);
  return variant;
}

StudyReference MakeStudyReference(const StudyPath& path, Holding holding, const StudySettings& settings,
                                  double tolerance, const std::string& file, const std::atomic<bool>* stop) {
  ReferenceParams params;
  params.saw = path.saw;
  params.fineness.edge_mm = CalcToothSide(path.saw.radius_mm(), 0);
  params.law = MakeCaseLaw(path, settings);
  params.rpm = path.rpm;
  params.tick_s = kTick_s;
  params.coupling = path.coupling;
  const ExactSolid solid = MakeVariantSolid(path, settings);
  const std::vector<Pose> poses = MakePoses(path, holding);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double start_s = kTick_s * static_cast<double>(k - 1);
    if (HasLift(path, start_s, start_s + kTick_s)) params.set_downs.push_back(k);
  }
  const std::uint64_t input_hash = HashInput(path, holding, params, solid, poses);

  StudyReference reference;
  const auto finish = [&] {
    reference.record.holding = holding;
    reference.record.path = path.name;
    reference.record.variant = VariantOf(settings);
    reference.bone = SweepBone(solid, params, holding, poses.front(), reference.ticks);
    return reference;
  };
  std::string damaged;
  if (!file.empty()) {
    try {
      std::optional<StudyReference> stored = ReadStudyReference(file, input_hash);
      // A stored reference with a note did not converge, although it had the maximum refinement.
      if (stored && (stored->record.error_bar <= tolerance || !stored->record.note.empty())) {
        reference = *std::move(stored);
        return finish();
      }
    } catch (const Error& error) {
      damaged = fmt::format("computed again: {}", error.what());
    }
  }

  const auto start = std::chrono::steady_clock::now();
  bool converged = false;
  for (int refinement = 0; refinement < kMaxRefinements && !converged; ++refinement) {
    params.fineness.steps_per_tick = kFirstSteps << refinement;
    params.fineness.rim_points = kFirstRimPoints << refinement;
    std::vector<ReferenceTick> ticks = WorkOut(holding, params, solid, poses, stop);
    if (refinement > 0) {
      ErrorFigures change;
      CalcForceErrors(TakeForces(reference.ticks), TakeForces(ticks), kTick_s, change);
      reference.record.error_bar = change.force_p95;
      reference.record.error_bar_l2 = change.force_l2;
      reference.record.volume_bar = CalcVolumeError(reference.ticks.back().removed_mm3, ticks.back().removed_mm3);
      converged = change.force_p95 <= tolerance;
    }
    reference.ticks = std::move(ticks);
    reference.record.steps_per_tick = params.fineness.steps_per_tick;
  }
  reference.tick_s = kTick_s;
  ReferenceRecord& record = reference.record;
  record.input_hash = input_hash;
  for (const ReferenceTick& tick : reference.ticks) record.force_hash = MixForce(record.force_hash, tick.f_W_N);
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!converged) record.note = fmt::format("still changed by {:.2g} in the last refinement", record.error_bar);
  reference.removed_mm3 = reference.ticks.back().removed_mm3;
  record.volume_bar = std::max(record.volume_bar, kVolumeByCells);
  if (!file.empty()) WriteStudyReference(reference, file);
  if (!damaged.empty()) record.note = record.note.empty() ? damaged : record.note + "; " + damaged;
  return finish();
}

}  // namespace kerf
