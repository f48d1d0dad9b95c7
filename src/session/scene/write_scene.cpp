#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/core/printable.h"
#include "session/scene/plan_section.h"
#include "session/scene/scene.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

/// Returns the shortest text that reads back as the same number, always with a point or an exponent.
std::string Real(double x) {
  std::string text = fmt::format("{}", x);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04X}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

/// Visitor for Describe() that writes `key = value  # meaning; range`.
class TomlWriter {
 public:
  void operator()(const char* key, double& value, Range range, const char* meaning) {
    Line(key, Real(value), fmt::format("{} [{}]", meaning, ShowRange(range, UnitOfKey(key))));
  }
  void operator()(const char* key, int& value, Range range, const char* meaning) {
    Line(key, fmt::format("{}", value), fmt::format("{} [{}]", meaning, ShowRange(range, UnitOfKey(key))));
  }
  void operator()(const char* key, bool& value, const char* meaning) { Line(key, value ? "true" : "false", meaning); }
  void operator()(const char* key, Vec3& v, Range range, const char* meaning) {
    Line(key, fmt::format("[{}, {}, {}]", Real(v.x), Real(v.y), Real(v.z)),
         fmt::format("{} [{}]", meaning, ShowRange(range, UnitOfKey(key))));
  }
  void operator()(const char* key, Quat& q, const char* meaning) {
    Line(key, fmt::format("[{}, {}, {}, {}]", Real(q.w), Real(q.x), Real(q.y), Real(q.z)), meaning);
  }
  void operator()(const char* key, std::string& value, const Choices& choices, const char* meaning) {
    Line(key, Quoted(value), fmt::format("{} [\"{}\"]", meaning, fmt::join(choices.words, "\" or \"")));
  }
  void operator()(const char* key, std::string& value, TextLimit, const char* meaning) {
    Line(key, Quoted(value), meaning);
  }

  void Header(const std::string& header, const std::string& comment) {
    if (!text_.empty()) text_ += '\n';
    if (!comment.empty()) text_ += fmt::format("# {}\n", comment);
    text_ += header + "\n";
  }
  void Comment(const std::string& comment) { text_ += fmt::format("# {}\n", comment); }
  /// Disables comments from here on, for repeated tables of the same kind.
  void SetTerse(bool terse) { terse_ = terse; }
  const std::string& text() const { return text_; }

 private:
  void Line(const char* key, const std::string& value, const std::string& comment) {
    const std::string assignment = fmt::format("{} = {}", key, value);
    text_ += terse_ ? assignment + "\n" : fmt::format("{:<34}  # {}\n", assignment, comment);
  }

  std::string text_;
  bool terse_ = false;
};

void WriteBlock(TomlWriter& write, const std::string& key, BlockParams block) {
  write.Header(fmt::format("[bone.{}]", key), "A box with layers of material, the first at the top.");
  Describe(block, write);
  for (std::size_t i = 0; i < block.layers.size(); ++i) {
    write.SetTerse(i > 0);
    write.Header(fmt::format("[[bone.{}.layer]]", key), "");
    Describe(block.layers[i], write);
  }
  write.SetTerse(false);
}

void WriteMandible(TomlWriter& write, MandibleParams mandible) {
  write.Header("[bone.mandible]", "The generic mandible; docs/mandible.md explains each dimension.");
  Describe(mandible, write);
}

void WriteBone(TomlWriter& write, SceneBone bone) {
  write.Header("[bone]", "");
  if (bone.source == BoneSource::kFile) {
    write("file", bone.file, TextLimit{0}, "a bone file written by kerf (.vdb)");
  } else {
    std::string model(ToString(bone.source));
    write("model", model, Choices{BoneModelWords()}, "a bone made from parameters, instead of file = \"bone.vdb\"");
  }
  if (bone.materials.empty()) {
    write.Comment("materials = \"table.csv\": a table of regions to use instead of the bone's own");
  } else {
    write("materials", bone.materials, TextLimit{0}, "table of regions, instead of the bone's own");
  }
  if (bone.source == BoneSource::kMandible) WriteMandible(write, bone.mandible);
  if (bone.source == BoneSource::kBlock || bone.source == BoneSource::kPlate) {
    WriteBlock(write, std::string(ToString(bone.source)), bone.block);
  }
}

