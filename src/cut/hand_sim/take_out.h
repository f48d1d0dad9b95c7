// Removal of a piece from the bone between ticks, a few leaves at a time, and its return.
#pragma once

#include <cstddef>

#include "bone/grid/piece_removal.h"
#include "kerf/coupled.h"

namespace kerf {

/// Where a piece is: in the bone, leaving it, out of it, or returning.
enum class PiecePlace { kHeld, kLeaving, kOut, kReturning };

/// A held piece is part of the bone: it can be cut and resists the tool. A piece that is out is a separate rigid bone
/// at a pose X_WP, which the renderer moves, hides or deletes; the tool does not touch it. While the tool is so near
/// that a change could affect the force, nothing changes and the operation waits.
class TakeOut {
 public:
  /// `removal` must outlive this.
  explicit TakeOut(const PieceRemoval& removal) : removal_(removal) {}

  void Leave();
  void Return();
  PiecePlace place() const { return place_; }
  /// Returns true if the last Step() did nothing because the tool is too near.
  bool waits_for_tool() const { return waits_for_tool_; }

  /// Changes at most `leaves` leaves of the piece; to be called between two ticks. Returns true when all is done.
  /// Tick-safe.
  bool Step(CoupledSimulation& simulation, std::size_t leaves = 8);

 private:
  const PieceRemoval& removal_;
  PiecePlace place_ = PiecePlace::kHeld;
  std::size_t out_ = 0;   // number of leaves that are out
  bool counted_ = false;  // the piece is counted as taken out
  bool waits_for_tool_ = false;
};

}  // namespace kerf
