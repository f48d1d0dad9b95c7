#include "session/run/write_pieces.h"

#include <fmt/format.h>

#include <chrono>
#include <future>
#include <optional>
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
  const auto is_drawn = [&](std::size_t i) {
    return scene.output.pictures && kPicturesBuilt && pieces[i].out == nullptr;
  };
  const auto start = [&](std::size_t i) {
    std::future<PieceSurface> surface;
    if (i < pieces.size() && (scene.output.pieces || is_drawn(i))) {
      surface = std::async(std::launch::async,
                           [&pieces, error_mm, i] { return MakePieceSurface(*pieces[i].bone, error_mm); });
    }
    return surface;
  };
  const auto show = [&](double done) {
    if (progress) progress(done / static_cast<double>(pieces.size()));
  };
  // Two at a time, because parts of this work use one thread only.
  std::future<PieceSurface> next = start(0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::future<PieceSurface> made = std::exchange(next, start(i + 1));
    if (!made.valid()) continue;
    while (made.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) show(static_cast<double>(i));
    PieceSurface surface = made.get();
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
    if (is_drawn(i)) surfaces[static_cast<std::size_t>(pieces[i].bone - in_bone.data())] = std::move(surface);
    show(static_cast<double>(i + 1));
  }
  return surfaces;
}

}  // namespace kerf
