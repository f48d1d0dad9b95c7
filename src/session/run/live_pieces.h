// Takes pieces out of the bone while a loop cuts it: the reader's side.
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

/// Takes out one piece after another. A piece is found in the mirror and sent to the loop. If it has not been cut in
/// the meantime, it is released (PieceTransfer); otherwise it is searched for again. Does nothing if the scene takes
/// nothing out. Call in the reader's thread.
class LivePieces {
 public:
  /// All references must outlive this object.
  LivePieces(FragmentsDriver& fragments, HapticLoop& loop, PieceExchange& exchange, const BoneMirror& mirror,
             double reach_mm)
      : fragments_(fragments), loop_(loop), exchange_(exchange), mirror_(mirror), reach_mm_(reach_mm) {}

  /// Sets the callback that is called with the number and bytes (recorded_piece.h) of each piece before the piece is
  /// sent to the loop. Set it before the first piece.
  void set_listener(std::function<void(std::uint32_t, const std::string&)> listener) {
    listener_ = std::move(listener);
  }
  /// For a replay, between ticks and with an up-to-date mirror: starts the removal of a recorded piece in the next
  /// tick. Throws kerf::Error for invalid bytes.
  void Repeat(std::uint32_t number, const std::string& bytes, double time_s);

  /// Call for each leaf that the mirror receives.
  void Take(const LeafMessage& leaf);
  /// Call periodically, after reading the loop's latest state and then updating the mirror.
  void Poll();
  /// Returns true while a piece is partly removed; do not search for pieces then.
  bool is_leaving() const;
  /// Finds the next piece. Call after a search.
  void Prepare();
  /// Call after the end of the loop: takes out the remaining pieces, wherever the tool is. `send_rest` updates the
  /// mirror.
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
  std::uint32_t number_ = 0;  // number of the last piece sent
  std::optional<PieceJob> job_;
  std::unique_ptr<PieceTransfer> transfer_;
  std::map<std::array<int, 3>, const LeafChange*> leaves_;
  bool was_cut_ = false;
  std::int64_t awaited_tick_ = 0;
  std::optional<double> awaited_s_;
};

}  // namespace kerf
