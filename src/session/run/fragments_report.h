// The effect "fragments" in a session: it receives changed leaves, is queried periodically, and is reported.
#pragma once

#include <array>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cut/effects/fragments/fragments.h"
#include "cut/effects/plan.h"
#include "kerf/bone.h"
#include "session/run/pieces_out.h"

namespace kerf {

struct FragmentsReport {
  FragmentsParams params;
  std::vector<FragmentEvent> events;
  std::vector<std::string> regions;  // per event: name of the region with the largest fraction of the piece
  std::size_t event_count = 0;       // including events beyond the limit of stored ones
  FoundPieces found;                 // in the bone at the end
  std::vector<PieceOut> out;         // taken out of the bone, in order of removal
  // Duration of the searches for pieces, outside the haptic thread, ms.
  std::size_t searches = 0;  // after a change of the bone
  double p50_ms = 0;
  double max_ms = 0;
  std::optional<double> max_delay_ms;  // live: maximum delay from separation to detection of a piece
  double memory_MB = 0;

  double CalcSetAside_mm3() const;  // volume of the pieces that were set aside or hidden
  double CalcDeleted_mm3() const;   // volume of the pieces that were deleted, without dust
  double CalcDustOut_mm3() const;   // volume of the dust that was taken out
};

/// Drives the effect's FragmentWatch and measures its time. Does nothing if the plan lacks the effect.
class FragmentsDriver {
 public:
  explicit FragmentsDriver(EffectPlan& effects);

  bool is_on() const { return effect_ != nullptr; }
  double every_s() const { return 1e-3 * effect_->watch().params().every_ms; }
  void Change(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// Searches for pieces. `time_s`: simulation time up to which all changes have been passed to the watch.
  void Search(double time_s);
  /// For a live loop: does the same; `now` must return the loop's time and is called after the search.
  void Search(double time_s, const std::function<double()>& now);
  /// Prepare() returns the next piece to take out (PreparePiece()). Finish() records that the piece was taken out by
  /// `time_s`; before calling it, pass the piece's changed leaves and call Search().
  bool takes_out() const { return effect_ != nullptr && effect_->watch().params().TakesOut(); }
  std::optional<PieceJob> Prepare(const Bone& bone, const std::function<bool(const Box3&)>& is_clear) const;
  void Finish(PieceJob&& job, double time_s);
  std::optional<FragmentsReport> MakeReport(const MaterialTable& materials) const;

 private:
  FragmentsEffect* effect_;
  std::vector<double> times_ms_;
  double changes_ms_ = 0;  // since the last Search()
  double searched_s_ = 0;
  std::optional<double> max_delay_ms_;
  std::vector<PieceOut> out_;
  std::set<int> taken_out_;
};

/// Describes the pieces in one readable line.
std::string DescribeFragments(const FragmentsReport& fragments);
/// Returns an object with stable keys that include the units. `times`: include the durations.
nlohmann::ordered_json FragmentsJson(const FragmentsReport& fragments, bool times);
/// Draws `pieces` of the bone in colours, moved away from the largest along the line between their centres. Pieces that
/// are set aside are drawn where they are. Returns false, without writing, if there was never more than one piece.
bool WriteFragmentsPicture(const FragmentsReport& fragments, const std::vector<Bone>& pieces, bool patient,
                           const std::string& name, const std::string& path);

}  // namespace kerf
