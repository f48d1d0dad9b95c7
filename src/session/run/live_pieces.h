// The reader's side of taking pieces out of the bone that a loop cuts.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/haptics/piece_exchange.h"
#include "session/run/fragments_report.h"

namespace kerf {

/// One piece after another: worked out from the mirror, sent to the loop, let go when nothing has cut it meanwhile
/// (PieceTransfer), worked out again otherwise. Does nothing when the scene takes nothing out. The reader's thread.
class LivePieces {
 public:
  /// All must outlive it.
  LivePieces(FragmentsDriver& fragments, HapticLoop& loop, PieceExchange& exchange, const BoneMirror& mirror,
             double reach_mm)
      : fragments_(fragments), loop_(loop), exchange_(exchange), mirror_(mirror), reach_mm_(reach_mm) {}

  /// Told of each piece, with its number and its bytes (recorded_piece.h), before the loop is. To be set before the
  /// first.
  void set_listener(std::function<void(std::uint32_t, const std::string&)> listener) {
    listener_ = std::move(listener);
  }
  /// In a replay, between ticks, with the mirror up to date: a recorded piece begins to leave in the next tick. Throws
  /// Error for bytes that are none.
  void Repeat(std::uint32_t number, const std::string& bytes, double time_s);

  /// Each leaf that the mirror takes.
  void Take(const LeafMessage& leaf);
  /// Now and then, with the loop's newest state taken first and then the mirror brought up to date.
  void Poll();
  /// Half of a piece is out: not the time to look for pieces.
  bool is_leaving() const;
  /// After a look.
  void Prepare();
  /// After the loop's end: the tool is taken away, and what is to go goes. `send_rest` brings the mirror up to date.
  void Finish(CoupledSimulation& simulation, double time_s, const std::function<void()>& send_rest);

 private:
  bool HasReadAllOf(std::int64_t tick);
  void Done(double time_s);

  FragmentsDriver& fragments_;
  HapticLoop& loop_;
  PieceExchange& exchange_;
  const BoneMirror& mirror_;
  double reach_mm_;
  std::function<void(std::uint32_t, const std::string&)> listener_;
  std::uint32_t number_ = 0;  // of the last piece sent
  std::optional<PieceJob> job_;
  std::unique_ptr<PieceTransfer> transfer_;
  std::map<std::array<int, 3>, const LeafChange*> leaves_;
  bool was_cut_ = false;
  std::int64_t asked_tick_ = 0;
  std::optional<double> asked_s_;
};

}  // namespace kerf
