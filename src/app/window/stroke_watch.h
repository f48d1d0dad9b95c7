// Divides cutting into strokes, each of which is one step of undo.
#pragma once

#include "app/window/contact_sums.h"
#include "loop/haptics/loop_body.h"

namespace kerf {

/// A stroke begins with the first bone that is removed. It ends when the saw has been clear of the bone for some ticks,
/// or when the hand takes it again after it had let go of it for as long. What a saw cuts meanwhile, as it comes to
/// rest, belongs to the stroke.
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
    const bool is_taken_again = tick.held && ticks_let_go_ >= kEnd_ticks;
    ticks_let_go_ = tick.held ? 0 : ticks_let_go_ + 1;
    const bool cuts = out.removed_mm3 > 0;
    ticks_in_air_ = TouchesBone(out) ? 0 : ticks_in_air_ + 1;
    const bool ends = has_cut_ && (is_taken_again || ticks_in_air_ >= kEnd_ticks);
    has_cut_ = cuts || (has_cut_ && !ends);
    return ends;
  }

 private:
  bool has_cut_ = false;
  int ticks_let_go_ = 0;
  int ticks_in_air_ = 0;
};

}  // namespace kerf
