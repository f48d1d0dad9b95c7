// The functions that the engine of a study calls to do the work, so that its tests can replace them with fast ones.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiment/study/case.h"
#include "experiment/study/plan.h"
#include "experiment/study/study_file.h"

namespace kerf {

/// Each may throw Error. All except run_for_costs are called from several threads at once.
struct StudyWork {
  std::function<StudyPathList(const std::vector<std::string>& names)> make_paths;
  std::function<StudyPath(const StudyScene& scene)> make_scene_path;
  VariantFunction variant_of;
  std::function<StudyReference(const StudyPath& path, Holding holding, const StudySettings& settings, double tolerance,
                               const std::string& file, const std::atomic<bool>* stop)>
      make_reference;
  std::function<CaseOutcome(const StudyPath& path, Holding holding, const StudySettings& settings,
                            const StudyReference& reference)>
      run_for_errors;
  std::function<CaseOutcome(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                            std::optional<int> core)>
      run_for_costs;
};

/// Returns the functions of case.h. `data_folder`: as for MakeStudyPaths().
StudyWork MakeStudyWork(const std::string& data_folder, const std::string& cache_folder);

}  // namespace kerf
