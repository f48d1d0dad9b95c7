#include "session/scene/edit_scene.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(edit_scene) {
  const std::vector<SceneEdit> edits{{"bone.block", "voxel_mm", "0.125"}, {"simulation", "substeps", "2"}};
  Accepts([&] { EditScene(std::string(bytes), "/nowhere/fuzz.toml", edits, "a note"); });
}

}  // namespace kerf::fuzz
