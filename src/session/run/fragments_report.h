// What the effect "fragments" does in a session: it is fed with changed leaves, asked now and then, and reported.
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
  std::vector<std::string> regions;  // of each event: the name of the region that has the most of the piece
  std::size_t event_count = 0;       // with those that were too many to be kept
  FoundPieces found;                 // at the end, in the bone
  std::vector<PieceOut> out;         // taken out of it, in turn
  // How long looking took, off the haptic thread, ms.
  std::size_t looks = 0;  // with something to look at
  double p50_ms = 0;
  double max_ms = 0;
  std::optional<double> most_late_ms;  // live: from coming off to being found, at most, of the pieces
  double memory_MB = 0;

  /// Set aside or hidden; deleted, without dust; dust.
  double CalcAside_mm3() const;
  double CalcDeleted_mm3() const;
  double CalcDustOut_mm3() const;
};

/// Drives the effect's watch and times it. Does nothing when the plan has no such effect.
class FragmentsDriver {
 public:
  explicit FragmentsDriver(EffectPlan& effects);

  bool is_on() const { return effect_ != nullptr; }
  double every_s() const { return 1e-3 * effect_->watch().params().every_ms; }
  void Change(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// `time_s`: of the simulation, up to which all changes were told.
  void Look(double time_s);
  /// Live: as Look(), and `now` tells the loop's time when it has been looked.
  void Look(double time_s, const std::function<double()>& now);
  /// The next that is to go (PreparePiece()), and that it is gone, by `time_s`: tell its leaves and look before.
  bool takes_out() const { return effect_ != nullptr && effect_->watch().params().TakesOut(); }
  std::optional<PieceJob> Prepare(const Bone& bone, const std::function<bool(const Box3&)>& is_clear) const;
  void Finish(PieceJob&& job, double time_s);
  std::optional<FragmentsReport> MakeReport(const MaterialTable& materials) const;

 private:
  FragmentsEffect* effect_;
  std::vector<double> times_ms_;
  double changes_ms_ = 0;  // since the last look
  double looked_s_ = 0;
  std::optional<double> most_late_ms_;
  std::vector<PieceOut> out_;
  std::set<int> gone_;
};

/// For people, in a line.
std::string DescribeFragments(const FragmentsReport& fragments);
/// Stable keys with units. `times`: with how long it took.
nlohmann::ordered_json FragmentsJson(const FragmentsReport& fragments, bool times);
/// `pieces` of the bone in colours, moved away from the largest along the line between their middles; those that are
/// set aside where they are. False, and nothing written, when there never was but one.
bool WriteFragmentsPicture(const FragmentsReport& fragments, const std::vector<Bone>& pieces, bool patient,
                           const std::string& name, const std::string& path);

}  // namespace kerf
