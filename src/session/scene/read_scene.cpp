#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "base/core/printable.h"
#include "base/files/files.h"
#include "base/files/markups.h"
#include "base/toml/table_reader.h"
#include "bone/material/ct_law_table.h"
#include "bone/mesh/meshfile.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"
#include "session/scene/exercise_section.h"
#include "session/scene/file_names.h"
#include "session/scene/force_section.h"
#include "session/scene/path.h"
#include "session/scene/path_csv.h"
#include "session/scene/plan_section.h"
#include "session/scene/scene.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

// Maximum size of a scene, which has at most a thousand strokes of a few hundred bytes each.
constexpr std::size_t kMaxSceneBytes = std::size_t{4} << 20;
constexpr std::size_t kMaxPathFileBytes = std::size_t{256} << 20;
constexpr TextLimit kTitleLimit{200};

/// Tolerances for a stroke that continues from the previous one.
constexpr double kSamePointTolerance_mm = 1e-6;
constexpr double kSameDirectionTolerance = 1e-9;

void ReadBlock(TableReader& bone, const char* key, BlockParams& block, Faults& faults) {
  const TomlNode* table = bone.Table(key);
  if (table == nullptr) return;
  TableReader reader(*table, fmt::format("[bone.{}]", key), faults);
  Describe(block, reader);
  const std::string layer_name = fmt::format("[[bone.{}.layer]]", key);
  const std::vector<const TomlNode*> layers = reader.Tables("layer", kMaxLayers);
  // Layers in the file replace those of the model.
  if (reader.Has("layer")) block.layers.clear();
  for (const TomlNode* item : layers) {
    TableReader layer_reader(*item, layer_name, faults);
    MaterialLayer layer;
    Describe(layer, layer_reader);
    layer_reader.Require("thickness_mm");
    layer_reader.Require("region");
    layer_reader.Finish();
    block.layers.push_back(layer);
  }
  reader.Finish();
}

void ReadMandible(TableReader& bone, MandibleParams& mandible, Faults& faults) {
  const TomlNode* table = bone.Table("mandible");
  if (table == nullptr) return;
  TableReader reader(*table, "[bone.mandible]", faults);
  Describe(mandible, reader);
  reader.Finish();
}

void ReadBoneTable(TableReader& root, SceneBone& bone, const std::string& scene_file, Faults& faults) {
  root.Require("bone");
  const TomlNode* table = root.Table("bone");
  if (table == nullptr) return;
  TableReader reader(*table, "[bone]", faults);

  std::string model;
  reader("model", model, Choices{BoneModelWords()}, "");
  ReadFileName(reader, "file", bone.file, scene_file);
  ReadFileName(reader, "materials", bone.materials, scene_file);
  if (reader.Has("file") && reader.Has("model")) {
    reader.Fault("model", "[bone] has both file and model; keep one of them");
  } else if (!reader.Has("file") && !reader.Has("model")) {
    reader.Fault("file", fmt::format("[bone] has neither file (a .vdb) nor model (\"{}\")",
                                     fmt::join(BoneModelWords(), "\" or \"")));
  }
  bone.source = reader.Has("file") ? BoneSource::kFile : BoneSourceFromModel(model);

  // The parameters of every model are read, so that faults in them are reported even if another model is used.
  if (bone.source == BoneSource::kPlate) bone.block = MakePlateParams();
  ReadMandible(reader, bone.mandible, faults);
  ReadBlock(reader, "block", bone.block, faults);
  ReadBlock(reader, "plate", bone.block, faults);
  for (const std::string_view word : BoneModelWords()) {
    const std::string key(word);
    if (!reader.Has(key.c_str()) || bone.source == BoneSourceFromModel(key)) continue;
    if (reader.Has("file") || !model.empty()) {
      reader.Fault(key.c_str(), fmt::format("[bone.{}] is not used: the bone is {}; remove it", key,
                                            reader.Has("file") ? "a file" : fmt::format("model = \"{}\"", model)));
    }
  }
  reader.Finish();
}

