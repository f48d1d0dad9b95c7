// A reader's own copy of the bone that the loop cuts, for drawing and meshing: never a moment's wait for the loop.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

#include "base/core/spsc_ring.h"
#include "kerf/bone.h"
#include "loop/haptics/leaf_stream.h"

namespace kerf {

/// One thread, not the loop's. Behind the loop's bone by what waits in the stream; bit-identical to it once the tool
/// rests and all has been sent and read.
class BoneMirror {
 public:
  /// `bone`: a copy of the loop's bone, made before the loop began.
  BoneMirror(Bone bone, SpscRing<LeafMessage>& stream) : bone_(std::move(bone)), stream_(stream) {}

  /// Takes what has come; returns how many leaves. At most `at_most` of them, so that a picture is not kept waiting.
  std::size_t Update(std::size_t at_most = static_cast<std::size_t>(-1));
  const Bone& bone() const { return bone_; }
  /// Is told each leaf that Update() takes.
  void set_listener(std::function<void(const LeafMessage&)> listener) { listener_ = std::move(listener); }

 private:
  Bone bone_;
  SpscRing<LeafMessage>& stream_;
  std::function<void(const LeafMessage&)> listener_;
};

}  // namespace kerf
