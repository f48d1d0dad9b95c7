#include "experiment/study/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>

#include "base/core/percentiles.h"
#include "bone/vdb/bonefile.h"
#include "experiment/study/case_run.h"
#include "experiment/study/errors.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::array<double, 9> kVoxels_mm = {0.4, 0.3, 0.2, 0.15, 0.125, 0.1, 0.08, 0.0667, 0.05};
constexpr double kMinVoxelOfMandible_mm = 0.1;  // a whole mandible with finer voxels takes gigabytes
constexpr double kMaxBudgetRatio = 2;           // if a candidate takes this many times the budget, finer voxels are not
                                                // tried, since they would only be slower
constexpr double kReferenceTolerance = 0.005;
constexpr double kBeforeContact_s = 0.05;
constexpr double kLongest_s = 120;  // maximum duration of a path whose errors are measured over its whole length
constexpr double kHandLag_s = 3;    // time within which a tool follows a handle that has left the bone
constexpr int kMaxAgain = 3;

/// Returns true if the tool, exactly on the path, touches the uncut bone. Tests points on circles about its axis that
/// are so close together that no wall of bone fits between them.
bool IsInContact(const StudyPath& path, Holding holding, double t_s) {
  constexpr int kPoints = 48, kCircles = 10;
  const Pose X_WT = path.pose(holding, t_s);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    const Vec3 rim_T = path.saw.radius_mm() * Vec3(std::cos(angle), std::sin(angle), 0);
    for (int circle = kCircles; circle >= 0; --circle) {
      const double fraction = static_cast<double>(circle) / kCircles;
      if (path.solid.distance_mm(X_WT.Point(fraction * rim_T)) < 0) return true;
    }
  }
  return false;
}

/// Returns the first time not before `from_s` at which the tool touches the bone (or does not, if `touches` is false);
/// the end of the path if there is none.
double FindContact(const StudyPath& path, Holding holding, double from_s, bool touches) {
  constexpr double kStep_s = 0.002;
  for (double t_s = from_s; t_s < path.duration_s; t_s += kStep_s) {
    if (IsInContact(path, holding, t_s) == touches) return t_s;
  }
  return path.duration_s;
}

/// Returns the last time at which the tool touches the bone; `from_s` if there is no contact after it.
double FindLastContact(const StudyPath& path, Holding holding, double from_s) {
  constexpr double kStep_s = 0.002;
  for (double t_s = path.duration_s; t_s > from_s; t_s -= kStep_s) {
    if (IsInContact(path, holding, t_s)) return t_s;
  }
  return from_s;
}

StudyPath CutOut(const StudyPath& path, double from_s, double to_s) {
  StudyPath part = path;
  part.duration_s = to_s - from_s;
  // The last tick may end slightly after this part, at a time when the path's next stroke has already begun elsewhere.
  part.pose = [pose = path.pose, from_s, to_s](Holding holding, double t_s) {
    return pose(holding, std::min(from_s + t_s, to_s));
  };
  part.lifts_s.clear();
  for (const double lift_s : path.lifts_s) {
    if (lift_s >= from_s && lift_s < to_s) part.lifts_s.push_back(lift_s - from_s);
  }
  return part;
}

