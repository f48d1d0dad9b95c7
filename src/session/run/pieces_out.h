// Pieces that a run takes out of the bone, as [effects.fragments] requests: set aside, hidden or deleted.
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

/// A piece that was taken out, or all the dust at that time, which is always deleted.
struct PieceOut {
  int id = 0;  // kAllDust: dust
  PieceFate fate = PieceFate::kDeleted;
  double time_s = 0;      // time of its removal
  double volume_mm3 = 0;  // of its surface at that time
  std::size_t crumbs = 0;
  Vec3 move_mm{0};  // its pose: translation from where it was cut off, without rotation
  Bone bone;        // at the place where it was cut off; empty if deleted
};

/// A piece to be taken out.
struct PieceJob {
  int id = 0;
  std::size_t crumbs = 0;
  Vec3 move_mm{0};
  PieceRemoval removal;
};

/// Returns the next piece to take out: first the pieces that the cut separated, except the largest of all, then dust.
/// Considers only those that the watch's parameters request and whose box `is_clear` reports as clear of the tool.
/// Returns none if there is no such piece. `excluded`: ids of pieces to skip. `bone`: the bone that the watch monitors.
/// Not tick-safe.
std::optional<PieceJob> PreparePiece(const FragmentWatch& watch, const Bone& bone, const std::set<int>& excluded,
                                     const std::function<bool(const Box3&)>& is_clear);
/// Takes out a whole piece at once, between two ticks; leaves that are already taken out remain so. `Sim`: Simulation
/// or CoupledSimulation.
template <typename Sim>
void Install(const PieceRemoval& removal, Sim& simulation) {
  for (const LeafChange& change : removal.leaves) {
    const auto replace = [&] { return simulation.Replace(change.index, change.with.data(), change.without.data()); };
    if (replace()) continue;
    simulation.Refill();
    if (!replace()) throw Error("no spare leaf for the rest of the bone where a piece is removed");
  }
  simulation.AddTakenOut(removal.mm3, 1);
}

/// Returns the bone with the pieces that were taken out of it put back where they were cut off; deleted ones are not.
Bone PutBack(const Bone& bone, std::span<const PieceOut> out);

/// Returns the result of a completed job.
PieceOut FinishPiece(PieceJob&& job, const FragmentsParams& params, double time_s);

/// A piece that exists after a run.
struct ResultPiece {
  const Bone* bone = nullptr;     // at the place where it was cut off
  const PieceOut* out = nullptr;  // null: it is in the bone
  double volume_mm3 = 0;
};
std::vector<double> CalcVolumes(std::span<const Bone> bones);  // mm3
/// Returns `in_bone`, of these volumes, and the pieces that are set aside or hidden, largest first.
std::vector<ResultPiece> ListPieces(std::span<const Bone> in_bone, std::span<const double> volumes_mm3,
                                    std::span<const PieceOut> out);

/// Returns the surface of a piece: where it was set aside or, if it was not, where it was cut off.
TriangleMesh MakeSurfaceOut(const PieceOut& piece);

}  // namespace kerf
