#include "bone/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>

#include "base/core/hash.h"
#include "base/files/memory.h"
#include "bone/grid/build.h"
#include "bone/grid/build_times.h"
#include "bone/import/ct_solid.h"
#include "bone/import/dicom.h"
#include "bone/import/hu_check.h"
#include "bone/import/hu_sampler.h"
#include "bone/import/image_file.h"
#include "bone/import/image_header.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/mesh_units.h"
#include "bone/import/patient_frame.h"
#include "bone/import/preview.h"
#include "bone/material/region_table.h"
#include "bone/mesh/meshfile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

constexpr double kRegionVoxel_mm = 0.2;
constexpr double kMeshLattice_mm = 0.7;  // for the depth below an imported surface
constexpr double kDust_mm3 = 1;
constexpr double kPreviewVoxel_mm = 0.8;

class Stages {
 public:
  explicit Stages(ImportReport& report) : report_(report) {}
  void Done(const std::string& name) {
    const auto now = Clock::now();
    report_.seconds.emplace_back(name, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  ImportReport& report_;
  Clock::time_point last_ = Clock::now();
};

// Parts of the import of a CT, in their order.
enum class CtPart { kRead, kPreview, kIsolate, kFill, kSolid, kTissues, kLevelSet, kPieces, kHu, kMeasure, kCount };

// Where the parts of the import of a CT begin and end in the progress of the whole, 0 to 1, so that progress is even in
// time. Measured with a head of 250 x 250 x 234 voxels on one core of 2.5 GHz, as are the BuildTimes.
class CtShares {
 public:
  explicit CtShares(const ImportOptions& options) {
    const double region_voxel_mm = std::max(options.voxel_mm, kRegionVoxel_mm);
    const double finer = std::pow(0.2 / options.voxel_mm, 2.2);
    const std::array<double, kCount> seconds{0.7,  // read; with the check of its values
                                             options.take_preview ? 2.8 : 0.0,
                                             0.7,
                                             0.5,
                                             0.25,
                                             0.1,
                                             EstimateBuildTimes(options.voxel_mm, region_voxel_mm).total_s(),
                                             0.15 * finer,
                                             options.keep_hu ? 0.1 : 0.0,
                                             0.3 * finer};
    double total = 0;
    for (std::size_t i = 0; i < kCount; ++i) ends_[i] = total += seconds[i];
    for (double& end : ends_) end /= total;
  }
  double Begin(CtPart part) const { return part == CtPart::kRead ? 0 : ends_[static_cast<std::size_t>(part) - 1]; }
  double End(CtPart part) const { return ends_[static_cast<std::size_t>(part)]; }

 private:
  static constexpr auto kCount = static_cast<std::size_t>(CtPart::kCount);
  std::array<double, kCount> ends_{};
};

// Returns a function that reports the progress of one part as progress of the whole, from `from` to `to`.
std::function<void(double)> Part(const std::function<void(double)>& progress, double from, double to) {
  if (!progress) return {};
  return [progress, from, to](double fraction) { progress(from + (to - from) * fraction); };
}

std::function<void(double)> Part(const ImportOptions& options, CtPart part) {
  const CtShares shares(options);
  return Part(options.progress, shares.Begin(part), shares.End(part));
}

void EndPart(const ImportOptions& options, CtPart part) {
  if (options.progress) options.progress(CtShares(options).End(part));
}

void CheckOptions(const ImportOptions& options) {
  if (!options.frame.empty()) LpsFromFrame(options.frame);
  CheckParameters(options, "import");
  if (!options.mesh_units.empty()) CalcMmPerUnit(options.mesh_units);
  for (const auto* points : {&options.isolate.keep_W, &options.isolate.drop_W}) {
    for (const Vec3& p : *points) {
      if (!std::isfinite(p.x + p.y + p.z))
        throw Error("a keep or drop point has a coordinate that is not a finite number");
    }
  }
}

}  // namespace

Volume ReadCt(const std::string& path, const ImportOptions& options, ImportReport& report) {
  std::error_code failed;
  if (fs::is_directory(path, failed)) {
    const std::vector<DicomSeries> all = ListDicomSeries(path, Part(options.progress, 0, 0));
    const DicomSeries& series = ChooseSeries(all, options.series, path);
    report.kind = "DICOM";
    report.series_uid = series.uid;
    Volume ct = ReadDicomSeries(series, Part(options, CtPart::kRead));
    if (!options.frame.empty()) ReinterpretFrame(options.frame, ct);
    return ct;
  }
  if (!fs::exists(path, failed)) throw Error(fmt::format("{}: no such file or folder", path));
  if (!HasImageExtension(path)) {
    throw Error(
        fmt::format("{}: unknown file type; kerf imports a folder of DICOM files, .nrrd .nhdr .nii .nii.gz .mha "
                    ".mhd, or a closed surface .stl .obj .ply",
                    path));
  }
  report.kind = "image";
  return ReadImageFile(path, options.frame);
}

// Reads the CT with its voxels along the patient's axes, and checks that its values are HU.
Volume ReadHu(const std::string& path, const ImportOptions& options, ImportReport& report) {
  Volume ct = StoreAlongPatient(ReadCt(path, options, report));
  if (const std::string warning = CheckHu(ct, options.isolate.iso_hu, path); !warning.empty())
    ct.warnings.push_back(warning);
  report.warnings = ct.warnings;
  report.size = ct.size;
  report.spacing_mm = ct.spacing_mm;
  report.input_hash = CalcHash(ct);
  return ct;
}

namespace {

MaterialTable ChooseTable(const ImportOptions& options, bool use_atlas) {
  if (!options.materials) return use_atlas ? DefaultMandibleTable() : MakePlainTable();
  CheckTable(*options.materials, use_atlas,
             options.materials_name.empty() ? "the region table" : options.materials_name);
  return *options.materials;
}

// Keeps the largest piece if one was isolated; counts the others.
void DropDust(Bone& bone, bool one_piece, ImportReport& report) {
  Pieces split = SplitPieces(bone, one_piece ? kDust_mm3 : 0);
  report.pieces = split.pieces.size();
  if (!one_piece || split.pieces.empty() || (split.pieces.size() == 1 && split.dust_count == 0)) return;
  report.dropped_pieces += split.dust_count + split.pieces.size() - 1;
  report.dropped_mm3 += split.dust_mm3;
  for (std::size_t n = 1; n < split.pieces.size(); ++n) report.dropped_mm3 += split.pieces[n].CalcVolume();
  bone = std::move(split.pieces.front());
  report.pieces = 1;
}

// Stores the CT's own numbers, not the smoothed and filled ones that the surface is made from.
void KeepHu(const Volume& ct, const ImportOptions& options, Bone& bone, ImportReport& report) {
  const Vec3& spacing = ct.spacing_mm;
  const double finest = std::min({spacing.x, spacing.y, spacing.z});
  report.hu_voxel_mm = options.hu_voxel_mm != 0 ? options.hu_voxel_mm
                                                : std::clamp(finest, std::max(options.voxel_mm, kHuVoxelRange_mm.lower),
                                                             kHuVoxelRange_mm.upper);
  const HuSampler sampler(ct);
  SetHu(
      bone, [&sampler](const Vec3& p_W) { return sampler.At(p_W); }, report.hu_voxel_mm);
  report.hu = CalcHuRange(bone);
  bone.set_note("import_hu_voxel_mm", fmt::format("{}", report.hu_voxel_mm));
}

void Measure(const Bone& bone, ImportReport& report) {
  report.solid_mm3 = bone.CalcVolume();
  report.box = bone.CalcBounds();
  report.active_voxels = bone.CountActiveVoxels();
  report.memory_bytes = bone.CalcMemoryBytes();
  report.region_mm3 = bone.CalcRegionVolumes();
}

std::string Points(const std::vector<Vec3>& points) {
  std::string text;
  for (const Vec3& p : points) text += fmt::format("{}{:.2f},{:.2f},{:.2f}", text.empty() ? "" : " ", p.x, p.y, p.z);
  return text;
}

void AddNotes(Bone& bone, const ImportOptions& options, const ImportReport& report) {
  bone.set_note("made_by", fmt::format("kerf import {} ({})", VersionString(), CommitString()));
  bone.set_note("import_input", report.kind);
  bone.set_note("import_input_hash", fmt::format("{:016x}", report.input_hash));
  bone.set_note("import_table", options.materials ? options.materials_name : "built in");
  bone.set_note("import_regions", report.mandible ? "atlas of the mandible" : "one cortical region");
  if (!options.frame.empty()) bone.set_note("import_frame", fmt::format("{}, as stated by --frame", options.frame));
  std::string warnings;
  for (const std::string& w : report.warnings) warnings += (warnings.empty() ? "" : ". ") + w;
  if (!warnings.empty()) bone.set_note("import_warnings", warnings);
  if (report.kind == "surface") {
    bone.set_note("import_shell_mm", fmt::format("{}", options.mesh_shell_mm));
    bone.set_note("import_units", options.mesh_units.empty() ? "mm" : options.mesh_units);
    bone.set_note("import_shells", report.surface.how);
    return;
  }
  if (!report.series_uid.empty()) bone.set_note("import_series_uid", report.series_uid);
  bone.set_note("import_ct_voxels", fmt::format("{} {} {}", report.size[0], report.size[1], report.size[2]));
  bone.set_note("import_ct_spacing_mm",
                fmt::format("{} {} {}", report.spacing_mm.x, report.spacing_mm.y, report.spacing_mm.z));
  bone.set_note("import_iso_HU", fmt::format("{}", options.isolate.iso_hu));
  if (options.fill) {
    bone.set_note("import_voids_filled", fmt::format("{} of {:.1f} mm3", report.voids.count, report.voids.mm3));
  }
  bone.set_note("import_isolation", report.isolation);
  if (!options.isolate.keep_W.empty()) bone.set_note("import_keep_mm", Points(options.isolate.keep_W));
  if (!options.isolate.drop_W.empty()) bone.set_note("import_drop_mm", Points(options.isolate.drop_W));
  if (const SurfaceError& e = report.surface_error; e.points > 0) {
    bone.set_note("import_surface_error_mm",
                  fmt::format("{:.2f} expected (rms): offset {:+.2f}, scatter {:.2f}; half height {:.0f} HU",
                              e.CalcExpected(), e.offset_mm, e.scatter_mm, e.half_height_hu));
  }
  bone.set_note("import_filled_mm3", fmt::format("{:.1f}", report.filled_mm3));
  bone.set_note("import_tissue_thresholds",
                fmt::format("cortical {} HU or nearer than {} mm to the surface; tooth {} HU, body {} HU within {} mm",
                            options.tissue.cortical_hu, options.tissue.shell_mm, options.tissue.tooth_hu,
                            options.tissue.tooth_body_hu, options.tissue.tooth_reach_mm));
}

// Calls Isolate(). Adds the assumptions made about the file to its error messages, because they may be the reason.
Isolation IsolateBone(const Volume& ct, const ImportOptions& options, const ImportReport& report) {
  try {
    return Isolate(ct, options.isolate, Part(options, CtPart::kIsolate));
  } catch (const Error& e) {
    std::string message = e.what();
    for (const std::string& warning : report.warnings) message += "\nwarning: " + warning;
    throw Error(message);
  }
}

void WarnAboutSurfaceError(double iso_hu, ImportReport& report) {
  const SurfaceError& e = report.surface_error;
  if (e.points == 0 || e.CalcExpected() <= kSurfaceErrorWarning_mm) return;
  report.warnings.push_back(fmt::format(
      "the surface has an expected error of {:.2f} mm (rms), above {} mm: the {:.0f} HU level lies {:.2f} mm {} the "
      "half height of the bone's edge ({:.0f} HU), and the spacing of {:.4g} x {:.4g} x {:.4g} mm adds a scatter of "
      "{:.2f} mm; a sharper CT reduces the error, while another iso level may lose thin bone",
      e.CalcExpected(), kSurfaceErrorWarning_mm, iso_hu, std::abs(e.offset_mm), e.offset_mm < 0 ? "inside" : "outside",
      e.half_height_hu, report.spacing_mm.x, report.spacing_mm.y, report.spacing_mm.z, e.scatter_mm));
}

// Passes the CT and a coarse bone on to those who look at the import.
void Show(const std::shared_ptr<const Volume>& ct, const ImportOptions& options) {
  if (options.take_ct) options.take_ct(ct);
  if (!options.take_preview) return;
  try {
    options.take_preview(MakePreview(*ct, options.isolate.iso_hu, std::max(options.voxel_mm, kPreviewVoxel_mm),
                                     Part(options, CtPart::kPreview)));
  } catch (const Error&) {  // the import itself reports the reason
  }
}

ImportResult ImportCt(const std::string& path, const ImportOptions& options) {
  ImportResult result;
  ImportReport& report = result.report;
  Stages stages(report);
  Isolation isolation;
  {
    const auto ct = std::make_shared<const Volume>(ReadHu(path, options, report));
    stages.Done("read");
    Show(ct, options);
    isolation = IsolateBone(*ct, options, report);
  }
  report.isolation = isolation.how;
  report.iso_mm3 = isolation.iso_volume_mm3;
  report.contact_mm2 = isolation.contact_mm2;
  report.dropped_pieces = isolation.dropped_pieces;
  report.dropped_mm3 = isolation.dropped_mm3;
  report.cut_by_scan = isolation.cut_by_scan;
  report.mandible = isolation.mandible;
  report.shape_objection = isolation.shape_objection;
  stages.Done("isolate");

  std::vector<std::uint8_t> cavities(isolation.ct.count(), 0);
  if (options.fill) {
    cavities = FindCavities(isolation.ct, isolation.bone, options.cavities, Part(options, CtPart::kFill));
  }
  std::vector<std::uint8_t> solid_voxels = isolation.bone;
  std::size_t filled = 0;
  for (std::size_t v = 0; v < cavities.size(); ++v) {
    filled += cavities[v];
    solid_voxels[v] |= cavities[v];
  }
  report.filled_mm3 = static_cast<double>(filled) * isolation.ct.CalcVoxelVolume();
  // Filled marrow must stay below the cortex's threshold, because the same field distinguishes the tissues.
  const double iso = options.isolate.iso_hu;
  const CtSolid solid(isolation, cavities, iso, iso + std::max(0.5 * (options.tissue.cortical_hu - iso), 1.0));
  stages.Done("fill");
  report.surface_error = CalcSurfaceError(solid, isolation, cavities);
  WarnAboutSurfaceError(options.isolate.iso_hu, report);
  stages.Done("surface error");
  EndPart(options, CtPart::kSolid);

  const TissueMap tissue(isolation.ct, solid_voxels, isolation.bone, &solid.hu(), report.mandible, options.tissue);
  report.tooth_mm3 = tissue.tooth_mm3();
  stages.Done("tissues");
  EndPart(options, CtPart::kTissues);

  SolidField field;
  field.value = [&solid](const Vec3& p_W) { return solid.Value(p_W); };
  field.classify = [&solid](const Vec3& p_W, double radius_mm) { return solid.Classify(p_W, radius_mm); };
  field.region = [&tissue](const Vec3& p_W) { return tissue.RegionAt(p_W); };
  field.is_distance = false;
  BuildOptions build;
  build.max_bytes = static_cast<double>(ReadAvailableBytes());
  build.voxel_mm = options.voxel_mm;
  build.region_voxel_mm = std::max(options.voxel_mm, kRegionVoxel_mm);
  build.progress = Part(options, CtPart::kLevelSet);
  if (options.fill) build.fill_voids = &report.voids;
  result.bone = MakeBone(field, solid.box().Grown(6 * options.voxel_mm), build, ChooseTable(options, report.mandible));
  stages.Done("level set");
  DropDust(result.bone, options.isolate.isolate, report);
  stages.Done("pieces");
  EndPart(options, CtPart::kPieces);
  if (options.keep_hu) {
    KeepHu(isolation.ct, options, result.bone, report);
    stages.Done("CT numbers");
  }
  EndPart(options, CtPart::kHu);
  Measure(result.bone, report);
  AddNotes(result.bone, options, report);
  stages.Done("measure");
  return result;
}

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
}

// Transforms to LPS a surface whose coordinates are those of `frame`.
void ReinterpretFrame(const std::string& frame, TriangleMesh& mesh) {
  const glm::dmat3 turn = LpsFromFrame(frame);
  for (Vec3& p : mesh.points) p = turn * p;
  if (glm::determinant(turn) > 0) return;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // a reflection turns triangles inside out
}

ImportResult ImportMesh(const std::string& path, const ImportOptions& options) {
  ImportResult result;
  CheckMeshOptions(path, options);
  ImportReport& report = result.report;
  report.kind = "surface";
  Stages stages(report);
  TriangleMesh mesh = ReadMesh(path);
  if (!options.frame.empty()) ReinterpretFrame(options.frame, mesh);
  report.input_hash = HashMesh(mesh);
  if (const std::string warning = ScaleToMm(mesh, options.mesh_units, path); !warning.empty()) {
    report.warnings.push_back(warning);
  }
  const ClosedSurface closed = CloseSurface(std::move(mesh), !options.fill, path);
  report.surface = closed.report;
  report.warnings.insert(report.warnings.end(), closed.report.repairs.begin(), closed.report.repairs.end());
  report.isolation = "none: the surface as it is";
  stages.Done("read");
  CheckEnclosed(closed.layers.front(), options.voxel_mm, path);
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
  if (!parts.list.empty()) {
    const MandibleLikeness likeness = CheckMandibleLikeness(lattice, parts.labels, 1, parts.list.front());
    report.mandible = likeness.is_mandible;
    report.shape_objection = Describe(likeness, options.frame.empty() ? "LPS" : options.frame);
  }
  TissueOptions tissue_options = options.tissue;
  tissue_options.shell_mm = options.mesh_shell_mm;
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
  Measure(result.bone, report);
  AddNotes(result.bone, options, report);
  stages.Done("measure");
  return result;
}

}  // namespace

bool IsSurfacePath(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".stl" || extension == ".obj" || extension == ".ply";
}

ImportResult Import(const std::string& path, const ImportOptions& options) {
  CheckOptions(options);
  ImportResult result = IsSurfacePath(path) ? ImportMesh(path, options) : ImportCt(path, options);
  if (options.progress) options.progress(1);
  return result;
}

}  // namespace kerf