void WriteMaterial(TomlWriter& write, SceneMaterial material) {
  write.Header("[material]", "Source of the bone's stiffness: docs/materials.md.");
  DescribeMaterialKind(material, write);
  if (material.osteon_direction) {
    DescribeOsteons(*material.osteon_direction, write);
  } else {
    write.Comment("osteon_direction = [1, 0, 0]: direction of the osteons, world frame, for laws that depend on it");
  }
  if (material.kind == MaterialKind::kUniform) DescribeUniform(material, write);
  if (material.kind != MaterialKind::kCt) return;
  write("ct_law", material.ct_law, TextLimit{0}, "law from CT number to E, by name; 'kerf materials' lists them");
  if (material.ct_law_file.empty()) {
    write.Comment("ct_law_file = \"laws.csv\": a table of laws to use instead of the built-in ones");
  } else {
    write("ct_law_file", material.ct_law_file, TextLimit{0}, "table of laws, instead of the built-in ones");
  }
  if (material.ct_calibration.empty()) {
    write.Comment("ct_calibration = \"0:0.1 1000:1.2\": HU:g/cm3 points of the scanner, instead of the law's own");
  } else {
    write("ct_calibration", material.ct_calibration, TextLimit{0}, "HU:g/cm3 points, instead of the law's own");
  }
  DescribeCt(material, write);
}

void WritePath(TomlWriter& write, ScenePath path) {
  if (!path.file.empty()) {
    write.Header("[path]", "Poses of the tool in the world, each row time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz.");
    write("file", path.file, TextLimit{0}, "CSV, instead of strokes");
    return;
  }
  for (std::size_t i = 0; i < path.strokes.size(); ++i) {
    write.SetTerse(i > 0);
    write.Header("[[path.stroke]]", i > 0 ? "" : "Straight strokes of the tool's origin, one after the other.");
    Describe(path.strokes[i], write);
  }
  write.SetTerse(false);
}

template <typename Params>
void WriteSection(TomlWriter& write, const std::string& key, Params params) {
  write.Header(fmt::format("[{}]", key), "");
  Describe(params, write);
}

/// Writes the force law's own table, so that the scene is complete without the table's file.
void WriteForceRows(TomlWriter& write, const ForceLaw& law) {
  if (!law.has_own_table()) return;
  write.SetTerse(true);
  for (ForceLawRow& row : law.table()->ListRows()) {
    row.source = Printable(row.source);
    write.Header("[[force.row]]", "");
    Describe(row, write);
  }
  write.SetTerse(false);
}

/// Omits the keys that have no use with the law.
void WriteEffect(TomlWriter& write, EffectChoice effect, const ForceLaw& law) {
  const EffectInfo& info = effect.info();
  write.Header(fmt::format("[effects.{}]", info.name), info.summary);
  Describe(effect, [&](const char* key, auto&&... rest) {
    const std::pair<std::string_view, std::string_view> name{info.name, key};
    if (law.info().has_cutting && std::ranges::find(kCuttingRatioKeys, name) != kCuttingRatioKeys.end()) return;
    write(key, rest...);
  });
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const EffectParameter& parameter = info.parameters[i];
    if (parameter.file == EffectFileKind::kNone) continue;
    auto& name = std::get<std::string>(effect.values()[i]);
    if (name.empty()) {
      write.Comment(fmt::format("{} = \"FILE\": {}", parameter.key, parameter.meaning));
    } else {
      write(parameter.key, name, TextLimit{0}, parameter.meaning);
    }
  }
}

void WriteDevice(TomlWriter& write, SceneDevice device) {
  write.Header("[device]", "The haptic device for 'kerf loop': its properties (docs/devices.md).");
  write("profile", device.profile, TextLimit{0}, "name of the device in the table of profiles");
  if (device.file.empty()) {
    write.Comment("file = \"profiles.csv\": a table of profiles to use instead of the built-in one");
  } else {
    write("file", device.file, TextLimit{0}, "table of profiles, instead of the built-in one");
  }
  Describe(device, write);
}

