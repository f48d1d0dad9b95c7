// Search for pieces that come off a bone: the part of the effect "fragments" outside the tick.
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <vector>

#include "bone/grid/piece_finder.h"
#include "kerf/describe.h"

namespace kerf {

/// Treatment of a piece that came off, once the tool is clear of it. The largest piece always stays.
enum class PieceFate {
  kHeld,     // stays, as part of the bone
  kMoved,    // is moved aside and drawn there
  kHidden,   // is taken out and not drawn
  kDeleted,  // is taken out and discarded
};
inline constexpr const char* kPieceFates[] = {"held", "moved", "hidden", "deleted"};
inline const char* ToString(PieceFate fate) {
  return kPieceFates[static_cast<std::size_t>(fate)];
}

struct FragmentsParams {
  double dust_mm3 = 1;
  double every_ms = 50;
  double apart_mm = 6;
  PieceFate pieces = PieceFate::kHeld;
  Vec3 move_mm{0};  // world frame
  bool remove_dust = false;

  bool TakesOut() const { return pieces != PieceFate::kHeld || remove_dust; }
};

template <typename V>
void Describe(FragmentsParams& p, V&& visit) {
  visit("dust_mm3", p.dust_mm3, Range{0, 1e6},
        "smaller pieces are dust: counted, but not reported as events; an assumption, like smallest_piece_mm3 of "
        "[output]");
  visit("every_ms", p.every_ms, Range{1, 10000}, "time between two checks for pieces");
  visit("apart_mm", p.apart_mm, Range{0, 1000},
        "distance of the pieces from the largest one, in fragments.png and when they are moved");
  visit("pieces", p.pieces, Choices{{std::begin(kPieceFates), std::end(kPieceFates)}},
        "fate of each piece except the largest, once the tool is clear of it: stays in the bone, is set aside, is "
        "removed and not drawn, is deleted");
  visit("move_mm", p.move_mm, Range{-1000, 1000},
        "displacement of moved pieces; 0: apart_mm along the line between the centres");
  visit("remove_dust", p.remove_dust, "remove dust from the bone once the tool is clear of all of it");
}

/// Event: a piece came off.
struct FragmentEvent {
  double time_s = 0;  // of the search that found it
  FoundPiece piece;   // its state at that time
  int pieces = 0;     // number of pieces at that time
  int region = 0;     // region with the largest part of it
};

/// Finds pieces that come off. Used by one thread at a time, never by the tick thread. Deterministic: the same leaves
/// and searches give the same events.
class FragmentWatch {
 public:
  /// Allocates.
  FragmentWatch(const Bone& bone, const FragmentsParams& params) : params_(params), finder_(bone, params.dust_mm3) {}

  /// Passes the current values of a leaf (src/bone/grid/set_leaf.h).
  void Change(const std::array<int, 3>& index, std::span<const float, 512> values) { finder_.Change(index, values); }
  /// Searches for pieces that came off since the last search. `time_s`: time of the leaves that were passed last.
  /// Returns the number of such pieces.
  std::size_t Look(double time_s);

  const FragmentsParams& params() const { return params_; }
  const PieceFinder& finder() const { return finder_; }
  const std::vector<FragmentEvent>& events() const { return events_; }  // the first kMaxEvents
  std::size_t event_count() const { return event_count_; }
  static constexpr std::size_t kMaxEvents = 1000;
  std::size_t CalcMemoryBytes() const;

 private:
  FragmentsParams params_;
  PieceFinder finder_;
  std::vector<FragmentEvent> events_;
  std::size_t event_count_ = 0;
};

}  // namespace kerf
