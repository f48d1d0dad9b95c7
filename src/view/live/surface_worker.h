// The thread that keeps the drawn surface up with the bone that is cut.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "view/live/bone_chunks.h"
#include "view/live/camera.h"
#include "view/live/ct_slices.h"

namespace kerf {

struct SurfaceCounts {
  std::size_t chunks = 0;          // finished so far, of all steps
  std::size_t first_left = 0;      // of the first meshing, still to be done
  std::size_t leaves_waiting = 0;  // offered and not applied yet
  std::size_t dirty = 0;           // chunks to be meshed anew
};

/// Whoever reads the loop's leaves offers them here; the drawing thread fetches finished chunks. Neither waits for
/// meshing: both hold a lock for the time of a copy. Leaves that wait are merged by place, so their number is bounded
/// by the bone's.
class SurfaceWorker {
 public:
  /// `bone`: a copy, as it is before the loop begins. `threads` for the first meshing; 0: as many as there are cores.
  explicit SurfaceWorker(Bone bone, int threads = 0);
  ~SurfaceWorker();  // stops it
  SurfaceWorker(const SurfaceWorker&) = delete;
  SurfaceWorker& operator=(const SurfaceWorker&) = delete;

  Vec3 origin_W() const;  // of the chunks' points
  Box3 bounds_W() const;  // of the bone as it was
  bool has_hu() const;
  /// Any thread.
  void Offer(const LeafMessage& leaf);
  /// Finished chunks, oldest first, at most so many (an upload takes about 10 us); the newest of each only. Any
  /// thread.
  std::vector<ChunkMesh> Fetch(std::size_t at_most = 1024);
  SurfaceCounts counts() const;
  /// The finest step that uncut chunks are meshed at, of BoneChunks::kSteps; 1 from the start. What was cut is at 1
  /// always.
  void Want(int finest_step);
  /// The first picture's surface (the coarse step of all chunks) has been handed to Fetch().
  bool first_done() const;
  /// Until all that was offered has been meshed, as fine as is wanted.
  void WaitIdle();
  /// Until the first picture's surface is done.
  void WaitFirst();

  /// Slices of the CT are worked out between chunks, for the newest pose only. `edge_mm`, `pixels`: of the pictures.
  void AskSlices(const Tool& tool, const Pose& X_WT, double edge_mm, int pixels, const CtWindow& window = {});
  /// The newest that are done and have not been fetched.
  std::optional<CtSlices> FetchSlices();
  /// Where a ray meets the bone. Waits for the chunk that is being meshed, about a millisecond.
  std::optional<Vec3> Pick(const Ray& ray) const;
  /// A copy of the bone as it is drawn.
  Bone CopyBone() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