/// Determines the part of the path in which errors are measured.
void SetExtent(const StudyPath& path, const TuneOptions& options, TuneResult& result) {
  const double contact_s = FindContact(path, options.holding, 0, true);
  if (contact_s >= path.duration_s) throw Error(fmt::format("{}: the tool touches no bone on its path", result.scene));
  result.path_s = path.duration_s;
  result.from_s = std::max(0.0, contact_s - kBeforeContact_s);
  const double lag_s = options.holding == Holding::kHand ? kHandLag_s : kBeforeContact_s;
  // A long time in air after the cut would only make errors and times appear smaller.
  result.to_s = std::min(path.duration_s, FindLastContact(path, options.holding, contact_s) + lag_s);
  if (options.seconds) {
    const double whole_s = result.to_s;
    result.to_s = std::min(whole_s, result.from_s + *options.seconds);
    if (result.to_s < whole_s) result.extent = TuneExtent::kSeconds;
  } else if (result.to_s - result.from_s > kLongest_s) {
    const double out_s = FindContact(path, options.holding, contact_s, false);
    const auto lift = std::upper_bound(path.lifts_s.begin(), path.lifts_s.end(), contact_s);
    const double whole_s = result.to_s;
    result.to_s = std::min({lift == path.lifts_s.end() ? whole_s : *lift, out_s + lag_s, whole_s});
    if (result.to_s < whole_s) result.extent = TuneExtent::kFirstPassage;
  }
  const auto lifted = std::upper_bound(path.lifts_s.begin(), path.lifts_s.end(), result.to_s - 1e-9);
  result.strokes = path.lifts_s.size() + 1;
  result.measured = static_cast<std::size_t>(lifted - path.lifts_s.begin()) + 1;
}

/// Returns for each tick of 1 / rate_hz whether the reference has a tooth in bone at any time during the tick.
std::vector<bool> FindReferenceContact(const StudyReference& reference, double rate_hz, std::size_t count) {
  std::vector<bool> contact(count, false);
  for (std::size_t i = 0; i < reference.ticks.size(); ++i) {
    if (!(reference.ticks[i].engaged_teeth > 0)) continue;
    const double middle_s = (static_cast<double>(i) + 0.5) * reference.tick_s;
    const auto tick = static_cast<std::size_t>(middle_s * rate_hz);
    if (tick < count) contact[tick] = true;
  }
  return contact;
}

/// Computes the error over `count` ticks starting at `first`.
double MeasureContactError(const CasePass& pass, const StudyReference& reference, Holding holding, double rate_hz,
                           std::size_t first, std::size_t count) {
  const std::size_t n = pass.f_W_N.size();
  const std::vector<Vec3> expected = SampleReference(reference, holding, rate_hz, n);
  const std::vector<bool> expected_contact = FindReferenceContact(reference, rate_hz, n);
  const auto part = [&](const std::vector<bool>& all) {
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(first);
    return std::vector<bool>(from, from + static_cast<std::ptrdiff_t>(count));
  };
  return CalcContactError(std::span(pass.f_W_N).subspan(first, count), std::span(expected).subspan(first, count),
                          part(pass.contact), part(expected_contact));
}

/// Computes the accuracy of settings in each phase of the cut.
std::vector<TunePhase> MeasurePhases(const StudyPath& stretch, double from_s, Holding holding,
                                     const StudySettings& settings, const StudyReference& reference) {
  const CasePass pass = RunCasePass(stretch, holding, settings);
  const std::vector<Vec3> expected = SampleReference(reference, holding, settings.rate_hz, pass.f_W_N.size());
  std::vector<TunePhase> phases;
  for (CutPhase phase : FindCutPhases(reference.ticks, reference.tick_s)) {
    const auto tick_at = [&](double t_s) {
      return std::min(pass.f_W_N.size(), static_cast<std::size_t>(std::lround(t_s * settings.rate_hz)));
    };
    const std::size_t first = tick_at(phase.from_s);
    const std::size_t count = tick_at(phase.to_s) - first;
    if (count == 0) continue;
    ErrorFigures errors;
    CalcForceErrors(std::span(pass.f_W_N).subspan(first, count), std::span(expected).subspan(first, count),
                    1 / settings.rate_hz, errors);
    phase.from_s += from_s;
    phase.to_s += from_s;
    const double p95 = MeasureContactError(pass, reference, holding, settings.rate_hz, first, count);
    phases.push_back({std::move(phase), p95, errors.impulse_signed.value_or(0)});
  }
  return phases;
}