/// Reads a text and adds a fault if `check` throws for it.
template <typename Check>
void ReadCheckedText(TableReader& reader, const char* key, std::string& value, Check check) {
  if (!reader.Has(key)) return;
  reader(key, value, kFileNameLimit, "");
  try {
    check(value);
  } catch (const Error& e) {
    reader.Fault(key, e.what());
  }
}

void ReadMaterial(TableReader& root, SceneMaterial& material, const SceneBone& bone, const std::string& scene_file,
                  Faults& faults) {
  const TomlNode* table = root.Table("material");
  if (table == nullptr) return;
  TableReader reader(*table, "[material]", faults);
  DescribeMaterialKind(material, reader);
  // The keys of every kind are read, so that faults in them are reported even if another kind is used.
  DescribeUniform(material, reader);
  DescribeCt(material, reader);
  if (reader.Has("osteon_direction")) {
    Vec3 direction(0, 0, 1);
    DescribeOsteons(direction, reader);
    if (!(glm::length(direction) > 1e-6)) reader.Fault("osteon_direction", "osteon_direction has length 0");
    material.osteon_direction = direction;
  }
  ReadFileName(reader, "ct_law_file", material.ct_law_file, scene_file);
  const bool built_in = !reader.Has("ct_law_file");
  ReadCheckedText(reader, "ct_law", material.ct_law, [built_in](const std::string& name) {
    if (built_in) FindCtLaw(DefaultCtLaws(), name);
  });
  ReadCheckedText(reader, "ct_calibration", material.ct_calibration, [](const std::string& points) {
    if (ParseCalibration(points).size() < 2) throw Error("a calibration has at least two points HU:density");
  });
  const std::string kind(kMaterialKindWords[static_cast<std::size_t>(material.kind)]);
  const auto refuse = [&](MaterialKind of, const std::vector<const char*>& keys) {
    if (material.kind == of) return;
    for (const char* key : keys) {
      if (!reader.Has(key)) continue;
      reader.Fault(key, fmt::format("{} is not used: kind = \"{}\"; remove it", key, kind));
    }
  };
  refuse(MaterialKind::kUniform, {"E_GPa", "nu"});
  refuse(MaterialKind::kCt, {"ct_law", "ct_law_file", "ct_calibration", "ct_applies_to"});
  if (material.kind == MaterialKind::kCt) {
    if (!reader.Has("ct_law")) {
      std::vector<std::string> names;
      for (const CtLaw& law : DefaultCtLaws()) names.push_back(law.name);
      reader.Fault("ct_law", fmt::format("[material] has no ct_law; kerf has {}, and none of them applies to all bone: "
                                         "'kerf materials' shows what each applies to",
                                         fmt::join(names, ", ")));
    }
    if (bone.source != BoneSource::kFile) {
      reader.Fault("kind",
                   fmt::format("kind = \"ct\" needs CT numbers, and a bone with model = \"{}\" has none; give a "
                               "file made with 'kerf import --keep-hu'",
                               ToString(bone.source)));
    }
  }
  reader.Finish();
}

/// Sets the values that a stroke takes from the previous one, and checks values that depend on both.
void LinkStroke(TableReader& reader, SceneStroke& stroke, const SceneStroke* before) {
  reader.Require("end_mm");
  reader.Require("feed_mm_per_s");
  if (stroke.retract) {
    reader.Require("start_mm");
    reader.Require("disc_normal");
  } else if (before == nullptr) {
    reader.Fault("retract", "retract = false in the first stroke; there is no previous stroke to continue");
  } else {
    const Vec3 n = stroke.disc_normal / glm::length(stroke.disc_normal);
    const Vec3 n_before = before->disc_normal / glm::length(before->disc_normal);
    if (reader.Has("start_mm") && !(glm::distance(stroke.start_mm, before->end_mm) <= kSamePointTolerance_mm)) {
      reader.Fault("start_mm",
                   "start_mm is not where the previous stroke ends, and retract = false; omit start_mm or retract");
    }
    if (reader.Has("disc_normal") && !(glm::distance(n, n_before) <= kSameDirectionTolerance)) {
      reader.Fault("disc_normal",
                   "disc_normal differs from the previous stroke's, and retract = false; omit disc_normal or retract");
    }
    stroke.start_mm = before->end_mm;
    stroke.disc_normal = before->disc_normal;
  }
  if (glm::length(stroke.disc_normal) < 1e-6)
    reader.Fault("disc_normal", "disc_normal has no direction: its length is 0");
  if (reader.Has("end_mm") && stroke.dwell_s == 0 &&
      glm::distance(stroke.start_mm, stroke.end_mm) < kSamePointTolerance_mm) {
    reader.Fault("end_mm", "the stroke ends where it starts and has no dwell_s; move end_mm or give dwell_s");
  }
}