void WritePlan(TomlWriter& write, Plan plan) {
  for (std::size_t i = 0; i < plan.planes.size(); ++i) {
    write.SetTerse(i > 0);
    write.Header("[[plan.plane]]", i > 0 ? "" : "The planned cuts (docs/planning.md).");
    Describe(plan.planes[i], write);
  }
  for (std::size_t i = 0; i < plan.stops.size(); ++i) {
    write.SetTerse(i > 0);
    write.Header("[[plan.stop]]", i > 0 ? "" : "The planned depths.");
    Describe(plan.stops[i], write);
  }
  write.SetTerse(false);
}

void WriteExercise(TomlWriter& write, const SceneExercise& exercise) {
  const auto describe = [&](auto described) {
    Describe(described, [&](const char* key, auto& value, const auto&... more) {
      const bool hole = exercise.kind == ExerciseKind::kDrillHoles;
      if (!hole || std::string_view(key) != "end_mm") write(key, value, more...);
    });
  };
  write.Header("[exercise]", "");
  describe(exercise);
  write.SetTerse(true);
  for (const SceneCut& cut : exercise.further) {
    write.Header("[[exercise.cut]]", "");
    describe(cut);
  }
  write.SetTerse(false);
}

std::string WriteScene(const Scene& scene, const std::string& heading) {
  TomlWriter write;
  write.Comment(heading);
  write.Comment("Lengths in mm, world frame: for a CT the patient's, x to the left, y to the back, z to the head.");
  std::string title = scene.title;
  write("title", title, TextLimit{0}, "title, one line");
  WriteBone(write, scene.bone);
  WriteMaterial(write, scene.material);
  WriteSection(write, "tool", scene.tool);
  WritePath(write, scene.path);
  WriteSection(write, "force", scene.force);
  WriteForceRows(write, scene.force);
  WriteSection(write, "simulation", scene.simulation);
  if (scene.slab.given || scene.simulation.mode == SceneMode::kSlab) WriteSection(write, "slab", scene.slab);
  WriteSection(write, "output", scene.output);
  for (const EffectChoice& effect : scene.effects) WriteEffect(write, effect, scene.force);
  WritePlan(write, scene.plan);
  if (scene.coupling.given) WriteSection(write, "coupling", scene.coupling);
  if (scene.device.given) WriteDevice(write, scene.device);
  if (scene.hand.given) WriteSection(write, "hand", scene.hand);
  if (scene.loop.given) WriteSection(write, "loop", scene.loop);
  if (scene.exercise.given) WriteExercise(write, scene.exercise);
  return write.text();
}

/// Turns lines into comments.
std::string CommentedOut(const std::string& text) {
  std::string commented;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    commented += (end > begin ? "# " : "#") + text.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  return commented;
}

/// Returns the main example, which equals scenes/body_osteotomy.toml.
Scene DefaultScene() {
  Scene scene;
  scene.title = "Osteotomy of the left body, generic mandible";
  scene.bone.source = BoneSource::kMandible;
  scene.bone.mandible.voxel_mm = 0.125;
  SceneStroke stroke;
  stroke.start_mm = {25.2, 32.3, 12};
  stroke.end_mm = {25.2, 32.3, -29};
  stroke.disc_normal = {0.438, 0.899, 0};
  scene.path.strokes = {stroke};
  scene.slab.given = true;
  scene.slab.direction = {0, 0, -1};
  scene.coupling.given = scene.device.given = scene.hand.given = scene.loop.given = true;
  return scene;
}

}  // namespace

std::string ResolvedToml(const Scene& scene) {
  return WriteScene(scene, "A kerf scene with all its values. Run it with: kerf run FILE -o FOLDER");
}