double VoxelOf(const Scene& scene) {
  return scene.bone.source == BoneSource::kMandible ? scene.bone.mandible.voxel_mm : scene.bone.block.voxel_mm;
}

/// Measures each candidate once.
class Measuring {
 public:
  Measuring(const StudyPath& timed, const StudyPath& stretch, const StudyReference& reference,
            const TuneOptions& options, TuneResult& result)
      : timed_(timed), stretch_(stretch), reference_(reference), options_(options), result_(result) {}

  TuneCandidate Measure(const StudySettings& settings) const {
    if (options_.stop != nullptr && options_.stop->load()) throw Error("stopped; the scene is unchanged");
    CasePass pass;
    TuneCandidate candidate{settings, RunForErrors(stretch_, result_.holding, settings, reference_, &pass), 0};
    if (candidate.outcome.state != CaseState::kDone) return candidate;
    candidate.force_p95 =
        MeasureContactError(pass, reference_, result_.holding, settings.rate_hz, 0, pass.f_W_N.size());
    CaseOutcome costs = RunForCosts(timed_, result_.holding, settings, options_.ticks, options_.core);
    if (costs.state != CaseState::kDone) {
      candidate.outcome.state = costs.state;
      candidate.outcome.why = costs.why;
    }
    candidate.outcome.costs = std::move(costs.costs);
    return candidate;
  }
  /// Measures the settings unless they have been measured already. Returns their index among the candidates.
  std::size_t Try(const StudySettings& settings) {
    for (std::size_t i = 0; i < result_.candidates.size(); ++i) {
      if (ShowSettings(result_.candidates[i].settings) == ShowSettings(settings)) return i;
    }
    if (options_.progress) {
      options_.progress("measuring settings", static_cast<double>(result_.candidates.size()) / expected_);
    }
    result_.candidates.push_back(Measure(settings));
    return result_.candidates.size() - 1;
  }
  void Expect(std::size_t candidates) { expected_ = static_cast<double>(std::max<std::size_t>(1, candidates)); }

 private:
  const StudyPath& timed_;
  const StudyPath& stretch_;
  const StudyReference& reference_;
  const TuneOptions& options_;
  TuneResult& result_;
  double expected_ = 1;
};

std::vector<double> VoxelsToTry(const Scene& scene, const TuneOptions& options) {
  if (scene.bone.source == BoneSource::kFile) return {};  // the voxel size of the file is fixed
  std::vector<double> voxels(options.voxels_mm);
  if (voxels.empty()) voxels.assign(kVoxels_mm.begin(), kVoxels_mm.end());
  if (scene.bone.source == BoneSource::kMandible) {
    std::erase_if(voxels, [](double voxel_mm) { return voxel_mm < kMinVoxelOfMandible_mm; });
  }
  std::sort(voxels.rbegin(), voxels.rend());
  return voxels;
}

void CheckOptions(const TuneOptions& options) {
  if (!options.budget_us && !options.error) throw Error("give a budget in us, an error, or both");
  CheckParameters(options);
  CheckCore(options.core);
}

void AddNotes(const Scene& scene, const TuneOptions& options, TuneResult& result) {
  if (result.extent != TuneExtent::kWhole) {
    result.notes.push_back(fmt::format(
        "errors are those of {} only{}", DescribeExtent(result),
        result.extent == TuneExtent::kSeconds ? ", and times are those of the whole path" : ", and so are times"));
  }
  if (!scene.effects.empty()) {
    result.notes.emplace_back(
        "these times do not include the scene's effects; add the cost that 'kerf effects SCENE' measures for them");
  }
  if (scene.bone.source == BoneSource::kMandible && VoxelsToTry(scene, options).size() < options.voxels_mm.size()) {
    result.notes.push_back(
        fmt::format("voxels below {:g} mm are not tried, since a whole mandible with them takes minutes and gigabytes",
                    kMinVoxelOfMandible_mm));
  }
  if (scene.bone.source == BoneSource::kFile) {
    result.notes.emplace_back(
        "the bone is a file, so its voxel size is fixed; use 'kerf import --voxel' for other sizes");
  }
}

