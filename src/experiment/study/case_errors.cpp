// The errors of a case relative to its reference.
#include <algorithm>
#include <cmath>
#include <utility>

#include "experiment/study/case_run.h"
#include "experiment/study/errors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kFinestHeat_mm = 0.05;
constexpr double kBody_C = 37;
constexpr double kMinRise_K = 1;

/// Returns the 95th percentile of the difference over the probes that are warm in either of the two.
double CalcTemperatureError(const std::vector<double>& a_C, const std::vector<double>& b_C) {
  std::vector<double> errors_K;
  for (std::size_t i = 0; i < a_C.size(); ++i) {
    if (!(std::max(a_C[i], b_C[i]) > kBody_C + kMinRise_K)) continue;
    const double error_K = std::abs(a_C[i] - b_C[i]);
    if (std::isfinite(error_K)) errors_K.push_back(error_K);  // where there is no bone, there is no temperature
  }
  if (errors_K.empty()) return 0;
  const auto p95 = errors_K.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(errors_K.size() - 1));
  std::nth_element(errors_K.begin(), p95, errors_K.end());
  return *p95;
}

CaseOutcome Compare(const StudyPath& path, Holding holding, const StudySettings& settings,
                    const StudyReference& reference, CasePass* keep) {
  // Heat needs the tangential force of the teeth, which changes the forces, so these are compared without heat.
  StudySettings plain = settings;
  plain.heat_grid_mm = 0;
  CasePass pass = RunCasePass(path, holding, plain);
  CaseOutcome outcome;
  outcome.force_hash = pass.force_hash;
  outcome.bone_hash = pass.bone_hash;
  ErrorFigures errors;
  const std::vector<Vec3> expected = SampleReference(reference, holding, settings.rate_hz, pass.f_W_N.size());
  CalcForceErrors(pass.f_W_N, expected, 1 / settings.rate_hz, errors);
  if (pass.bone) {
    if (reference.ticks.empty() || !reference.bone) throw Error("the reference is empty");
    errors.volume = CalcVolumeError(pass.removed_mm3, reference.removed_mm3);
    CalcCutSurfaceErrors(*pass.bone, *reference.bone, reference.ticks, path.saw, GetReferenceEdge_mm(holding, path.saw),
                         errors);
  } else {
    // The case removes nothing, but the reference may have removed bone.
    errors.volume = reference.removed_mm3 > 0 ? 1 : 0;
  }
  if (settings.heat_grid_mm > 0) {
    const CasePass warm = RunCasePass(path, holding, settings);
    StudySettings finest = settings;
    finest.heat_grid_mm = kFinestHeat_mm;
    const std::vector<double> truth_C = RunCasePass(path, holding, finest).probe_temperatures_C;
    finest.heat_grid_mm = 2 * kFinestHeat_mm;
    const std::vector<double> coarser_C = RunCasePass(path, holding, finest).probe_temperatures_C;
    errors.temperature_K = CalcTemperatureError(warm.probe_temperatures_C, truth_C);
    // The method is of first order, so the error of the finer grid is about as large as the difference between the two
    // grids.
    errors.temperature_bar_K = CalcTemperatureError(coarser_C, truth_C);
    outcome.force_hash = warm.force_hash;
    outcome.bone_hash = warm.bone_hash;
  }
  outcome.errors = errors;
  if (keep != nullptr) *keep = std::move(pass);
  return outcome;
}

}  // namespace

CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference) {
  return RunForErrors(path, holding, settings, reference, nullptr);
}

CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference, CasePass* pass) {
  CaseOutcome outcome;
  try {
    outcome.why = FindOmission(path, holding, settings);
    if (outcome.why.empty()) return Compare(path, holding, settings, reference, pass);
    outcome.state = CaseState::kOmitted;
  } catch (const Omission& omission) {
    outcome = {};
    outcome.state = CaseState::kOmitted;
    outcome.why = omission.what();
  } catch (const std::exception& error) {
    outcome = {};
    outcome.state = CaseState::kFailed;
    outcome.why = error.what();
  }
  return outcome;
}

}  // namespace kerf
