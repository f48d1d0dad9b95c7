// Reads a study file from disk, with the scenes that it lists. study_file.cpp contains the parts that need only the
// text.
#include <fmt/format.h>

#include "base/files/files.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_file.h"
#include "kerf/error.h"
#include "session/run/run_scene.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxStudyBytes = std::size_t{32} << 20;

}  // namespace

StudySpec ReadStudyFile(const std::string& file, const std::vector<std::string>& built_in) {
  StudySpec spec = ParseStudy(ReadTextFile(file, kMaxStudyBytes), file, built_in);
  const StudyScene* with_law = nullptr;
  for (StudyScene& scene : spec.scenes) {
    std::string content = ReadTextFile(scene.file);
    const Scene read = ReadScene(scene.file);
    if (!spec.names_law) {
      if (with_law != nullptr && spec.base.law != read.force.name()) {
        throw Error(fmt::format("{}: the scenes \"{}\" and \"{}\" name the laws {} and {}; name one in [base]", file,
                                with_law->name, scene.name, spec.base.law, read.force.name()));
      }
      spec.base.law = read.force.name();
      with_law = &scene;
    }
    for (const std::string& input : ListInputs(read, scene.file)) {
      if (!input.empty() && !IsSameFile(input, scene.file))
        content += ShowHash(HashText(ReadTextFile(input, std::size_t{8} << 30)));
    }
    scene.content_hash = HashText(content);
  }
  return spec;
}

}  // namespace kerf