constexpr double kAsGood = 1.05;  // times the smallest error

/// Returns settings that differ from the given ones in at most one value.
std::vector<StudySettings> Neighbours(const StudySettings& settings) {
  std::vector<StudySettings> all;
  for (const int samples : {2, 4, 8, 16, 32}) {
    all.push_back(settings);
    all.back().rim_samples_per_pitch = samples;
  }
  for (const int substeps : {1, 2, 4}) {
    all.push_back(settings);
    all.back().substeps = substeps;
  }
  for (const int interval : {1, 2, 4}) {
    all.push_back(settings);
    all.back().carve_interval_ticks = interval;
  }
  return all;
}

/// Measures the scene's own settings, other voxel sizes, and the neighbours of the best settings so far.
void TryAll(const Scene& scene, const StudySettings& own, const TuneOptions& options, Measuring& measuring,
            TuneResult& result) {
  const std::vector<double> voxels = VoxelsToTry(scene, options);
  measuring.Expect(1 + voxels.size() + 2 * (Neighbours(own).size() - 3));
  measuring.Try(own);
  for (const double voxel_mm : voxels) {
    StudySettings settings = own;
    settings.voxel_mm = voxel_mm;
    const TuneCandidate& candidate = result.candidates[measuring.Try(settings)];
    if (options.budget_us && candidate.p99_us() > kMaxBudgetRatio * *options.budget_us) break;
  }
  // The first round tries the neighbours of the settings with the best voxel size, the second one those of the best
  // settings found so far.
  for (int round = 0; round < 2; ++round) {
    const std::optional<std::size_t> best = ChooseCandidate(result.candidates, options, result.reference.error_bar);
    const StudySettings about = best ? result.candidates[*best].settings : own;
    for (const StudySettings& settings : Neighbours(about)) measuring.Try(settings);
  }
}

}  // namespace

double TuneCandidate::CalcError(double reference_bar) const {
  return outcome.errors ? std::max(force_p95, reference_bar) : std::numeric_limits<double>::infinity();
}

double CalcContactError(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, const std::vector<bool>& contact,
                        const std::vector<bool>& reference_contact) {
  std::vector<double> relative;
  for (std::size_t i = 0; i < f_N.size(); ++i) {
    if (!contact[i] && !reference_contact[i]) continue;
    relative.push_back(glm::length(f_N[i] - reference_N[i]) / std::max(glm::length(reference_N[i]), kMinForce_N));
  }
  return CalcPercentile(std::move(relative), 0.95);
}

StudySettings SettingsOf(const Scene& scene, Holding holding) {
  StudySettings settings;
  settings.voxel_mm = VoxelOf(scene);
  settings.rim_samples_per_pitch = scene.simulation.rim_samples_per_pitch;
  settings.substeps = scene.simulation.substeps;
  settings.carve_interval_ticks = scene.simulation.carve_interval_ticks;
  settings.rate_hz = holding == Holding::kHand ? scene.loop.rate_hz : scene.simulation.rate_hz;
  settings.law = scene.force.name();
  if (scene.material.kind == MaterialKind::kUniform) settings.material = "uniform";
  if (scene.material.kind == MaterialKind::kCt) settings.material = "ct";
  return settings;
}

