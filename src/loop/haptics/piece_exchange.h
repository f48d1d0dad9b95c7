// A piece that a reader has worked out leaves the loop's bone: a few leaves after each tick, while the tool is clear.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/core/spsc_ring.h"
#include "cut/hand_sim/take_out.h"

namespace kerf {

/// Made and kept by the reader until the loop has done with it.
///
/// The reader worked the piece out from a copy of the bone that is a little behind. So the loop says since when the
/// tool has been clear of the piece without a break, the reader makes sure that all leaves that changed until then were
/// as it knew them, and lets the piece go: nothing can have cut it in between.
struct PieceTransfer {
  explicit PieceTransfer(PieceRemoval&& the_removal, std::uint32_t the_number = 1)
      : removal(std::move(the_removal)), number(the_number) {}

  PieceRemoval removal;
  std::uint32_t number;  // not 0
  // the loop's
  std::atomic<std::int64_t> clear_since{0};  // the tick; 0: the tool is not clear of it
  std::atomic<bool> leaving{false};          // it has begun, and will be finished
  std::atomic<std::int64_t> out_at{0};       // the tick in which the last of it went
  std::atomic<bool> dropped{false};          // the loop has done with it without having begun
  // the reader's
  std::atomic<std::int64_t> go{0};  // may leave if the tool has been clear since this tick
  std::atomic<bool> drop{false};    // it was cut: never mind
};

/// The loop's side of it. One piece at a time.
class PieceExchange {
 public:
  explicit PieceExchange(std::size_t leaves_per_tick = 8) : leaves_per_tick_(leaves_per_tick) {}

  /// The reader's. False when the one before is still waiting to be taken up.
  bool Send(PieceTransfer* transfer) { return ring_.TryPush(transfer); }
  /// Half of a piece is out. Tick-safe.
  bool leaving() const { return now_ != nullptr && now_->leaving.load(std::memory_order_relaxed); }
  /// Pieces that have not begun to leave are dropped: the bone changed otherwise than by cutting. Tick-safe.
  void Drop();
  /// In the place of Step(), where no piece may move. Tick-safe.
  void Pass() { ++tick_; }
  /// In place of Send(), where no loop runs: at the next Step() the piece begins to leave, as it did once before.
  void Begin(PieceTransfer* transfer);
  /// The loop's, after each tick. The number of a piece that began to leave in it, else 0. Tick-safe.
  std::uint32_t Step(CoupledSimulation& simulation);

 private:
  SpscRing<PieceTransfer*> ring_{1};
  std::size_t leaves_per_tick_;
  PieceTransfer* now_ = nullptr;
  std::optional<TakeOut> take_out_;
  std::int64_t tick_ = 0;
};

}  // namespace kerf
