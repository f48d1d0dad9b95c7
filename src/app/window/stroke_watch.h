// Divides cutting into strokes, each of which is one step of undo.
#pragma once

#include "loop/haptics/loop_body.h"

namespace kerf {

/// A stroke begins with the first bone that is removed. It ends when the saw has been clear of the bone for some ticks,
/// or when the hand has let go of it and it has come to rest.
class StrokeWatch {
 public:
  static constexpr int kEnd_ticks = 200;

  /// Call with each tick, in order. Returns true if a stroke ends with it.
  bool Take(const LoopTick& tick) {
    if (tick.stands) {  // the bone is restored: that is no stroke
      *this = {};
      return false;
    }
    const CoupledOutput& out = tick.coupled;
    const bool cuts = out.removed_mm3 > 0;
    has_cut_ = has_cut_ || cuts;
    ticks_without_cut_ = cuts ? 0 : ticks_without_cut_ + 1;
    const bool touches = cuts || out.f_cut_W_N != Vec3{0} || out.f_face_W_N != Vec3{0};
    ticks_in_air_ = touches ? 0 : ticks_in_air_ + 1;
    if (!has_cut_ || (tick.held ? ticks_in_air_ : ticks_without_cut_) < kEnd_ticks) return false;
    *this = {};
    return true;
  }

 private:
  bool has_cut_ = false;
  int ticks_without_cut_ = 0;
  int ticks_in_air_ = 0;
};

}  // namespace kerf
