// Import of a bone from a closed surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

#include "base/core/hash.h"
#include "base/files/memory.h"
#include "bone/grid/build.h"
#include "bone/import/import_steps.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/mesh_units.h"
#include "bone/import/patient_frame.h"
#include "bone/mesh/meshfile.h"
#include "kerf/error.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

constexpr double kMeshLattice_mm = 0.7;  // for the depth below the surface

std::uint64_t HashMesh(const TriangleMesh& mesh) {
  std::uint64_t hash = MixHash(mesh.points.size());
  const auto mix = [&hash](std::uint64_t value) { hash = MixHash(hash ^ value); };
  for (const Vec3& p : mesh.points) {
    for (int a = 0; a < 3; ++a) mix(static_cast<std::uint64_t>(std::llround(p[a] * 1e6)));
  }
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t i : t) mix(i);
  }
  return hash;
}

/// Throws kerf::Error for options that have an effect only on a CT.
void CheckMeshOptions(const std::string& path, const ImportOptions& options) {
  if (options.keep_hu) throw Error(fmt::format("{}: a surface has no CT numbers to keep", path));
  if (!options.isolate.keep_W.empty() || !options.isolate.drop_W.empty()) {
    throw Error(
        fmt::format("{}: points to keep or to drop select bone in a CT; a surface is imported whole: remove unwanted "
                    "parts in a mesh program",
                    path));
  }
  if (!options.series.empty()) throw Error(fmt::format("{}: a surface has no series to choose", path));
  if (options.isolate.mask) throw Error(fmt::format("{}: a mask selects bone in a CT, not in a surface", path));
}

// Transforms to LPS a surface whose coordinates are those of `frame`, whatever its file says.
void ReinterpretFrame(const std::string& frame, MeshFile& file) {
  const glm::dmat3 turn = LpsFromFrame(frame);
  for (Vec3& p : file.mesh.points) p = turn * p;
  if (!file.space.empty() && turn != LpsFromFrame(file.space)) {
    file.notes.push_back(
        fmt::format("the file says SPACE={}, but was read as {} because of --frame", file.space, FrameName(turn)));
  }
  if (glm::determinant(turn) > 0) return;
  for (auto& t : file.mesh.triangles) std::swap(t[1], t[2]);  // a reflection turns triangles inside out
}

// Returns the closed surface in mm and LPS; adds what was assumed or repaired to the warnings, and the file's unit to
// the options.
ClosedSurface ReadSurface(const std::string& path, ImportOptions& options, ImportReport& report) {
  MeshFile file = ReadMeshFile(path);
  if (options.frame.empty()) {
    TurnToLps(file);
  } else {
    ReinterpretFrame(options.frame, file);
  }
  report.input_hash = HashMesh(file.mesh);
  if (options.mesh_units.empty()) {
    options.mesh_units = file.unit;
    if (!file.unit.empty() && file.unit != "mm")
      file.notes.push_back(fmt::format("the file says that its unit is {}; --units overrides it", file.unit));
    if (file.unit.empty() && !file.unknown_unit.empty()) {
      file.notes.push_back(fmt::format(
          "the file says that its unit is '{}', which kerf does not know: mm was assumed; --units states another",
          file.unknown_unit));
    }
  }
  report.warnings = file.notes;
  try {
    ScaleToMm(file.mesh, options.mesh_units, path);
    ClosedSurface closed = CloseSurface(std::move(file.mesh), !options.fill, path);
    const std::vector<std::string>& repairs = closed.report.repairs;
    report.warnings.insert(report.warnings.end(), repairs.begin(), repairs.end());
    return closed;
  } catch (const UnclearUnit&) {
    throw;
  } catch (const Error& e) {
    // What was found while reading may be the reason: a surface that is cut off is not closed.
    throw Error(file.notes.empty() ? e.what() : fmt::format("{}; {}", e.what(), fmt::join(file.notes, "; ")));
  }
}

}  // namespace

