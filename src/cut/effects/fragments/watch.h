// Watching a bone for what comes off it: the side of the effect "fragments" that is no part of the tick.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "bone/grid/piece_finder.h"

namespace kerf {

/// What becomes of a piece that came off, once the tool is clear of it; the largest stays whatever is asked.
enum class PieceFate {
  kHeld,     // it stays, part of the bone
  kMoved,    // it is set aside, and seen there
  kHidden,   // it is out of the way and not drawn
  kDeleted,  // it is gone
};
inline constexpr const char* kPieceFates[] = {"held", "moved", "hidden", "deleted"};
inline const char* ToString(PieceFate fate) {
  return kPieceFates[static_cast<std::size_t>(fate)];
}

struct FragmentsParams {
  double dust_mm3 = 1;   // smaller is dust
  double every_ms = 50;  // between two looks
  double apart_mm = 6;   // in the picture; and of what is moved without move_mm
  PieceFate pieces = PieceFate::kHeld;
  Vec3 move_mm{0};  // world; 0: apart_mm away from the largest
  bool remove_dust = false;

  bool TakesOut() const { return pieces != PieceFate::kHeld || remove_dust; }
};

/// A piece came off.
struct FragmentEvent {
  double time_s = 0;  // of the look that found it
  FoundPiece piece;   // as it was then
  int pieces = 0;     // that there were then
  int region = 0;     // that has the most of it
};

/// One thread at a time, and never the tick's. Deterministic: the same leaves and looks give the same events.
class FragmentWatch {
 public:
  /// Allocates.
  FragmentWatch(const Bone& bone, const FragmentsParams& params) : params_(params), finder_(bone, params.dust_mm3) {}

  /// A leaf as it is now: src/bone/grid/set_leaf.h.
  void Change(const std::array<int, 3>& index, std::span<const float, 512> values) { finder_.Change(index, values); }
  /// Looks for what has come off since the last look, which is now as far as the leaves told go: `time_s`. Returns how
  /// many pieces.
  std::size_t Look(double time_s);

  const FragmentsParams& params() const { return params_; }
  const PieceFinder& finder() const { return finder_; }
  const std::vector<FragmentEvent>& events() const { return events_; }  // the first kMostEvents
  std::size_t event_count() const { return event_count_; }
  static constexpr std::size_t kMostEvents = 1000;
  std::size_t CalcMemoryBytes() const;

 private:
  FragmentsParams params_;
  PieceFinder finder_;
  std::vector<FragmentEvent> events_;
  std::size_t event_count_ = 0;
};

}  // namespace kerf
