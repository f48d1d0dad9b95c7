#include "session/scene/path.h"
#include "session/scene/scene.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(scene) {
  Scene scene;
  if (!Accepts([&] { scene = ParseScene(std::string(bytes), "/nowhere/fuzz.toml"); })) return;
  MakeTool(scene);
  MakePath(scene);
  if (scene.simulation.mode == SceneMode::kSlab) Accepts([&] { MakeSlabPlane(scene); });
  // The scene that a run writes into its folder must be equal when it is read back.
  const std::string resolved = ResolvedToml(scene);
  Scene again;
  if (!Accepts([&] { again = ParseScene(resolved, "/nowhere/fuzz.toml"); })) Finding("the resolved scene is refused");
  if (ResolvedToml(again) != resolved) Finding("the resolved scene changes when it is written and read back");
}

}  // namespace kerf::fuzz
