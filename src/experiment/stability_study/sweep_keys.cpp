#include "experiment/stability_study/sweep_keys.h"

#include <fmt/format.h>

#include <cmath>

#include "kerf/error.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

/// A visitor for Describe() that passes on only numbers, by name.
template <typename Use>
class Numbers {
 public:
  explicit Numbers(Use use) : use_(std::move(use)) {}
  void Table(std::string table) { table_ = std::move(table); }

  void operator()(const char* key, double& value, Range range, const char*) { use_(table_ + "." + key, value, range); }
  void operator()(const char* key, int& value, Range range, const char*) {
    double number = value;
    use_(table_ + "." + key, number, range);
    value = static_cast<int>(std::lround(number));
  }
  template <typename... Rest>
  void operator()(const char*, Rest&&...) {}

 private:
  Use use_;
  std::string table_;
};

template <typename Visitor>
void WalkBone(SceneBone& bone, Visitor& visit) {
  if (bone.source == BoneSource::kMandible) {
    visit.Table("bone.mandible");
    Describe(bone.mandible, visit);
  }
  if (bone.source != BoneSource::kBlock && bone.source != BoneSource::kPlate) return;
  const std::string table = fmt::format("bone.{}", ToString(bone.source));
  visit.Table(table);
  Describe(bone.block, visit);
  for (std::size_t i = 0; i < bone.block.layers.size(); ++i) {
    visit.Table(fmt::format("{}.layer[{}]", table, i));
    Describe(bone.block.layers[i], visit);
  }
}

template <typename Use>
void Walk(Scene& scene, Use use) {
  Numbers<Use> visit(std::move(use));
  const auto section = [&](const char* table, auto& params) {
    visit.Table(table);
    Describe(params, visit);
  };
  WalkBone(scene.bone, visit);
  if (scene.material.kind == MaterialKind::kUniform) {
    visit.Table("material");
    DescribeUniform(scene.material, visit);
  }
  section("tool", scene.tool);
  if (!scene.path.strokes.empty()) section("path.stroke[0]", scene.path.strokes.front());
  section("force", scene.force);
  section("simulation", scene.simulation);
  section("output", scene.output);
  for (EffectChoice& effect : scene.effects) section(fmt::format("effects.{}", effect.name()).c_str(), effect);
  section("coupling", scene.coupling);
  section("device", scene.device);
  section("hand", scene.hand);
  section("loop", scene.loop);
}

/// Returns the same scene with the defaults of the schema.
Scene WithDefaults(const Scene& scene) {
  Scene plain = scene;
  plain.bone.mandible = {};
  if (scene.bone.source == BoneSource::kPlate) {
    plain.bone.block = MakePlateParams();
  } else {
    plain.bone.block = {};
  }
  plain.bone.block.layers = scene.bone.block.layers;
  plain.material = {};
  plain.material.kind = scene.material.kind;
  plain.tool = {};
  plain.tool.shape = GetDefaultTools()[scene.tool.shape.index()];
  if (!plain.path.strokes.empty()) plain.path.strokes.front() = {};
  plain.force = ForceLaw(scene.force.name());
  plain.simulation = {};
  plain.output = {};
  for (EffectChoice& effect : plain.effects) effect = EffectChoice(effect.name());
  plain.coupling = {};
  plain.device = {};
  plain.hand = {};
  plain.loop = {};
  return plain;
}

}  // namespace

std::vector<SweepKey> ListSweepKeys(const Scene& scene) {
  std::vector<SweepKey> keys;
  Scene own = scene;
  Walk(own, [&](const std::string& name, double& value, Range range) {
    keys.push_back({name, range.lower, range.upper, value, value});
  });
  Scene plain = WithDefaults(scene);
  std::size_t i = 0;
  Walk(plain, [&](const std::string& name, double& value, Range) {
    if (i < keys.size() && keys[i].name == name) keys[i].default_value = value;
    ++i;
  });
  return keys;
}

void SetSweepKey(Scene& scene, const std::string& name, double to) {
  bool found = false;
  Walk(scene, [&](const std::string& key, double& value, Range) {
    if (key != name) return;
    value = to;
    found = true;
  });
  if (!found) throw Error(fmt::format("{}: the scene has no such number", name));
}

}  // namespace kerf
