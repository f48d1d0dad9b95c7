#include "app/window/scene_change.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "app/window/is_ready.h"
#include "app/window/keep_edge.h"
#include "base/files/files.h"
#include "session/scene/path_csv.h"

namespace kerf {

void SceneChange::Request(const std::string& what, std::function<void(Scene&)> apply) {
  pending_ = Pending{.what = what, .apply = std::move(apply)};
}

void SceneChange::Make(Scene scene, std::shared_ptr<const Bone> bone, const Pose& X_WT, const std::string& folder,
                       int session) {
  making_ = std::async(std::launch::async, [scene = std::move(scene), X_WT, folder, session, apply = pending_->apply,
                                            bone = std::move(bone)]() mutable {
    namespace fs = std::filesystem;
    scene.bone.source = BoneSource::kFile;
    scene.bone.file = fs::absolute(fmt::format("{}/bone-{}.vdb", folder, session)).string();
    const Tool before = MakeTool(scene);
    apply(scene);
    const Pose X_clear = KeepEdge(*bone, before, X_WT, MakeTool(scene));
    // The tool starts at the first pose of the path, and the hand continues from there.
    scene.path = {};
    scene.path.poses = {{.time_s = 0, .X_WT = X_clear}, {.time_s = 1, .X_WT = X_clear}};
    scene.path.poses.back().X_WT.p_AB.z += 1;
    const std::string path = fmt::format("{}/path-{}.csv", folder, session);
    std::string csv = FormatPathCsv(scene.path.poses);
    WriteTextFile(path, csv);
    scene.path.file = fs::absolute(path).string();
    return ChangedScene{std::move(scene), std::move(csv), std::move(bone)};
  });
}

std::optional<ChangedScene> SceneChange::Take() {
  if (!IsReady(making_)) return std::nullopt;
  return making_.get();
}

std::string SceneChange::Finish() {
  return std::exchange(pending_, std::nullopt)->what;
}

}  // namespace kerf
