// Removes from the loop's bone a piece that a reader has found: a few leaves after each tick, once the tool is clear of
// the piece.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/core/spsc_ring.h"
#include "cut/hand_sim/take_out.h"

namespace kerf {

/// A piece to be removed. The reader creates it and keeps it until the loop has finished with it.
///
/// The reader found the piece in a copy of the bone that lags slightly behind. The loop therefore reports the tick
/// since which the tool has been continuously clear of the piece. The reader checks that all leaves that changed up to
/// that tick match its copy, and then releases the piece: no cut can have changed it in between.
struct PieceTransfer {
  explicit PieceTransfer(PieceRemoval&& the_removal, std::uint32_t the_number = 1)
      : removal(std::move(the_removal)), number(the_number) {}

  PieceRemoval removal;
  std::uint32_t number;  // not 0
  // Written by the loop.
  std::atomic<std::int64_t> clear_since{0};  // tick number; 0: the tool is not clear of the piece
  std::atomic<bool> leaving{false};          // removal has begun and will be completed
  std::atomic<std::int64_t> out_at{0};       // tick in which the last leaf of the piece was removed
  std::atomic<bool> dropped{false};          // the loop has finished with it without beginning its removal
  // Written by the reader.
  std::atomic<std::int64_t> go{0};  // the piece may leave if clear_since is still this tick
  std::atomic<bool> drop{false};    // the piece was cut, so its removal is cancelled
};

/// The loop's end of the exchange. Handles one piece at a time.
class PieceExchange {
 public:
  explicit PieceExchange(std::size_t leaves_per_tick = 8) : leaves_per_tick_(leaves_per_tick) {}

  /// Called by the reader. Returns false if the loop has not accepted the previous piece yet.
  bool Send(PieceTransfer* transfer) { return ring_.TryPush(transfer); }
  /// True while a piece is partly removed. Tick-safe.
  bool leaving() const { return now_ != nullptr && now_->leaving.load(std::memory_order_relaxed); }
  /// Drops pieces that have not begun to leave, because something other than cutting has changed the bone. Tick-safe.
  void Drop();
  /// Called instead of Step() in ticks in which no piece may move. Tick-safe.
  void Pass() { ++tick_; }
  /// Called instead of Send() if no loop runs (replay): the piece begins to leave at the next Step(), as recorded.
  void Begin(PieceTransfer* transfer);
  /// Called by the loop after each tick. Returns the number of the piece that began to leave in this tick, otherwise 0.
  /// Tick-safe.
  std::uint32_t Step(CoupledSimulation& simulation);

 private:
  SpscRing<PieceTransfer*> ring_{1};
  std::size_t leaves_per_tick_;
  PieceTransfer* now_ = nullptr;
  std::optional<TakeOut> take_out_;
  std::int64_t tick_ = 0;
};

}  // namespace kerf
