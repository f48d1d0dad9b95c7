#include "session/run/write_pieces.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <future>
#include <numeric>
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
  std::vector<std::atomic<double>> made_mm3(pieces.size());
  double all_mm3 = 0;
  for (const ResultPiece& piece : pieces) all_mm3 += piece.volume_mm3;
  const auto start = [&](std::size_t i) {
    std::future<PieceSurface> surface;
    if (i < pieces.size() && (scene.output.pieces || is_drawn(i))) {
      surface = std::async(std::launch::async, [&, i] {
        return MakePieceSurface(*pieces[i].bone, error_mm, scene.output.pieces,
                                [&, i](double fraction) { made_mm3[i] = fraction * pieces[i].volume_mm3; });
      });
    }
    return surface;
  };
  const auto show = [&] {
    if (progress) progress(std::accumulate(made_mm3.begin(), made_mm3.end(), 0.0) / all_mm3);
  };
  // Two at a time, because parts of this work use one thread only.
  std::future<PieceSurface> next = start(0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::future<PieceSurface> made = std::exchange(next, start(i + 1));
    if (!made.valid()) {
      made_mm3[i] = pieces[i].volume_mm3;
      continue;
    }
    while (made.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) show();
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
    made_mm3[i] = pieces[i].volume_mm3;
    show();
    if (is_drawn(i)) surfaces[static_cast<std::size_t>(pieces[i].bone - in_bone.data())] = std::move(surface);
  }
  return surfaces;
}

}  // namespace kerf
