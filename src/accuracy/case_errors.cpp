// How far a case is from its reference.
#include <algorithm>
#include <cmath>

#include "accuracy/case_run.h"
#include "accuracy/errors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kFinestHeat_mm = 0.1;

CaseOutcome Compare(const StudyPath& path, Holding holding, const StudySettings& settings,
                    const StudyReference& reference) {
  // What heat needs, the teeth's tangential force, is felt: forces are compared without it.
  StudySettings plain = settings;
  plain.heat_grid_mm = 0;
  const CasePass pass = RunCasePass(path, holding, plain);
  CaseOutcome outcome;
  outcome.force_hash = pass.force_hash;
  outcome.bone_hash = pass.bone_hash;
  ErrorFigures errors;
  const std::vector<Vec3> expected = SampleReference(reference, holding, settings.rate_hz, pass.f_W_N.size());
  CalcForceErrors(pass.f_W_N, expected, 1 / settings.rate_hz, errors);
  if (pass.bone) {
    if (reference.ticks.empty() || !reference.bone) throw Error("the reference is empty");
    errors.volume = CalcVolumeError(pass.removed_mm3, reference.removed_mm3);
    CalcCutSurfaceErrors(*pass.bone, *reference.bone, reference.ticks, path.saw, GetReferenceEdge_mm(holding), errors);
  } else {
    // Nothing is cut where something should be.
    errors.volume = reference.removed_mm3 > 0 ? 1 : 0;
  }
  if (settings.heat_grid_mm > 0) {
    const CasePass warm = RunCasePass(path, holding, settings);
    StudySettings finest = settings;
    finest.heat_grid_mm = kFinestHeat_mm;
    const CasePass truth = RunCasePass(path, holding, finest);
    double worst_K = 0;
    for (std::size_t i = 0; i < warm.hottest_C.size(); ++i) {
      worst_K = std::max(worst_K, std::abs(warm.hottest_C[i] - truth.hottest_C[i]));
    }
    errors.temperature_K = worst_K;
    outcome.force_hash = warm.force_hash;
    outcome.bone_hash = warm.bone_hash;
  }
  outcome.errors = errors;
  return outcome;
}

}  // namespace

CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference) {
  CaseOutcome outcome;
  try {
    outcome.why = FindOmission(path, holding, settings);
    if (outcome.why.empty()) return Compare(path, holding, settings, reference);
    outcome.state = CaseState::kOmitted;
  } catch (const std::exception& error) {
    outcome = {};
    outcome.state = CaseState::kFailed;
    outcome.why = error.what();
  }
  return outcome;
}

}  // namespace kerf
