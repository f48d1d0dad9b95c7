// Thread that watches a bone while it is cut: which planned planes are cut how far, and which pieces come free.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "session/marks/structures.h"
#include "session/plan/cut_state.h"

namespace kerf {

/// State of the bone at one moment: its planned planes, pieces and injured structures.
struct PlanesReport {
  struct Row {
    std::string name;  // of the plane
    CutState state;
  };
  std::vector<Row> planes;                  // in the order of the plan
  std::size_t piece_count = 0;              // pieces of the bone, of CutWatchOptions::min_piece_mm3 or more
  std::vector<StructureResult> injuries{};  // canals, teeth and marks that are cut: see InjuryFinder
  std::vector<StructureResult> beside{};    // what was removed of these outside the wanted cut: CutWatch::SetWanted();
                                            // never severed
  std::vector<double> measured{};           // result of CutWatch::SetMeasure(); empty: not set
};

/// A piece that has separated from the rest of the bone.
struct FreedPiece {
  int id = 0;             // of PieceFinder
  double volume_mm3 = 0;  // Bone::CalcVolume() of the piece, the same as that of a PieceSet
  Box3 bounds_W;          // of its voxels; world frame, mm
  int main_region = 0;    // region with the largest part of its volume, estimated; 0: none
};

struct CutWatchOptions {
  double period_s = 0.5;     // time between two reports
  double min_piece_mm3 = 1;  // smaller pieces are dust, which is not reported
};

/// Injuries are those between `before` and now, also of cuts from before the watch began.
///
/// Keeps its own copy of the level set, to which the changed leaves are applied. All functions may be called by any
/// thread; none waits for the analysis. A lock is held only while a leaf or a result is copied. The analysis runs at
/// most once per period, and only if the bone or the planes have changed.
///
/// A piece that comes free is reported once: by the first analysis in which its voxels (phi < 0) no longer share a face
/// with the rest, which is at most one period after the cut. If an undo joins it again and it is cut off again, it is
/// reported again. The part with the largest volume keeps the place of the whole; the others are the ones that came
/// free.
class CutWatch {
 public:
  /// `before`: the bone with which cuts are compared; `now`: the current bone, a copy of it or of its cut state.
  /// Returns immediately; the pieces are searched for in the thread.
  CutWatch(std::shared_ptr<const Bone> before, Bone now, const CutWatchOptions& options = {});
  ~CutWatch();  // stops the thread
  CutWatch(const CutWatch&) = delete;
  CutWatch& operator=(const CutWatch&) = delete;

  /// Queues the new values of a leaf (see SetLeaf()). Waiting leaves are merged by position.
  void Offer(const std::array<int, 3>& index, std::span<const float, 512> values);
  /// Sets the planes of the next report.
  void SetPlanes(std::vector<PlannedPlane> planes);
  /// Sets what else is computed for each report, in the thread, from the bones before and now.
  void SetMeasure(std::function<std::vector<double>(const Bone& before, const Bone& now)> measure);
  /// Sets which places are in the wanted cut. Then, injuries are only what was removed there, and PlanesReport::beside
  /// is the rest. Null: there is no wanted cut.
  void SetWanted(std::function<bool(const Vec3& p_W)> is_wanted);
  /// Sets the user's marks, whose injuries are reported.
  void SetMarks(std::vector<Mark> marks);
  /// Returns the latest report unless it has already been fetched.
  std::optional<PlanesReport> Fetch();
  /// Returns the pieces that have come free since the last call, in the order of their separation.
  std::vector<FreedPiece> TakeFreed();
  /// Blocks until everything that was offered and set has been analysed. For tests.
  void WaitIdle();

  /// Durations for a status display and for measurements.
  struct Costs {
    double start_s = 0;    // of the first search for pieces
    double last_s = 0;     // of the last analysis
    double largest_s = 0;  // of all analyses
    std::uint64_t analyses = 0;
  };
  Costs costs() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
