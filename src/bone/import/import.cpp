#include "bone/import/import.h"

#include <cmath>

#include "base/files/extension.h"
#include "bone/import/import_steps.h"
#include "bone/import/mesh_units.h"
#include "bone/import/patient_frame.h"
#include "kerf/error.h"

namespace kerf {
namespace {

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

bool IsSurfacePath(const std::string& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".stl" || extension == ".obj" || extension == ".ply";
}

ImportResult Import(const std::string& path, const ImportOptions& options) {
  CheckOptions(options);
  const bool mask_only = path.empty() && options.isolate.mask;
  ImportResult result = mask_only             ? ImportMask(options)
                        : IsSurfacePath(path) ? ImportMesh(path, options)
                                              : ImportCt(path, options);
  if (options.progress) options.progress(1);
  return result;
}

}  // namespace kerf
