// A piece leaves the bone between ticks, a few leaves at a time, and comes back.
#pragma once

#include <cstddef>

#include "bone/grid/piece_removal.h"
#include "kerf/coupled.h"

namespace kerf {

/// Where a piece is.
enum class PiecePlace { kHeld, kLeaving, kOut, kComing };

/// Held, a piece is part of the bone: it is cut and felt. Out of it, it is a rigid bone of its own at a pose X_WP:
/// moved, hidden or deleted, as whoever draws it likes; the tool does not meet it. Nothing of it changes while the tool
/// is so near that it could be felt: it waits.
class TakeOut {
 public:
  /// `removal` must outlive it.
  explicit TakeOut(const PieceRemoval& removal) : removal_(removal) {}

  void Leave();
  void Come();
  PiecePlace place() const { return place_; }
  /// Why the last Step() did nothing.
  bool waits_for_tool() const { return waits_for_tool_; }
  bool waits_for_leaves() const { return waits_for_leaves_; }  // CoupledSimulation::Refill() makes some

  /// Between two ticks: at most `leaves` of the piece. True when all is done. Tick-safe.
  bool Step(CoupledSimulation& simulation, std::size_t leaves = 8);

 private:
  const PieceRemoval& removal_;
  PiecePlace place_ = PiecePlace::kHeld;
  std::size_t out_ = 0;   // leaves that are out
  bool counted_ = false;  // as taken out
  bool waits_for_tool_ = false;
  bool waits_for_leaves_ = false;
};

}  // namespace kerf
