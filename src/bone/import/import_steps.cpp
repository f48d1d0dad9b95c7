#include "bone/import/import_steps.h"

#include <fmt/format.h>

#include "base/core/number_text.h"
#include "bone/import/hu_check.h"
#include "bone/material/region_table.h"
#include "bone/material/segment_regions.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"

namespace kerf {
namespace {

constexpr double kDust_mm3 = 1;

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
  if (!report.shape_objection.empty()) bone.set_note("import_shape", report.shape_objection);
  if (!options.frame.empty()) bone.set_note("import_frame", fmt::format("{}, as stated by --frame", options.frame));
  if (options.spacing_z_mm != 0) bone.set_note("import_spacing_z_mm", fmt::format("{}", options.spacing_z_mm));
  std::string warnings;
  for (const std::string& w : report.warnings) warnings += (warnings.empty() ? "" : ". ") + w;
  if (!warnings.empty()) bone.set_note("import_warnings", warnings);
  if (report.mask.used) {
    const BoneMask& mask = *options.isolate.mask;
    bone.set_note("import_mask", mask.how);
    bone.set_note("import_mask_hash", fmt::format("{:016x}", CalcHash(mask.tissue)));
    if (report.kind != "mask") {
      bone.set_note("import_mask_override",
                    fmt::format("reach {:.4g} mm; {:.1f} mm3 added, {:.1f} mm3 cut off, {:.1f} mm3 given away",
                                report.mask.reach_mm, report.mask.added_mm3, report.mask.cut_off_mm3,
                                report.mask.given_away_mm3));
    }
  }
  if (report.kind == "mask") {
    bone.set_note("import_shell_mm", fmt::format("{}", options.mesh_shell_mm));
    return;
  }
  if (report.kind == "surface") {
    bone.set_note("import_shell_mm", fmt::format("{}", options.mesh_shell_mm));
    bone.set_note("import_units", options.mesh_units.empty() ? "mm" : options.mesh_units);
    bone.set_note("import_shells", report.surface.how);
    return;
  }
  if (!report.series_uid.empty()) bone.set_note("import_series_uid", report.series_uid);
  if (!report.study_date.empty()) bone.set_note("import_study_date", report.study_date);
  bone.set_note("import_ct_voxels", fmt::format("{} {} {}", report.size[0], report.size[1], report.size[2]));
  bone.set_note("import_ct_spacing_mm",
                fmt::format("{} {} {}", report.spacing_mm.x, report.spacing_mm.y, report.spacing_mm.z));
  bone.set_note("import_iso_HU", fmt::format("{}", report.iso));
  if (options.fill) {
    bone.set_note("import_voids_filled", fmt::format("{} of {:.1f} mm3", report.voids.count, report.voids.mm3));
  }
  bone.set_note("import_isolation", report.isolation);
  if (report.cut_by_scan) {
    bone.set_note("import_cut_by_scan",
                  fmt::format("the bone reaches the edge of the scan, over {:.0f} mm2", report.cut_mm2));
  }
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

// Warns if much of the mask's metal or lesion is not in the bone.
void WarnAboutLoss(const BoneMask& mask, ImportReport& report) {
  constexpr double kNotable = 0.2;  // fraction of the structure; its surface is that of the CT
  const auto in_mask = [&](bool (*is)(MaskTissue)) {
    return static_cast<double>(CountTissue(mask, is)) * mask.tissue.CalcVoxelVolume();
  };
  const auto in_bone = [&](int region) {
    const auto found = report.region_mm3.find(region);
    return found == report.region_mm3.end() ? 0 : found->second;
  };
  const double metal_mm3 = in_mask(IsMetal), kept_metal_mm3 = in_bone(kMetalRegion);
  if (kept_metal_mm3 < (1 - kNotable) * metal_mm3) {
    report.warnings.push_back(
        fmt::format("the mask has {} of metal, of which {} are in the bone; the rest is not joined to it",
                    FormatVolume(metal_mm3), FormatVolume(kept_metal_mm3)));
  }
  const double lesion_mm3 = in_mask(IsLesion), kept_lesion_mm3 = in_bone(kLesionRegion);
  if (kept_lesion_mm3 < (1 - kNotable) * lesion_mm3) {
    report.warnings.push_back(
        fmt::format("the mask has a lesion of {}, of which {} are in the bone; the rest is not joined to it",
                    FormatVolume(lesion_mm3), FormatVolume(kept_lesion_mm3)));
  }
}

// Warns if the solid is notably smaller than what the input shows.
void WarnAboutThinParts(double voxel_mm, ImportReport& report) {
  constexpr double kNotable = 0.05;
  const double lost = 1 - report.solid_mm3 / std::max(report.input_mm3, 1e-9);
  if (report.input_mm3 <= 0 || lost < kNotable) return;
  // With voxels much smaller than the scan's, smaller ones change nothing.
  const Vec3& scan_mm = report.spacing_mm;
  const bool is_fine = 2 * voxel_mm < std::max({scan_mm.x, scan_mm.y, scan_mm.z});
  const std::string solid = FormatVolume(report.solid_mm3), input = FormatVolume(report.input_mm3);
  if (is_fine) {
    report.warnings.push_back(fmt::format(
        "the bone of {} is {:.0f} % smaller than the {} of the input: thin parts were lost; use a finer scan", solid,
        100 * lost, input));
  } else {
    report.warnings.push_back(fmt::format(
        "the bone of {} is {:.0f} % smaller than the {} of the input: thin parts were lost; use voxels smaller than "
        "{:g} mm (--voxel), or a finer scan",
        solid, 100 * lost, input, voxel_mm));
  }
}

}  // namespace

std::function<void(double)> Part(const std::function<void(double)>& progress, double from, double to) {
  if (!progress) return {};
  return [progress, from, to](double fraction) { progress(from + (to - from) * fraction); };
}

MaterialTable ChooseTable(const ImportOptions& options, bool use_atlas) {
  const bool has_canal = options.isolate.mask && CountTissue(*options.isolate.mask, IsCanal) > 0;
  const std::string name = options.materials_name.empty() ? "the region table" : options.materials_name;
  MaterialTable table;
  if (options.materials) {
    table = *options.materials;
    if (has_canal && !table.Contains(kCanalRegion)) {
      throw Error(
          fmt::format("{}: the table lacks region {}, the nerve's canal, which the mask contains", name, kCanalRegion));
    }
    CheckTable(table, use_atlas, name);
  } else {
    table = use_atlas ? DefaultMandibleTable() : MakePlainTable();
    if (has_canal && !table.Contains(kCanalRegion)) table.Add(DefaultMandibleTable().At(kCanalRegion));
  }
  if (!options.isolate.mask) return table;
  const BoneMask& mask = *options.isolate.mask;
  for (const int fdi : ListTeeth(mask)) AddTooth(fdi, name, table);
  if (CountTissue(mask, IsMetal) > 0) AddMetal(name, table);
  if (CountTissue(mask, IsLesion) > 0) AddLesion(name, table);
  return table;
}

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

void Finish(const ImportOptions& options, Bone& bone, ImportReport& report) {
  Measure(bone, report);
  WarnAboutThinParts(options.voxel_mm, report);
  if (options.isolate.mask) {
    WarnAboutLoss(*options.isolate.mask, report);
    if (report.pieces > 1)
      report.warnings.push_back(fmt::format("the segmentation gives {} separate pieces of bone", report.pieces));
  }
  AddNotes(bone, options, report);
}

}  // namespace kerf
