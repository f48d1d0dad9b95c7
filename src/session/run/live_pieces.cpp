#include "session/run/live_pieces.h"

#include <algorithm>
#include <utility>

#include "kerf/error.h"
#include "session/run/recorded_piece.h"

namespace kerf {

void LivePieces::Take(const LeafMessage& leaf) {
  if (!transfer_ || transfer_->leaving.load(std::memory_order_acquire)) return;
  const auto own = leaves_.find(leaf.index);
  was_cut_ = was_cut_ || (own != leaves_.end() && leaf.values != own->second->with);
}

/// Returns true if all changes up to the end of `tick` have been read.
bool LivePieces::HasReadAllOf(std::int64_t tick) {
  const LoopState& state = loop_.state().front();
  if (awaited_tick_ != tick) awaited_s_.reset();
  awaited_tick_ = tick;
  if (!awaited_s_ && static_cast<std::int64_t>(state.last.number) < tick + 2) return false;
  if (!awaited_s_) awaited_s_ = state.last.time_s;
  return state.sent_until_s >= *awaited_s_;
}

bool LivePieces::is_leaving() const {
  if (!transfer_) return false;
  const std::int64_t go = transfer_->go.load(std::memory_order_relaxed);
  return transfer_->leaving.load(std::memory_order_acquire) ||
         (go != 0 && go == transfer_->clear_since.load(std::memory_order_acquire));
}

void LivePieces::Done(double time_s) {
  fragments_.Search(time_s);
  job_->removal = std::move(transfer_->removal);
  fragments_.Finish(*std::move(job_), time_s);
  job_.reset();
  leaves_.clear();
  transfer_.reset();
}

void LivePieces::Poll() {
  if (!transfer_) return;
  PieceTransfer& piece = *transfer_;
  if (piece.dropped.load(std::memory_order_acquire)) {
    job_.reset();
    leaves_.clear();
    transfer_.reset();
  } else if (const std::int64_t out_at = piece.out_at.load(std::memory_order_acquire); out_at != 0) {
    if (HasReadAllOf(out_at)) Done(*awaited_s_);
  } else if (piece.leaving.load(std::memory_order_acquire)) {
    // The loop is still removing the piece.
  } else if (was_cut_) {
    piece.drop.store(true, std::memory_order_release);
  } else {
    const std::int64_t since = piece.clear_since.load(std::memory_order_acquire);
    if (since != 0 && since != piece.go.load(std::memory_order_relaxed) && HasReadAllOf(since)) {
      piece.go.store(since, std::memory_order_release);
    }
  }
}

void LivePieces::Prepare() {
  if (transfer_ || !fragments_.takes_out()) return;
  const LoopState& state = loop_.state().front();
  if (state.last.number == 0) return;
  const Vec3 p_W = state.last.coupled.X_WT.p_AB;
  job_ = fragments_.Prepare(mirror_.bone(), [&](const Box3& box_W) {
    return IsToolClearOf(box_W, p_W, reach_mm_, mirror_.bone().voxel_mm());
  });
  if (!job_) return;
  ++number_;
  if (listener_) listener_(number_, EncodePiece(*job_));
  transfer_ = std::make_unique<PieceTransfer>(std::move(job_->removal), number_);
  for (const LeafChange& leaf : transfer_->removal.leaves) leaves_[leaf.index] = &leaf;
  was_cut_ = false;
  exchange_.Send(transfer_.get());  // the ring has room: the loop has finished with the previous piece
}

void LivePieces::Repeat(std::uint32_t number, const std::string& bytes, double time_s) {
  if (transfer_) throw Error("the recording removes a piece before the previous one has been removed");
  number_ = number;
  if (listener_) listener_(number, bytes);
  job_ = DecodePiece(bytes, mirror_.bone());
  // A new search supplies the piece as a separate bone; the changes to the bone are those recorded.
  const auto find = [&] {
    std::optional<PieceJob> found = fragments_.Prepare(mirror_.bone(), [](const Box3&) { return true; });
    const bool same = found && found->removal.leaves.size() == job_->removal.leaves.size() && found->id == job_->id;
    if (same) job_->removal.piece = std::move(found->removal.piece);
    return same;
  };
  if (!find()) {
    fragments_.Search(time_s);
    find();
  }
  transfer_ = std::make_unique<PieceTransfer>(std::move(job_->removal), number);
  was_cut_ = false;
  exchange_.Begin(transfer_.get());
}

void LivePieces::Finish(CoupledSimulation& simulation, double time_s, const std::function<void()>& send_rest) {
  if (transfer_ && transfer_->leaving.load()) {
    if (transfer_->out_at.load() == 0) Install(transfer_->removal, simulation);
    send_rest();
    Done(time_s);
  }
  job_.reset();
  leaves_.clear();
  transfer_.reset();
  send_rest();
  fragments_.Search(time_s);
  while (std::optional<PieceJob> job = fragments_.Prepare(mirror_.bone(), [](const Box3&) { return true; })) {
    Install(job->removal, simulation);
    send_rest();
    fragments_.Search(time_s);
    fragments_.Finish(*std::move(job), time_s);
  }
}

}  // namespace kerf
