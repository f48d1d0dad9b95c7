#include "experiment/study/study_work.h"

namespace kerf {

StudyWork MakeStudyWork(const std::string& data_folder, const std::string& cache_folder) {
  StudyWork work;
  work.make_paths = [=](const std::vector<std::string>& names) {
    return MakeStudyPaths(names, data_folder, cache_folder);
  };
  work.make_scene_path = [](const StudyScene& scene) { return MakeScenePath(scene.name, scene.file); };
  work.variant_of = VariantOf;
  work.make_reference = MakeStudyReference;
  work.run_for_errors = [](const StudyPath& path, Holding holding, const StudySettings& settings,
                           const StudyReference& reference) {
    return RunForErrors(path, holding, settings, reference);
  };
  work.run_for_costs = RunForCosts;
  return work;
}

}  // namespace kerf
