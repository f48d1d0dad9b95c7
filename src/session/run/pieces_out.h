// Pieces that a run takes out of the bone, as [effects.fragments] asks: set aside, hidden or deleted.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "bone/grid/piece_removal.h"
#include "cut/effects/fragments/watch.h"
#include "kerf/error.h"
#include "kerf/geometry.h"

namespace kerf {

/// A piece that is out, or all dust that there was (which is deleted).
struct PieceOut {
  int id = 0;  // kAllDust: dust
  PieceFate fate = PieceFate::kDeleted;
  double time_s = 0;      // when it went
  double volume_mm3 = 0;  // of its surface, as it was then
  std::size_t crumbs = 0;
  Vec3 move_mm{0};  // its pose: so far from where it was cut off, not turned
  Bone bone;        // where it was cut off; empty when deleted
};

/// One that is to go, worked out.
struct PieceJob {
  int id = 0;
  std::size_t crumbs = 0;
  Vec3 move_mm{0};
  PieceRemoval removal;
};

/// What is to go next: pieces that the cut took off, but for the largest of all, then dust, as far as the watch's
/// parameters ask for it and `is_clear` says that the tool is clear of the box. None: nothing at the moment. `bone`:
/// the one that the watch has been told of. Not for the tick.
std::optional<PieceJob> PreparePiece(const FragmentWatch& watch, const Bone& bone, const std::set<int>& not_these,
                                     const std::function<bool(const Box3&)>& is_clear);
/// Between two ticks, all of it at once; what is out already stays so. Of a Simulation or a CoupledSimulation.
template <typename Sim>
void Install(const PieceRemoval& removal, Sim& simulation) {
  for (const LeafChange& change : removal.leaves) {
    const auto replace = [&] { return simulation.Replace(change.index, change.with.data(), change.without.data()); };
    if (replace()) continue;
    simulation.Refill();
    if (!replace()) throw Error("no room for what is left where a piece is taken out of the bone");
  }
  simulation.AddTakenOut(removal.mm3, 1);
}

/// Of a job that is done.
PieceOut FinishPiece(PieceJob&& job, const FragmentsParams& params, double time_s);

/// A piece after a run that is not gone.
struct ResultPiece {
  const Bone* bone = nullptr;     // where it was cut off
  const PieceOut* out = nullptr;  // null: it is in the bone
  double volume_mm3 = 0;
};
/// `in_bone` and what is set aside or hidden, largest first.
std::vector<ResultPiece> ListPieces(std::span<const Bone> in_bone, std::span<const PieceOut> out);

/// Where it was set aside, if it was.
TriangleMesh MakeSurfaceOut(const PieceOut& piece);

}  // namespace kerf
