// Section [plan] of a scene: planes and depth stops.
#pragma once

#include <string>
#include <vector>

#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "session/plan/plan.h"
#include "session/scene/schema.h"

namespace kerf {

/// A file of 3D Slicer from which a plane is read.
struct PlanFile {
  std::size_t plane = 0;
  std::string file;   // absolute path
  std::string place;  // prefix of messages about it: "scene.toml:12:1: "
};

/// Reads [plan]. Planes from files are returned, to be read by ReadPlanFiles().
std::vector<PlanFile> ReadPlan(TableReader& root, Plan& plan, const std::string& scene_file, Faults& faults);
/// Sets the planes from the files. Throws kerf::Error with the place of the key.
void ReadPlanFiles(const std::vector<PlanFile>& files, Plan& plan);

}  // namespace kerf
