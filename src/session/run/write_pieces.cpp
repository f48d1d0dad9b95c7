#include "session/run/write_pieces.h"

#include <fmt/format.h>

#include <utility>

#include "bone/mesh/meshfile.h"

namespace kerf {

std::size_t WriteReduced(const TriangleMesh& full, double error_mm, const std::string& path) {
  if (!(error_mm > 0)) {
    WriteMesh(full, path);
    return full.triangles.size();
  }
  const TriangleMesh reduced = Reduce(full, error_mm).mesh;
  WriteMesh(reduced, path);
  return reduced.triangles.size();
}

std::vector<PieceSurface> WritePieces(const Scene& scene, std::span<const Bone> in_bone,
                                      std::span<const ResultPiece> pieces, double error_mm, const std::string& folder,
                                      const std::function<void(double)>& progress, std::span<PieceSummary> summaries,
                                      const ResultSink& sink) {
  std::vector<PieceSurface> surfaces(in_bone.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const bool drawn = scene.output.pictures && kPicturesBuilt && pieces[i].out == nullptr;
    if (!scene.output.pieces && !drawn) continue;
    PieceSurface surface = MakePieceSurface(*pieces[i].bone, error_mm);
    if (scene.output.pieces) {
      PieceSummary& summary = summaries[i];
      const std::string name = fmt::format("piece_{}.stl", i + 1);
      summary.triangles = surface.mesh_W.triangles.size();
      for (Vec3& p : surface.mesh_W.points) p += summary.move_mm;
      sink(name, [&] {
        WriteMesh(surface.mesh_W, fmt::format("{}/{}", folder, name));
        summary.file = name;
      });
    }
    surface.mesh_W = {};
    if (drawn) surfaces[static_cast<std::size_t>(pieces[i].bone - in_bone.data())] = std::move(surface);
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(pieces.size()));
  }
  return surfaces;
}

}  // namespace kerf
