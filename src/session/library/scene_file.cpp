#include <utility>

#include "base/core/cancelled.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "kerf/scene.h"
#include "session/library/progress.h"
#include "session/run/make_bone.h"
#include "session/run/run_slab.h"
#include "session/scene/edit_scene.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

SceneFile::SceneFile(std::string text, std::string path, std::shared_ptr<const Scene> scene)
    : text_(std::move(text)), path_(std::move(path)), scene_(std::move(scene)) {}

SceneFile::SceneFile() : SceneFile(Parse(DefaultSceneToml())) {}

SceneFile::SceneFile(const Scene& scene, std::string path)
    : SceneFile(ResolvedToml(scene), std::move(path), std::make_shared<const Scene>(scene)) {}

SceneFile SceneFile::Read(const std::string& path) {
  auto scene = std::make_shared<const Scene>(ReadScene(path));
  return {ReadTextFile(path), path, std::move(scene)};
}

SceneFile SceneFile::Parse(const std::string& toml, const std::string& path) {
  return {toml, path, std::make_shared<const Scene>(ParseScene(toml, path))};
}

SceneFile SceneFile::With(const std::string& table, const std::string& key, const std::string& value) const {
  return Parse(EditSceneText(text_, path_, {{table, key, value}}, ""), path_);
}

const std::string& SceneFile::toml() const {
  return text_;
}
const std::string& SceneFile::path() const {
  return path_;
}
const std::string& SceneFile::name() const {
  return scene_->name;
}
const std::string& SceneFile::title() const {
  return scene_->title;
}
std::string SceneFile::Resolve() const {
  return ResolvedToml(*scene_);
}

bool SceneFile::is_slab() const {
  return scene_->simulation.mode == SceneMode::kSlab;
}
double SceneFile::rate_hz() const {
  return scene_->simulation.rate_hz;
}
double SceneFile::rpm() const {
  return scene_->tool.CalcTickRpm();
}
Tool SceneFile::tool() const {
  return MakeTool(*scene_);
}
SimulationParams SceneFile::MakeSimulationParams() const {
  return kerf::MakeSimulationParams(*scene_);
}
CoupledParams SceneFile::MakeCoupledParams() const {
  return kerf::MakeCoupledParams(*scene_);
}
SlabParams SceneFile::MakeSlabParams() const {
  return kerf::MakeSlabParams(*scene_);
}

Bone SceneFile::MakeBone(const ShowProgress& progress) const {
  return OrCancelled([&] { return MakeSceneBone(*scene_, ThrowIfCancelled(progress)); });
}

SlabProfile SceneFile::MakeSlabProfile(const Bone& bone) const {
  return kerf::MakeSlabProfile(*scene_, bone);
}

std::vector<PathStep> SceneFile::ListPathSteps() const {
  const Path path = MakePath(*scene_);
  CheckRunTicks(path, rate_hz());
  PathDriver driver(path, rate_hz());
  std::vector<PathStep> steps;
  while (const std::optional<PathStep> step = driver.Next()) steps.push_back(*step);
  return steps;
}

}  // namespace kerf