void ReadPath(TableReader& root, ScenePath& path, const std::string& scene_file, Faults& faults) {
  root.Require("path");
  const TomlNode* table = root.Table("path");
  if (table == nullptr) return;
  TableReader reader(*table, "[path]", faults);
  ReadFileName(reader, "file", path.file, scene_file);
  const std::vector<const TomlNode*> strokes = reader.Tables("stroke", kMaxStrokes);
  if (reader.Has("file") && reader.Has("stroke")) {
    reader.Fault("file", "[path] has both file and stroke; keep one of them");
  } else if (const TomlNode* list = table->Find("stroke");
             !reader.Has("file") &&
             (list == nullptr || (list->kind == TomlNode::Kind::kArray && list->children.empty()))) {
    reader.Fault("stroke", "[path] has neither [[path.stroke]] nor file");
  }
  double duration_s = 0;
  for (const TomlNode* item : strokes) {
    TableReader stroke_reader(*item, "[[path.stroke]]", faults);
    SceneStroke stroke;
    Describe(stroke, stroke_reader);
    LinkStroke(stroke_reader, stroke, path.strokes.empty() ? nullptr : &path.strokes.back());
    stroke_reader.Finish();
    duration_s += glm::distance(stroke.start_mm, stroke.end_mm) / stroke.feed_mm_per_s + stroke.dwell_s;
    path.strokes.push_back(stroke);
  }
  if (duration_s > kMaxDuration_s) {
    reader.Fault("stroke", fmt::format("the strokes take {:.0f} s; at most {:.0f} s", duration_s, kMaxDuration_s));
  }
  reader.Finish();
}

template <typename Params>
void ReadSection(TableReader& root, const char* key, Params& params, Faults& faults) {
  const TomlNode* table = root.Table(key);
  if (table == nullptr) return;
  TableReader reader(*table, fmt::format("[{}]", key), faults);
  Describe(params, reader);
  reader.Finish();
}

void ReadTool(TableReader& root, SceneTool& tool, Faults& faults) {
  const TomlNode* table = root.Table("tool");
  if (table == nullptr) return;
  TableReader reader(*table, "[tool]", faults);
  Describe(tool, reader);
  const TomlNode* word = table->Find("shape");
  const std::string_view shape = GetShape(tool.shape);
  if (word != nullptr && word->text != shape) return;  // unknown shape
  // A key of another shape would have no effect, so it is rejected.
  std::set<std::string> refused;
  const auto refuse = [&](const char* key, const auto&...) {
    if (!reader.Has(key) || reader.Known(key) || !refused.insert(key).second) return;
    reader.Fault(key, fmt::format("{} is not used: shape is \"{}\"; remove it", key, shape));
  };
  for (Tool other : GetDefaultTools()) {
    std::visit([&](auto& of_other) { DescribeShape(of_other, refuse); }, other);
  }
  refuse("reverse");
  reader.Finish();
}

/// Reads a section that has no effect if it is left out.
template <typename Params>
void ReadGivenSection(TableReader& root, const char* key, Params& params, Faults& faults) {
  params.given = root.Has(key);
  ReadSection(root, key, params, faults);
}

void ReadDevice(TableReader& root, SceneDevice& device, const std::string& scene_file, Faults& faults) {
  const TomlNode* table = root.Table("device");
  if (table == nullptr) return;
  device.given = true;
  TableReader reader(*table, "[device]", faults);
  ReadFileName(reader, "file", device.file, scene_file);
  const bool built_in = !reader.Has("file");
  if (!built_in) {
    device.file_place = table->PlaceOf("file", scene_file);
  }
  ReadCheckedText(reader, "profile", device.profile, [built_in](const std::string& name) {
    if (built_in) FindDeviceProfile(name);
  });
  if (!built_in) reader.Require("profile");
  Describe(device, reader);
  reader.Finish();
}

