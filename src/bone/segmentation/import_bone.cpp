#include "base/core/cancelled.h"
#include "bone/import/import.h"
#include "bone/segmentation/mask_file.h"
#include "kerf/describe.h"
#include "kerf/error.h"
#include "kerf/import.h"

namespace kerf {
namespace {

/// Throws kerf::Error if a mask cannot be used with the input, or a setting has no effect without one.
void CheckMaskUse(const std::string& path, const ImportSettings& settings) {
  if (settings.mask.empty()) {
    if (path.empty()) throw Error("neither a CT, a surface nor a mask is given");
    if (!settings.mask_labels.empty() || !settings.mask_label.empty() || settings.mask_reach_mm > 0 ||
        settings.mask_threshold != LabelOptions().threshold) {
      throw Error("mask_labels, mask_label, mask_threshold and mask_reach_mm apply to a mask only, but none is given");
    }
    return;
  }
  if (IsSurfacePath(path)) throw Error(path + ": a mask applies to a CT only, but this is a surface");
  if (!settings.isolate) throw Error("isolate = false imports all bone, but the mask selects one");
}

}  // namespace

ImportedBone ImportBone(const std::string& path, const ImportSettings& settings) {
  ImportOptions options;
  options.series = settings.series;
  options.as_ct = settings.as_ct;
  options.frame = settings.frame;
  options.spacing_z_mm = settings.spacing_z_mm;
  options.voxel_mm = settings.voxel_mm;
  options.isolate.iso_hu = settings.iso_hu;
  options.iso_auto = settings.iso_auto;
  options.isolate.isolate = settings.isolate;
  options.isolate.keep_W = settings.keep_W;
  options.isolate.drop_W = settings.drop_W;
  options.fill = settings.fill;
  options.keep_hu = settings.keep_hu;
  options.mesh_units = settings.mesh_units;
  options.mesh_shell_mm = settings.mesh_shell_mm;
  options.materials = settings.materials;
  if (settings.materials) options.materials_name = "the given table of regions";
  if (settings.progress) {
    options.progress = [&](double fraction) {
      if (!settings.progress(fraction)) throw Cancelled();
    };
  }
  options.isolate.mask_reach_mm = settings.mask_reach_mm;
  CheckParameters(options);
  LabelOptions labels{
      .preset = settings.mask_labels, .assignments = settings.mask_label, .threshold = settings.mask_threshold};
  CheckParameters(labels);
  CheckMaskUse(path, settings);
  try {
    if (!settings.mask.empty()) {
      const bool has_ct = !path.empty();
      options.isolate.mask = ReadMaskFile(settings.mask, has_ct ? "" : settings.frame, labels, has_ct).mask;
    }
    ImportResult result = Import(path, options);
    return {.bone = std::move(result.bone),
            .mandible = result.report.mandible,
            .surface_error_mm = result.report.surface_error.CalcExpected(),
            .warnings = std::move(result.report.warnings)};
  } catch (const Cancelled&) {
    throw Error((path.empty() ? settings.mask : path) + ": the import was cancelled");
  }
}

}  // namespace kerf
