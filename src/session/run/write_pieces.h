// Writes the surfaces of a run's results, reduced to a stated error.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"

namespace kerf {

/// Writes `full` as binary STL, reduced to `error_mm` (mesh/reduce.h); 0: not reduced. Returns the number of triangles
/// in the file. Throws kerf::Error.
std::size_t WriteReduced(const TriangleMesh& full, double error_mm, const std::string& path);

/// If the scene requests it, writes a file piece_N.stl for each piece, reduced to `error_mm` (0: not reduced). Sets
/// `file` and `triangles` of `summaries`, which has one entry per piece. Returns the surfaces of `in_bone`, in its
/// order, for the pictures; they are empty if the scene requests neither files nor pictures. Each file is written
/// through `sink`; a file that could not be written has no name in `summaries`. `progress` (optional) is called with
/// values from 0 to 1. Throws kerf::Error.
std::vector<PieceSurface> WritePieces(const Scene& scene, std::span<const Bone> in_bone,
                                      std::span<const ResultPiece> pieces, double error_mm, const std::string& folder,
                                      const std::function<void(double)>& progress, std::span<PieceSummary> summaries,
                                      const ResultSink& sink = JustWrite);

}  // namespace kerf