void ReadSlab(TableReader& root, SceneSlab& slab, Faults& faults) {
  const TomlNode* table = root.Table("slab");
  if (table == nullptr) return;
  slab.given = true;
  TableReader reader(*table, "[slab]", faults);
  Describe(slab, reader);
  if (!(glm::length(slab.direction) > 1e-6)) {
    reader.Fault("direction", "direction has length 0");
  }
  if (slab.hold != SlabBody::kSlice && !slab.params.segments_move) {
    reader.Fault("hold", "hold specifies a segment, but segments_move is false; set segments_move = true");
  }
  reader.Finish();
}

void ReadEffects(TableReader& root, EffectChoices& effects, const std::string& scene_file, Faults& faults) {
  const TomlNode* table = root.Table("effects");
  if (table == nullptr) return;
  TableReader reader(*table, "[effects]", faults);
  for (const EffectInfo* info : Effects()) {
    const TomlNode* own = reader.Table(info->name);
    if (own == nullptr) continue;
    TableReader effect_reader(*own, fmt::format("[effects.{}]", info->name), faults);
    EffectChoice choice(info->name);
    Describe(choice, effect_reader);
    for (std::size_t i = 0; i < info->parameters.size(); ++i) {
      const EffectParameter& parameter = info->parameters[i];
      EffectValue& value = choice.values()[i];
      if (parameter.file != EffectFileKind::kNone) {
        ReadFileName(effect_reader, parameter.key, std::get<std::string>(value), scene_file);
      } else if (parameter.whole && std::get<double>(value) != std::round(std::get<double>(value))) {
        effect_reader.Fault(parameter.key,
                            fmt::format("{} = {} is not a whole number", parameter.key, std::get<double>(value)));
      }
    }
    effect_reader.Finish();
    const std::string fault = info->find_fault != nullptr ? info->find_fault(choice.values()) : "";
    if (!fault.empty()) reader.Fault(info->name, fmt::format("[effects.{}]: {}", info->name, fault));
    effects.push_back(choice);
    for (const char* needed : info->needs) {
      if (!reader.Has(needed)) {
        reader.Fault(info->name, fmt::format("[effects.{}] needs [effects.{}]: add it", info->name, needed));
      }
    }
  }
  reader.Finish();
}

/// Reads the files that the effects' parameters name. Throws kerf::Error with the place of the key.
void ReadEffectFiles(EffectChoices& effects, const TomlNode& document, const std::string& scene_file) {
  for (EffectChoice& choice : effects) {
    const std::vector<EffectParameter>& parameters = choice.info().parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].file == EffectFileKind::kNone) continue;
      EffectFile file;
      file.name = std::get<std::string>(choice.values()[i]);
      if (file.name.empty()) continue;
      const TomlNode* at = document.Find("effects")->Find(choice.name())->Find(parameters[i].key);
      file.place = fmt::format("{}:{}:{}: ", scene_file, at->line, at->column);
      try {
        if (parameters[i].file == EffectFileKind::kSurface) {
          file.mesh = ReadMesh(file.name);
          const std::size_t open = CountOpenEdges(file.mesh);
          if (open > 0) {
            throw Error(fmt::format("{}: the surface is not closed ({} open edge{}), so nothing is inside it",
                                    file.name, open, open == 1 ? "" : "s"));
          }
        } else {
          for (Markup& markup : ReadCurveMarkups(file.name)) {
            file.curves.push_back({std::move(markup.points), markup.joined});
          }
        }
      } catch (const Error& e) {
        throw Error(file.place + e.what());
      }
      choice.SetFile(parameters[i].key, std::move(file));
    }
  }
}

/// Rejects a key that older scenes had in another section.
void RefuseMovedKeys(TableReader& root) {
  const TomlNode* coupling = root.Has("coupling") ? root.Table("coupling") : nullptr;
  if (coupling == nullptr || coupling->Find("friction_coefficient") == nullptr) return;
  root.Fault("coupling", "friction_coefficient of [coupling] is now coefficient of [effects.kerf_friction]");
}

}  // namespace

