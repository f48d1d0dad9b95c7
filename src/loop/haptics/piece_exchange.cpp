#include "loop/haptics/piece_exchange.h"

namespace kerf {

void PieceExchange::Begin(PieceTransfer* transfer) {
  now_ = transfer;
  take_out_.emplace(now_->removal);
  now_->clear_since.store(tick_ + 1);
  now_->go.store(tick_ + 1);
}

std::uint32_t PieceExchange::Step(CoupledSimulation& simulation) {
  ++tick_;
  if (now_ == nullptr) {
    PieceTransfer* const* next = ring_.Peek();
    if (next == nullptr) return 0;
    now_ = *next;
    ring_.Pop();
    take_out_.emplace(now_->removal);
  }
  PieceTransfer& piece = *now_;
  std::uint32_t began = 0;
  if (!piece.leaving.load(std::memory_order_relaxed)) {
    if (piece.drop.load(std::memory_order_acquire)) {
      now_ = nullptr;
      piece.dropped.store(true, std::memory_order_release);
      return 0;
    }
    std::int64_t since = piece.clear_since.load(std::memory_order_relaxed);
    if (!simulation.IsClearOf(piece.removal.bounds_W)) {
      since = 0;
    } else if (since == 0) {
      since = tick_;
    }
    piece.clear_since.store(since, std::memory_order_release);
    if (since == 0 || piece.go.load(std::memory_order_acquire) != since) return 0;
    piece.leaving.store(true, std::memory_order_release);
    take_out_->Leave();
    began = piece.number;
  }
  if (!take_out_->Step(simulation, leaves_per_tick_)) return began;
  now_ = nullptr;
  piece.out_at.store(tick_, std::memory_order_release);
  return began;
}

void PieceExchange::Drop() {
  if (leaving()) return;
  if (now_ == nullptr) {
    PieceTransfer* const* next = ring_.Peek();
    if (next == nullptr) return;
    now_ = *next;
    ring_.Pop();
  }
  std::exchange(now_, nullptr)->dropped.store(true, std::memory_order_release);
}

}  // namespace kerf
