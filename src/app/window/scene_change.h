// Change of the scene, such as another saw, with which a rehearsal continues in a new session.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "session/scene/scene.h"

namespace kerf {

/// Scene and bone with which the new session begins.
struct ChangedScene {
  Scene scene;
  std::string path_csv;  // content of scene.path.file
  std::shared_ptr<const Bone> bone;
};

/// At most one change is pending. It is requested while a session runs, made when that session has ended, and finished
/// when the new one runs.
class SceneChange {
 public:
  /// `what`: message for the user once the change is finished.
  void Request(const std::string& what, std::function<void(Scene&)> apply);
  bool is_pending() const { return pending_.has_value(); }
  /// Makes the change in another thread. `bone`: at the end of the session; `X_WT`: pose of the saw then. The new scene
  /// refers to the file FOLDER/bone-`session`.vdb, which is not written here, and begins with the saw of
  /// KeepEdge().
  void Make(Scene scene, std::shared_ptr<const Bone> bone, const Pose& X_WT, const std::string& folder, int session);
  bool is_making() const { return making_.valid(); }
  /// Returns the result of Make() when it is ready. Throws Error if the path of the new scene cannot be written.
  std::optional<ChangedScene> Take();
  /// Ends the change and returns its message.
  std::string Finish();
  void Drop() { pending_.reset(); }

 private:
  struct Pending {
    std::string what;
    std::function<void(Scene&)> apply;
  };
  std::optional<Pending> pending_;
  std::future<ChangedScene> making_;
};

}  // namespace kerf