Scene ParseScene(const std::string& text, const std::string& file) {
  if (text.size() > kMaxSceneBytes) {
    throw Error(fmt::format("{}: {} bytes; a scene has at most {}", file, text.size(), kMaxSceneBytes));
  }
  const TomlNode document = ParseToml(text, file);
  if (document.Find("bone") == nullptr && (document.Find("study") != nullptr || document.Find("knob") != nullptr)) {
    throw Error(fmt::format(
        "{0}: this is a study, not a scene; 'kerf study {0}' runs it, and with --dry-run only shows what it would do",
        file));
  }
  Faults faults(file);
  Scene scene;
  scene.name = std::filesystem::path(file).stem().string();

  TableReader root(document, "the scene", faults);
  root("title", scene.title, kTitleLimit, "");
  scene.title = Printable(scene.title);
  ReadBoneTable(root, scene.bone, file, faults);
  ReadMaterial(root, scene.material, scene.bone, file, faults);
  ReadTool(root, scene.tool, faults);
  ReadPath(root, scene.path, file, faults);
  const ForceTableFile force_file = ReadForce(root, scene.force, file, faults);
  ReadSection(root, "simulation", scene.simulation, faults);
  ReadSlab(root, scene.slab, faults);
  ReadSection(root, "output", scene.output, faults);
  ReadEffects(root, scene.effects, file, faults);
  RefuseCuttingRatios(document, scene.force, faults);
  const std::vector<PlanFile> plan_files = ReadPlan(root, scene.plan, file, faults);
  RefuseMovedKeys(root);
  ReadGivenSection(root, "coupling", scene.coupling, faults);
  ReadDevice(root, scene.device, file, faults);
  ReadGivenSection(root, "hand", scene.hand, faults);
  ReadGivenSection(root, "loop", scene.loop, faults);
  ReadExercise(root, scene.exercise, scene.tool, file, faults);
  if (!std::holds_alternative<DiscSaw>(scene.tool.shape) &&
      (scene.simulation.mode == SceneMode::kSlab || scene.slab.given)) {
    root.Fault(scene.slab.given ? "slab" : "simulation",
               fmt::format("slab mode requires a disc, but [tool] shape is \"{}\"", GetShape(scene.tool.shape)));
  }
  // Values that are in range, but do not fit together. The reader names a value out of range by its key.
  if (faults.empty()) {
    try {
      Validate(scene.tool.shape);
    } catch (const Error& e) {
      root.Fault("tool", e.what());
    }
  }
  root.Finish();
  faults.ThrowIfAny();

  ReadForceTableFile(force_file, scene.force);
  scene.force_file = force_file.file;
  ReadEffectFiles(scene.effects, document, file);
  ReadPlanFiles(plan_files, scene.plan);
  for (const PlanFile& plan_file : plan_files) scene.plan_files.push_back(plan_file.file);
  if (!scene.path.file.empty()) {
    const TomlNode* at = document.Find("path")->Find("file");
    std::string rows;
    try {
      rows = ReadTextFile(scene.path.file, kMaxPathFileBytes);
    } catch (const Error& e) {
      throw Error(fmt::format("{}:{}:{}: {}", file, at->line, at->column, e.what()));
    }
    scene.path.poses = ParsePathCsv(rows, scene.path.file);
  }
  return scene;
}

Scene ReadScene(const std::string& file) {
  return ParseScene(ReadTextFile(file, kMaxSceneBytes), file);
}

Tool MakeTool(const Scene& scene) {
  Tool tool = scene.tool.shape;
  std::visit([&](auto& t) { t.E_MPa = 1000 * scene.tool.E_GPa; }, tool);
  return tool;
}

DiscSaw MakeDiscSaw(const Scene& scene) {
  const Tool tool = MakeTool(scene);
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) return *disc;
  throw Error(fmt::format("{}: this requires a disc, but [tool] shape is \"{}\"", scene.name, GetShape(tool)));
}

SimulationParams MakeSimulationParams(const Scene& scene) {
  SimulationParams params;
  params.tool = MakeTool(scene);
  params.law = scene.force;
  params.rim_samples_per_pitch = scene.simulation.rim_samples_per_pitch;
  params.substeps = scene.simulation.substeps;
  params.carve_interval_ticks = scene.simulation.carve_interval_ticks;
  params.effects = scene.effects;
  return params;
}

