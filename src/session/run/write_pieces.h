// The surfaces of a run's results as files, reduced to a stated error.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"

namespace kerf {

/// Writes `full` as binary STL, reduced to `error_mm` (mesh/reduce.h); 0: as it is. Returns how many triangles the file
/// has. Throws Error.
std::size_t WriteReduced(const TriangleMesh& full, double error_mm, const std::string& path);

/// As the scene asks, piece_N.stl of each piece, reduced to `error_mm` (0: not at all). Fills `file` and `triangles` of
/// `summaries`, which has one for each piece. Returns the surfaces of `in_bone`, in its order, for the pictures; empty
/// ones when the scene asks for neither. Each file goes through `sink`; one that it lost has no name in `summaries`.
/// `progress` is called with 0..1; may be empty. Throws Error.
std::vector<PieceSurface> WritePieces(const Scene& scene, std::span<const Bone> in_bone,
                                      std::span<const ResultPiece> pieces, double error_mm, const std::string& folder,
                                      const std::function<void(double)>& progress, std::span<PieceSummary> summaries,
                                      const ResultSink& sink = JustWrite);

}  // namespace kerf
