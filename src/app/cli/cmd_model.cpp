// kerf model: makes bones from parameters.
#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/files/files.h"
#include "base/files/peak_memory.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Common {
  std::string output;
  std::string materials;
  bool json = false;
};

MaterialTable ReadMaterials(const Common& common) {
  if (common.materials.empty()) return DefaultMandibleTable();
  return ParseRegionTable(ReadTextFile(common.materials), common.materials);
}

/// Writes the bone that `make` returns, and prints its properties.
void MakeAndWrite(const Common& common, const std::function<Bone(const std::function<void(double)>&)>& make) {
  if (std::filesystem::path(common.output).extension() != ".vdb") {
    throw CLI::ValidationError("-o", fmt::format("'{}' must end in .vdb", common.output));
  }
  CheckWritable(common.output);
  CheckInputsNotOverwritten({common.materials}, {common.output});
  const auto start = std::chrono::steady_clock::now();
  Bone bone;
  {
    ProgressBar bar("making");
    bone = make([&bar](double fraction) { bar.Show(0.95 * fraction); });
    WriteBone(bone, common.output);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double peak_MB = ReadPeakMemory_MB();
  const double volume_mm3 = bone.CalcVolume();
  const Box3 box = bone.CalcBounds();
  const std::uint64_t voxels = bone.CountActiveVoxels();
  const std::uint64_t bytes = bone.CalcMemoryBytes();
  if (!common.json) {
    fmt::print("volume     {:.3f} cm3\n", volume_mm3 / 1000);
    fmt::print("box        {:.1f} x {:.1f} x {:.1f} mm, from ({:.1f}, {:.1f}, {:.1f}) to ({:.1f}, {:.1f}, {:.1f})\n",
               box.size().x, box.size().y, box.size().z, box.lower.x, box.lower.y, box.lower.z, box.upper.x,
               box.upper.y, box.upper.z);
    fmt::print("voxels     {} of {} mm, {:.0f} MB; peak memory {:.0f} MB\n", voxels, bone.voxel_mm(),
               static_cast<double>(bytes) / 1e6, peak_MB);
    fmt::print("time       {:.1f} s\n", seconds);
    fmt::print("written    {}\n", common.output);
    return;
  }
  Json regions = Json::array();
  for (const auto& [id, mm3] : bone.CalcRegionVolumes()) {
    regions.push_back({{"id", id},
                       {"name", bone.materials().Contains(id) ? bone.materials().At(id).name : "none"},
                       {"volume_mm3", mm3}});
  }
  const Json json = {{"volume_mm3", volume_mm3},
                     {"bounds",
                      {{"lower_mm", {box.lower.x, box.lower.y, box.lower.z}},
                       {"upper_mm", {box.upper.x, box.upper.y, box.upper.z}},
                       {"size_mm", {box.size().x, box.size().y, box.size().z}}}},
                     {"voxel_mm", bone.voxel_mm()},
                     {"region_voxel_mm", bone.region_voxel_mm()},
                     {"active_voxels", voxels},
                     {"memory_bytes", bytes},
                     {"peak_memory_MB", peak_MB},
                     {"seconds", seconds},
                     {"hash", fmt::format("{:016x}", bone.CalcHash())},
                     {"regions", regions},
                     {"notes", bone.notes()},
                     {"output", common.output}};
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void AddCommon(CLI::App& c, Common& common) {
  c.add_option("-o,--output", common.output, "Bone file to write (.vdb)")->required();
  c.add_option("--materials", common.materials,
               "Region table (CSV) instead of the built-in one (volumes/mandible_regions.csv)");
  c.add_flag("--json", common.json, "Print as JSON");
}

/// Adds one option for each described parameter, such as "--ramus-height" for "ramus_height_mm".
struct OptionMaker {
  CLI::App& command;

  template <typename T>
  void operator()(const char* key, T& value, Range range, const char* meaning) const {
    std::string name(key);
    for (const std::string_view unit : {"_mm", "_deg"}) {
      if (name.ends_with(unit)) name.resize(name.size() - unit.size());
    }
    std::replace(name.begin(), name.end(), '_', '-');
    AddNumberOption(command, "--" + name, value, key, range, meaning)->capture_default_str();
  }
};

void AddMandible(CLI::App& model) {
  struct Options : Common {
    MandibleParams params;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* c =
      model.add_subcommand("mandible", "Make the generic mandible, in patient coordinates (docs/mandible.md)");
  AddCommon(*c, *o);
  Describe(o->params, OptionMaker{*c});
  c->callback([o] {
    const MaterialTable materials = ReadMaterials(*o);
    MakeAndWrite(*o, [&](const auto& progress) { return MakeMandible(o->params, materials, progress); });
  });
}

/// Returns the rotation by these angles, in degrees, about the world's x axis, then y, then z.
Quat MakeRotation(const std::vector<double>& degrees) {
  return glm::angleAxis(glm::radians(degrees[2]), Vec3{0, 0, 1}) *
         glm::angleAxis(glm::radians(degrees[1]), Vec3{0, 1, 0}) *
         glm::angleAxis(glm::radians(degrees[0]), Vec3{1, 0, 0});
}

void AddBlock(CLI::App& model, const char* name, const char* help, const BlockParams& defaults) {
  struct Options : Common {
    BlockParams params;
    std::string size, at, rotate;
    std::vector<std::string> layers;
  };
  const auto o = std::make_shared<Options>();
  o->params = defaults;
  CLI::App* c = model.add_subcommand(name, help);
  AddCommon(*c, *o);
  const Vec3& s = defaults.size_mm;
  c->add_option("--size", o->size,
                fmt::format("Length, width and height x,y,z, mm, each {}; default: {},{},{}",
                            ShowRange(FindRange<BlockParams>("size_x_mm"), ""), s.x, s.y, s.z));
  std::string usual;
  for (const MaterialLayer& layer : defaults.layers)
    usual += fmt::format(" --layer {}:{}", layer.thickness_mm, layer.region);
  c->add_option("--layer", o->layers,
                fmt::format("Layer as thickness:region, mm and a region of the table, from the top down; may be "
                            "repeated; the last one fills the rest; default:{}",
                            usual.empty() ? " region 24 throughout" : usual))
      ->allow_extra_args(false);
  c->add_option("--at", o->at, "Position of the middle of the top face, x,y,z, mm; default: 0,0,0");
  c->add_option("--rotate", o->rotate,
                "Rotation about the middle of the top face by x,y,z degrees: about the x axis, then the y axis, then "
                "the z axis of the world; default: 0,0,0");
  AddNumber(*c, "--voxel", o->params, "voxel_mm")->capture_default_str();
  c->callback([o] {
    BlockParams params = o->params;
    if (!o->size.empty()) {
      const auto v = ParseNumbers(o->size, ',', 3, "--size", "x,y,z in mm, such as 40,20,20");
      params.size_mm = {v[0], v[1], v[2]};
    }
    if (!o->at.empty()) {
      const auto v = ParseNumbers(o->at, ',', 3, "--at", "x,y,z in mm, such as 0,0,10");
      params.X_WB.p_AB = {v[0], v[1], v[2]};
    }
    if (!o->rotate.empty()) {
      params.X_WB.R_AB = MakeRotation(ParseNumbers(o->rotate, ',', 3, "--rotate", "x,y,z in degrees, such as 0,30,45"));
    }
    if (!o->layers.empty()) params.layers.clear();
    for (const std::string& text : o->layers) {
      const auto v = ParseNumbers(text, ':', 2, "--layer", "thickness:region, such as 2.2:24");
      if (v[1] != std::floor(v[1]) || !kRegionRange.Contains(v[1])) {
        throw CLI::ValidationError(
            "--layer", fmt::format("'{}' does not specify a region; a region must be a whole number from {}", text,
                                   ShowRange(kRegionRange, "")));
      }
      params.layers.push_back({v[0], static_cast<int>(v[1])});
    }
    const MaterialTable materials = ReadMaterials(*o);
    MakeAndWrite(*o, [&](const auto&) { return MakeBlock(params, materials); });
  });
}

}  // namespace

void AddModelCommand(CLI::App& app) {
  CLI::App* c = app.add_subcommand("model", "Make a bone from parameters: the generic mandible, a block or a plate");
  c->require_subcommand(1);
  AddMandible(*c);
  AddBlock(*c, "block", "Make a block with layers of material, for experiments with a known answer", BlockParams{});
  AddBlock(*c, "plate", "Make a flat plate like the mandible's body: cortical, cancellous and cortical bone",
           MakePlateParams());
}

}  // namespace kerf::cli
