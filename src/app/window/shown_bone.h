// The bone in the picture: its surface, which follows the cut, and the structures within it.
#pragma once

#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "app/window/trace.h"
#include "base/core/log_histogram.h"
#include "view/live/surface_worker.h"
#include "view/live/viewport.h"

namespace kerf {

class ShownBone {
 public:
  ShownBone(Viewport& view, Trace& trace) : view_(view), trace_(trace) {}

  // ---- may be called by any thread
  /// Shows another bone from the next Take() on. `final`: a session begins with this bone; otherwise it is a preview,
  /// which the session's bone replaces. `before`: the bone before its cuts, whose surface counts as uncut; null:
  /// `bone`.
  std::shared_ptr<SurfaceWorker> Show(std::shared_ptr<const Bone> bone, bool final, const Bone* before = nullptr);
  /// Returns the bone at the start of the first session; null before that.
  std::shared_ptr<const Bone> at_start() const;
  /// Sets the whole CT of the bone, which slices show; empty: none. Clear() removes it.
  void set_ct(CtSource ct);
  CtSource ct() const;

  // ---- called by the window's thread
  /// Begins to draw the bone that was given to Show(). Returns false if there is none, or if the one that is drawn now
  /// stays until the picture of the next one is ready. `at_once`: it does not stay.
  bool Take(bool at_once = false);
  /// Draws what has changed since the last frame. `uploads`: receives the durations of updating the surface.
  void Update(LogHistogram& uploads);
  /// Removes the bone from the picture.
  void Clear();
  /// Returns the surface; null if no bone is shown.
  const std::shared_ptr<SurfaceWorker>& surface() const { return surface_; }
  /// Returns the structures within the bone; null until they are made.
  const InnerSurfaces* inner() const { return inner_.get(); }

 private:
  struct Made {
    std::shared_ptr<SurfaceWorker> surface;
    std::shared_ptr<const Bone> bone;  // to make the inner surfaces of; null for a preview
    MaterialTable materials;
    double voxel_mm = 0.1;
  };

  Viewport& view_;
  Trace& trace_;
  mutable std::mutex mutex_;  // protects the next three
  CtSource ct_;
  std::optional<Made> made_;
  std::shared_ptr<const Bone> at_start_;
  std::shared_ptr<SurfaceWorker> surface_;
  std::shared_ptr<const InnerSurfaces> inner_;
  std::future<InnerSurfaces> making_inner_;
  std::vector<std::future<InnerSurfaces>> unused_inner_;  // of earlier bones; end by themselves
};

}  // namespace kerf
