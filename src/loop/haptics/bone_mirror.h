// Reader's copy of the loop's bone, for rendering and meshing. The reader never blocks the loop.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

#include "base/core/spsc_ring.h"
#include "kerf/bone.h"
#include "loop/haptics/leaf_stream.h"

namespace kerf {

/// Copy of the loop's bone, updated from a stream of leaves. Used by a single thread other than the loop thread. It
/// lags behind the loop's bone by the leaves that are still waiting in the stream. The two are bit-identical once the
/// tool is at rest and all leaves have been sent and read.
class BoneMirror {
 public:
  /// `bone`: a copy of the loop's bone, made before the loop started.
  BoneMirror(Bone bone, SpscRing<LeafMessage>& stream) : bone_(std::move(bone)), stream_(stream) {}

  /// Applies at most `at_most` of the leaves that have arrived and returns how many were applied. The limit keeps a
  /// reader from delaying its frames.
  std::size_t Update(std::size_t at_most = static_cast<std::size_t>(-1));
  const Bone& bone() const { return bone_; }
  /// Sets the callback that Update() calls for each leaf that it applies.
  void set_listener(std::function<void(const LeafMessage&)> listener) { listener_ = std::move(listener); }

 private:
  Bone bone_;
  SpscRing<LeafMessage>& stream_;
  std::function<void(const LeafMessage&)> listener_;
};

}  // namespace kerf
