#include "base/core/cancelled.h"
#include "bone/import/import.h"
#include "kerf/describe.h"
#include "kerf/error.h"
#include "kerf/import.h"

namespace kerf {

ImportedBone ImportBone(const std::string& path, const ImportSettings& settings) {
  ImportOptions options;
  options.series = settings.series;
  options.frame = settings.frame;
  options.voxel_mm = settings.voxel_mm;
  options.isolate.iso_hu = settings.iso_hu;
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
  CheckParameters(options);
  try {
    ImportResult result = Import(path, options);
    return {.bone = std::move(result.bone),
            .mandible = result.report.mandible,
            .surface_error_mm = result.report.surface_error.CalcExpected(),
            .warnings = std::move(result.report.warnings)};
  } catch (const Cancelled&) {
    throw Error(path + ": the import was cancelled");
  }
}

}  // namespace kerf