CoupledParams MakeCoupledParams(const Scene& scene) {
  CoupledParams params{MakeSimulationParams(scene)};
  params.coupling = scene.coupling.params;
  params.coupling.p_TC_mm = scene.coupling.at == CouplingPoint::kGrip ? CalcGrip(params.tool) : Vec3{0};
  return params;
}

SlabParams MakeSlabParams(const Scene& scene) {
  SlabParams params = scene.slab.params;
  params.saw = MakeDiscSaw(scene);
  params.direction_W = glm::normalize(scene.slab.direction);
  return params;
}

/// Tolerances for a hand's path out of the slab's plane: mm, and the sine of 10 degrees.
constexpr double kSlabOff_mm = 2;
constexpr double kSlabTurn = 0.1737;

CutPlane MakeSlabPlane(const Scene& scene) {
  // Maximum sine of the angle between the direction and the plane. A direction with a larger angle was not meant to lie
  // in the plane.
  constexpr double kOutOfPlane = 0.02;
  const Pose X_WT = MakePath(scene).CalcPose(0, 0);
  CutPlane plane{X_WT.p_AB, X_WT.Vector({0, 0, 1})};
  const Vec3 d = glm::normalize(scene.slab.direction);
  const double out = glm::dot(d, plane.normal_W);
  if (!(std::abs(out) <= kOutOfPlane)) {
    if (!scene.slab.given) {
      throw Error("the scene has no [slab]; slab mode needs one with the direction in which the slice slides");
    }
    throw Error(fmt::format(
        "[slab] direction = [{:g}, {:g}, {:g}] lies {:.1f} degrees out of the disc's plane at the start of the path, "
        "whose normal is [{:.4g}, {:.4g}, {:.4g}]; the slice can only slide in that plane",
        scene.slab.direction.x, scene.slab.direction.y, scene.slab.direction.z,
        std::asin(std::min(1.0, std::abs(out))) * kDegreesPerRad, plane.normal_W.x, plane.normal_W.y,
        plane.normal_W.z));
  }
  plane.normal_W = glm::normalize(plane.normal_W - glm::dot(plane.normal_W, d) * d);

  // The rest of the path must cut the same slice.
  const auto check = [&](const std::string& what, const Vec3& p_W, const Vec3& normal_W) {
    const Vec3 from = p_W - plane.p_W;
    const double off_mm = std::abs(glm::dot(from, plane.normal_W));
    const double beside_mm = glm::length(from - glm::dot(from, d) * d);
    const double sine = glm::length(glm::cross(normal_W, plane.normal_W));
    if (off_mm > kSlabOff_mm || sine > kSlabTurn) {
      throw Error(
          fmt::format("at {} the disc is {:.1f} mm from the plane of the slab and rotated {:.1f} degrees out of it; "
                      "slab mode has one slice, in the disc's plane where the path starts",
                      what, off_mm, std::asin(std::min(1.0, sine)) * kDegreesPerRad));
    }
    if (beside_mm > CalcRadius(scene.tool.shape)) {
      throw Error(
          fmt::format("at {} the disc is {:.1f} mm beside the line along which the slice slides, more than its radius; "
                      "slab mode has one slice, in front of the disc where the path starts",
                      what, beside_mm));
    }
  };
  for (std::size_t i = 0; i < scene.path.strokes.size(); ++i) {
    const SceneStroke& stroke = scene.path.strokes[i];
    const Vec3 normal_W = glm::normalize(stroke.disc_normal);
    check(fmt::format("the start of stroke {}", i + 1), stroke.start_mm, normal_W);
    check(fmt::format("the end of stroke {}", i + 1), stroke.end_mm, normal_W);
  }
  for (std::size_t i = 0; i < scene.path.poses.size(); ++i) {
    const Pose& X = scene.path.poses[i].X_WT;
    check(fmt::format("pose {} of {}", i + 1, scene.path.file), X.p_AB, X.Vector({0, 0, 1}));
  }
  return plane;
}

}  // namespace kerf
