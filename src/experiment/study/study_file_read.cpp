// Reads a study file from disk, with the scenes that it lists. study_file.cpp contains the parts that need only the
// text.
#include "base/files/files.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_file.h"
#include "session/run/run_scene.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxStudyBytes = std::size_t{32} << 20;

}  // namespace

StudySpec ReadStudyFile(const std::string& file, const std::vector<std::string>& built_in) {
  StudySpec spec = ParseStudy(ReadTextFile(file, kMaxStudyBytes), file, built_in);
  for (StudyScene& scene : spec.scenes) {
    std::string content = ReadTextFile(scene.file);
    for (const std::string& input : ListInputs(ReadScene(scene.file), scene.file)) {
      if (!input.empty() && !IsSameFile(input, scene.file))
        content += ShowHash(HashText(ReadTextFile(input, std::size_t{8} << 30)));
    }
    scene.content_hash = HashText(content);
  }
  return spec;
}

}  // namespace kerf