std::string DefaultSceneToml() {
  std::string text = WriteScene(DefaultScene(), "A kerf scene with all its keys. Run it with: kerf run FILE -o FOLDER");

  TomlWriter file;
  SceneBone from_file;
  from_file.source = BoneSource::kFile;
  from_file.file = "bone.vdb";
  from_file.materials = "table.csv";
  WriteBone(file, from_file);
  TomlWriter block;
  SceneBone from_block;
  from_block.source = BoneSource::kBlock;
  from_block.block.layers = {{2, 24}, {18, 32}};
  WriteBone(block, from_block);
  TomlWriter plate;
  SceneBone from_plate;
  from_plate.source = BoneSource::kPlate;
  from_plate.block = MakePlateParams();
  WriteBone(plate, from_plate);
  TomlWriter uniform;
  SceneMaterial same_everywhere;
  same_everywhere.kind = MaterialKind::kUniform;
  WriteMaterial(uniform, same_everywhere);
  TomlWriter ct;
  SceneMaterial from_ct;
  from_ct.kind = MaterialKind::kCt;
  from_ct.ct_law = "mandible_matmap";
  from_ct.ct_law_file = "laws.csv";
  from_ct.ct_calibration = "0:0.1 1000:1.2";
  WriteMaterial(ct, from_ct);
  TomlWriter tools;
  for (const Tool& tool : GetDefaultTools()) {
    SceneTool other;
    if (tool.index() == other.shape.index()) continue;
    other.shape = tool;
    other.rpm = CalcOrdinaryRate(tool);
    WriteSection(tools, "tool", other);
  }
  TomlWriter poses;
  ScenePath from_csv;
  from_csv.file = "path.csv";
  WritePath(poses, from_csv);
  text += "\n# Alternatives to the [bone] above (file names are relative to the scene file):\n#\n";
  text += CommentedOut(file.text() + "\n" + block.text() + "\n" + plate.text());
  text += "\n# Alternatives to the [material] above:\n#\n";
  text += CommentedOut(uniform.text() + "\n" + ct.text());
  text += "\n# Alternatives to the [tool] above (without [slab], which is for a disc):\n#\n";
  text += CommentedOut(tools.text());
  text += "\n# Alternatives to the strokes above:\n#\n";
  text += CommentedOut(poses.text());
  TomlWriter laws;
  for (const ForceLawInfo* law : ForceLaws()) {
    laws.Header("[force]", fmt::format("{}: {}", law->name, law->summary));
    ForceLaw described(law->name);
    Describe(described, laws);
    if (law->has_table)
      laws.Comment("file = \"table.csv\": a table of forces instead of the built-in one; or its rows as [[force.row]]");
  }
  TomlWriter effects;
  const ForceLaw without_cutting("hertz_chip");  // with it, all keys of the effects have a use
  for (const EffectInfo* info : Effects()) WriteEffect(effects, EffectChoice(info->name), without_cutting);
  TomlWriter plan;
  WritePlan(plan, {.planes = {{.name = "plane 1", .plane = {{25.2, 32.3, -9}, {0.438, 0.899, 0}}, .margin_mm = 1}},
                   .stops = {{.name = "stop 1", .p_W_mm = {25.2, 32.3, 5}, .direction_W = {0, 0, -1}, .depth_mm = 8}}});
  text += "\n# A plan; a plane may have file = \"plane.mrk.json\" of 3D Slicer instead of point_mm and normal:\n#\n";
  text += CommentedOut(plan.text());
  TomlWriter exercise;
  WriteSection(exercise, "exercise", SceneExercise{});
  text +=
      "\n# The section that makes a scene an exercise ('kerf practise', docs/practise.md); further cuts or holes are\n"
      "# [[exercise.cut]], with start_mm, end_mm, into and depth_mm:\n#\n";
  text += CommentedOut(exercise.text());
  text += "\n# The effects: a scene simulates those that it names, and no others ('kerf effects'):\n#\n";
  text += CommentedOut(effects.text());
  text += "\n# The force laws, each with its own keys:\n#\n";
  text += CommentedOut(laws.text());
  return text;
}

}  // namespace kerf