std::optional<std::size_t> ChooseCandidate(const std::vector<TuneCandidate>& candidates, const TuneOptions& options,
                                           double reference_bar) {
  std::vector<std::size_t> fit;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const TuneCandidate& c = candidates[i];
    if (!c.done()) continue;
    if (options.budget_us && c.p99_us() > *options.budget_us) continue;
    if (options.error && c.CalcError(reference_bar) > *options.error) continue;
    fit.push_back(i);
    least = std::min(least, c.CalcError(reference_bar));
  }
  std::optional<std::size_t> best;
  for (const std::size_t i : fit) {
    const TuneCandidate& c = candidates[i];
    // If an error limit is given, no further accuracy is needed. Otherwise errors close to the smallest are equivalent:
    // their order is random, while a finer rim and more frequent removals are safer elsewhere on the path.
    if (!options.error && c.CalcError(reference_bar) > kAsGood * least) continue;
    const auto rank = [&](const TuneCandidate& t) {
      return options.error ? std::tuple(0, 0, t.p99_us())
                           : std::tuple(-t.settings.rim_samples_per_pitch, t.settings.carve_interval_ticks, t.p99_us());
    };
    if (!best || rank(c) < rank(candidates[*best])) best = i;
  }
  return best;
}

TuneResult Tune(const std::string& scene_file, const TuneOptions& options) {
  CheckOptions(options);
  const Scene scene = ReadScene(scene_file);
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error(fmt::format("{}: [simulation] mode = \"slab\" has no voxels to tune", scene_file));
  }
  TuneResult result;
  result.scene = scene_file;
  result.holding = options.holding;
  result.machine = ReadRunInfo();
  const auto show = [&](const char* stage, double fraction) {
    if (options.progress) options.progress(stage, fraction);
  };
  show("reading the scene", 0);
  const StudyPath path = MakeScenePath("scene", scene_file);
  StudySettings own = SettingsOf(scene, options.holding);
  if (scene.bone.source == BoneSource::kFile) {
    own.voxel_mm = ReadBone(scene.bone.file).voxel_mm();
  }
  result.rate_hz = own.rate_hz;
  SetExtent(path, options, result);
  AddNotes(scene, options, result);
  const StudyPath stretch = CutOut(path, result.from_s, result.to_s);
  // Ticks are timed on the part in which errors are measured, or on the whole path if `seconds` restricts that part.
  const StudyPath timed = result.extent == TuneExtent::kSeconds ? path : stretch;
  show("computing the reference", 0);
  const StudyReference reference =
      MakeStudyReference(stretch, options.holding, own, kReferenceTolerance, "", options.stop);
  result.reference = reference.record;

  Measuring measuring(timed, stretch, reference, options, result);
  TryAll(scene, own, options, measuring, result);
  // The first measurement may have been lucky, so a second one must confirm it. If it does not, the next best candidate
  // is measured again.
  std::vector<TuneCandidate> left = result.candidates;
  for (int attempt = 0; attempt < kMaxAgain && !result.keeps; ++attempt) {
    const std::optional<std::size_t> best = ChooseCandidate(left, options, reference.record.error_bar);
    if (!best) break;
    show("measuring the chosen settings again", static_cast<double>(attempt) / kMaxAgain);
    result.chosen = best;
    result.again = measuring.Measure(left[*best].settings);
    result.keeps = ChooseCandidate({*result.again}, options, reference.record.error_bar).has_value();
    if (!result.keeps) left[*best].outcome.costs.reset();
  }
  if (result.keeps) {
    result.phases = MeasurePhases(stretch, result.from_s, options.holding, result.again->settings, reference);
  }
  return result;
}

std::vector<SceneEdit> EditsFor(const Scene& scene, Holding holding, const StudySettings& settings) {
  const StudySettings own = SettingsOf(scene, holding);
  std::vector<SceneEdit> edits;
  const auto edit = [&](const char* table, const char* knob) {
    if (ValueOf(own, knob) != ValueOf(settings, knob)) edits.push_back({table, knob, ValueOf(settings, knob)});
  };
  const std::string_view model = ToString(scene.bone.source);
  if (!model.empty()) edit(fmt::format("bone.{}", model).c_str(), "voxel_mm");
  edit("simulation", "rim_samples_per_pitch");
  edit("simulation", "substeps");
  edit("simulation", "carve_interval_ticks");
  return edits;
}

}  // namespace kerf
