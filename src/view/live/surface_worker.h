// Thread that keeps the drawn surface up to date with the bone as it is cut.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "view/live/bone_chunks.h"
#include "view/live/camera.h"
#include "view/live/slice_view.h"

namespace kerf {

struct SurfaceCounts {
  std::size_t chunks = 0;          // meshed so far, at all steps
  std::size_t first_left = 0;      // chunks still to be meshed in the initial passes, summed over all steps
  std::size_t leaves_waiting = 0;  // offered but not applied yet
  std::size_t dirty = 0;           // chunks to be remeshed
};

/// Meshes the bone in a thread of its own. The thread that reads the loop's leaves calls Offer(); the drawing thread
/// calls Fetch(). Offer() holds a lock only while copying. Waiting leaves are merged by position, so their number is
/// bounded by the size of the bone.
class SurfaceWorker {
 public:
  /// `bone`: a copy from before the loop begins. `threads`: for the first meshing; 0: one per core. `before`: the bone
  /// before any cutting, whose surface counts as uncut; null: `bone` itself.
  explicit SurfaceWorker(Bone bone, int threads = 0, const Bone* before = nullptr);
  ~SurfaceWorker();  // stops the thread
  SurfaceWorker(const SurfaceWorker&) = delete;
  SurfaceWorker& operator=(const SurfaceWorker&) = delete;

  Vec3 origin_W() const;  // origin of the chunks' vertices
  Box3 bounds_W() const;  // of the original bone
  /// Returns the bounds of all that may be drawn: undo may show the bone before any cutting again.
  Box3 drawn_bounds_W() const;
  bool has_hu() const;
  /// Queues a changed leaf. May be called by any thread.
  void Offer(const LeafMessage& leaf);
  /// Removes and returns at most `at_most` finished chunks, oldest first; only the latest mesh of each chunk and step.
  /// After the first picture, waits until the leaves that were offered before the previous call are meshed, but no
  /// longer than `longest_wait`. Called once a frame, it therefore returns the chunk of a changed leaf by the second
  /// frame after the change, unless there is more work than fits into that time or more than `at_most` chunks wait.
  /// An upload takes about 10 us. May be called by any thread.
  std::vector<ChunkMesh> Fetch(std::size_t at_most = 1024,
                               std::chrono::milliseconds longest_wait = std::chrono::milliseconds(50));
  SurfaceCounts counts() const;
  /// Returns true if the surface of the first picture (the coarse step of all chunks) is available to Fetch().
  bool first_done() const;
  /// Blocks until all offered leaves have been meshed at the wanted resolution.
  void WaitIdle();
  /// Blocks until the surface of the first picture is available.
  void WaitFirst();

  /// Sets the nerve canal and the teeth, whose outlines are added to slices from now on.
  void SetInnerSurfaces(std::shared_ptr<const InnerSurfaces> inner);
  /// Sets the whole CT, which slices show from now on; an empty function: only the bone's own CT numbers.
  void SetCt(CtSource ct);
  /// Requests a slice for one of several views; replaces the view's waiting request. Slices are computed between
  /// chunks. A bone without CT numbers is shown by its tissues. Throws Error if a value of the spec is out of range.
  void RequestSlice(int view, const SliceSpec& spec);
  /// Returns the finished slices that have not been fetched yet, by view.
  std::map<int, SliceImage> FetchSliceImages();
  /// Requests the lines in which planes meet the bone's current surface; replaces the waiting request.
  void RequestPlaneLines(std::vector<PlaneOverlay> planes);
  /// Returns the latest finished lines, in the planes' colours, unless they have already been fetched.
  std::optional<std::vector<PlaneLineOverlay>> FetchPlaneLines();
  /// Returns the first intersection of a ray with the bone. May wait about a millisecond for the chunk that is being
  /// meshed.
  std::optional<Vec3> Pick(const Ray& ray) const;
  /// Returns a copy of the bone in its drawn state.
  Bone CopyBone() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