ImportResult ImportMesh(const std::string& path, const ImportOptions& given) {
  ImportOptions options = given;
  ImportResult result;
  CheckMeshOptions(path, options);
  ImportReport& report = result.report;
  report.kind = "surface";
  Stages stages(report);
  const ClosedSurface closed = ReadSurface(path, options, report);
  report.surface = closed.report;
  report.isolation = "none: the surface as it is";
  stages.Done("read");
  CheckEnclosed(closed.layers.front(), options.voxel_mm, path);
  for (std::size_t n = 0; n < closed.layers.size(); ++n) {
    report.input_mm3 += (n % 2 == 0 ? 1 : -1) * std::abs(CalcEnclosedVolume(closed.layers[n]));
  }
  if (options.progress) options.progress(0.05);

  // Shape and depth are determined on a lattice whose voxels are either inside or outside.
  Box3 box;
  for (const Vec3& p : closed.layers.front().points) box.Include(p);
  BuildOptions coarse;
  coarse.max_bytes = static_cast<double>(ReadAvailableBytes());
  coarse.voxel_mm = std::max({options.voxel_mm, kMeshLattice_mm, std::min(glm::length(box.size()) / 400, 4.0)});
  coarse.region_voxel_mm = coarse.voxel_mm;
  Volume lattice;
  lattice.spacing_mm = Vec3(coarse.voxel_mm);
  lattice.origin_W = box.lower - 4 * coarse.voxel_mm;
  for (int a = 0; a < 3; ++a) lattice.size[a] = static_cast<int>(std::ceil(box.size()[a] / coarse.voxel_mm)) + 9;
  std::vector<std::uint8_t> solid(lattice.count(), 0);
  {
    const Bone draft = MakeBoneFromMesh(
        closed.layers, [](const Vec3&) { return TissueMap::kPlainCortexRegion; }, coarse, MakePlainTable());
    if (options.take_preview) options.take_preview(draft);
    if (options.progress) options.progress(0.08);
    for (int k = 0; k < lattice.size[2]; ++k) {
      for (int j = 0; j < lattice.size[1]; ++j) {
        for (int i = 0; i < lattice.size[0]; ++i) {
          solid[lattice.Index(i, j, k)] = draft.SignedDistance(lattice.WorldFromVoxel({i, j, k})) < 0 ? 1 : 0;
        }
      }
    }
  }
  const Components parts = FindComponents(lattice, [&solid](std::size_t v) { return solid[v] != 0; });
  TissueOptions tissue_options = options.tissue;
  tissue_options.shell_mm = options.mesh_shell_mm;
  if (!parts.list.empty()) {
    const MandibleLikeness likeness = CheckMandibleLikeness(lattice, parts.labels, 1, parts.list.front());
    report.mandible = likeness.is_mandible;
    report.shape_objection = Describe(likeness, options.frame.empty() ? "LPS" : options.frame);
    tissue_options.up_W = likeness.up_W;
  }
  const TissueMap tissue(lattice, solid, solid, nullptr, report.mandible, tissue_options);
  stages.Done("tissues");
  if (options.progress) options.progress(0.15);

  BuildOptions build;
  build.max_bytes = static_cast<double>(ReadAvailableBytes());
  build.voxel_mm = options.voxel_mm;
  build.region_voxel_mm = std::max(options.voxel_mm, kRegionVoxel_mm);
  build.progress = Part(options.progress, 0.15, 0.75);
  result.bone = MakeBoneFromMesh(
      closed.layers, [&tissue](const Vec3& p_W) { return tissue.RegionAt(p_W); }, build,
      ChooseTable(options, report.mandible));
  stages.Done("level set");
  if (options.progress) options.progress(0.8);
  DropDust(result.bone, false, report);
  if (options.progress) options.progress(0.85);
  if (report.pieces == 0) {
    throw Error(
        fmt::format("{}: with voxels of {:g} mm the surface encloses no piece of {:g} mm3 or more; check its unit "
                    "(--units) or use finer voxels (--voxel)",
                    path, options.voxel_mm, kSmallestPiece_mm3));
  }
  Finish(options, result.bone, report);
  stages.Done("measure");
  return result;
}

}  // namespace kerf
