// kerf check: checks that a scene can run and predicts its behaviour.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "cut/force/measured.h"
#include "cut/tool/shape.h"
#include "cut/tool/words.h"
#include "kerf/error.h"
#include "session/run/check_scene.h"
#include "session/run/cutting_energy.h"
#include "session/run/run_slab_scene.h"
#include "session/scene/path.h"
#include "session/scene/saws.h"
#include "session/scene/scene.h"
#include "session/scene/schema.h"
#include "session/scene/warnings.h"

namespace kerf::cli {
namespace {

struct CheckArguments {
  std::string file;
  bool json = false;
};

/// Result of the force law for the scene's largest bite in cortical bone.
struct ToothAtTopBite {
  double bite_mm = 0;
  double thrust_N = 0;
  double cutting_N = 0;
  double J_per_mm3 = 0;
};

/// Returns the bone that goes in a pass of a tooth / width times bite of the tooth. A blade's kerf is wider than its
/// teeth by their set. If the stroke is shorter than the pitch, the bone between the strokes goes too.
double CalcBonePerPass(const Tool& tool) {
  if (!IsBlade(tool)) return 1;
  const Tooth tooth = CalcTooth(tool);
  const double stroke_mm = CalcStroke(tool);
  const double missed = stroke_mm > 0 ? std::max(1.0, tooth.pitch_mm / stroke_mm) : 1;
  return CalcCutWidth(tool) / tooth.width_mm * missed;
}

/// Returns nullopt if there is no such bite: a stopped spindle, or a path without motion.
std::optional<ToothAtTopBite> CalcToothAtTopBite(const Scene& scene) {
  ToothAtTopBite tooth{.bite_mm = CalcMaxBite(scene)};
  if (!std::isfinite(tooth.bite_mm) || !(tooth.bite_mm > 0)) return std::nullopt;
  const Tool tool = MakeTool(scene);
  const ToothForce law = MakeToothForce(scene.force, tool);
  ToothCut cut = MakeMeasuredBone(tool);
  cut.E_star_MPa = kMeasuredEStar_MPa;
  tooth.thrust_N = law(tooth.bite_mm, cut);
  tooth.cutting_N = CalcCuttingForce(law, tooth.bite_mm, cut);
  tooth.J_per_mm3 =
      CalcSpecificEnergy(tooth.cutting_N, CalcTooth(tool).width_mm, tooth.bite_mm) / CalcBonePerPass(tool);
  return tooth;
}

/// Returns the sources of a table's rows, each once.
std::vector<std::string> ListSources(const ForceTable& table) {
  std::vector<std::string> sources;
  for (const ForceLawRow& row : table.ListRows()) {
    if (std::ranges::find(sources, row.source) == sources.end()) sources.push_back(row.source);
  }
  return sources;
}

void Run(const CheckArguments& options) {
  const Scene scene = ReadScene(options.file);
  const Path path = MakePath(scene);
  const bool slab = scene.simulation.mode == SceneMode::kSlab;
  const CheckedScene checked = CheckWholeScene(scene);
  const std::optional<LoopSetup>& loop = checked.loop;
  for (const std::string& warning : checked.warnings) Say("{}: warning: {}", options.file, warning);

  const ForceLawInfo& law = scene.force.info();
  const double bite_um = 1000 * CalcMaxBite(scene);
  const std::size_t ticks = path.CountTicks(scene.simulation.rate_hz);
  if (options.json) {
    nlohmann::ordered_json json;
    json["file"] = options.file;
    json["title"] = scene.title;
    json["bone"] = {{"summary", checked.bone}, {"voxel_mm", checked.voxel_mm}};
    json["material"] = MaterialJson(scene, checked.material);
    Tool tool = scene.tool.shape;
    json["tool"]["shape"] = GetShape(tool);
    std::visit(
        [&](auto& shape) {
          DescribeShape(shape, [&](const char* key, auto value, Range, const char*) { json["tool"][key] = value; });
        },
        tool);
    json["tool"]["rpm"] = scene.tool.rpm;
    if (GetDrive(tool) == DriveMotion::kRotation) json["tool"]["reverse"] = scene.tool.reverse;
    json["path"] = {{"segments", path.segments().size()},
                    {"length_mm", path.length_mm()},
                    {"duration_s", path.duration_s()},
                    {"top_speed_mm_per_s", path.CalcMaxSpeed()}};
    json["mode"] = slab ? "slab" : "voxel";
    if (slab) json["slab"] = {{"law", ToString(scene.slab.params.reading)}};
    json["force"] = {{"law", law.name}, {"summary", law.summary}, {"source", law.source}};
    for (std::size_t i = 0; i < law.parameters.size(); ++i) {
      json["force"]["parameters"][law.parameters[i].key] = scene.force.values()[i];
    }
    const double to_mm = FindMaxValidBite(scene.force, MakeTool(scene));
    json["force"]["valid_bite_um"] = {1000 * FindMinValidBite(scene.force), std::isfinite(to_mm)
                                                                                ? nlohmann::ordered_json(1000 * to_mm)
                                                                                : nlohmann::ordered_json(nullptr)};
    json["force"]["accuracy"] = DescribeAccuracy(scene.force, MakeTool(scene));
    json["force"]["bites"] = DescribeBites(scene);
    json["force"]["blades"] = DescribeBlades(scene.force, MakeTool(scene));
    json["force"]["good_for"] = FindCaveat(law).good_for;
    json["force"]["measured_bite_um"] = {1000 * kMeasuredThrust.front().bite_mm, 1000 * kMeasuredThrust.back().bite_mm};
    json["force"]["from_measured_forces_J_per_mm3"] = kEnergyFromForces_J_per_mm3;
    json["force"]["widened_J_per_mm3"] = {kMinSpecificEnergy_J_per_mm3, kMaxSpecificEnergy_J_per_mm3};
    if (const std::optional<ToothAtTopBite> tooth = CalcToothAtTopBite(scene)) {
      json["force"]["at_top_bite"] = {{"thrust_N", tooth->thrust_N},
                                      {"cutting_N", tooth->cutting_N},
                                      {"specific_energy_J_per_mm3", tooth->J_per_mm3},
                                      {"E_star_MPa", kMeasuredEStar_MPa}};
    }
    json["force"]["top_bite_um"] = std::isfinite(bite_um) ? nlohmann::ordered_json(bite_um) : nullptr;
    json["simulation"] = {{"rate_hz", scene.simulation.rate_hz}, {"ticks", ticks}};
    if (loop) {
      json["loop"] = {{"device", loop->profile.name},
                      {"hand", loop->hand.name},
                      {"coupling_at", scene.coupling.at == CouplingPoint::kGrip ? "grip" : "tool"},
                      {"coupling_N_per_mm", loop->fitted.coupling.stiffness_N_per_mm},
                      {"device_N_per_N", loop->force_scale},
                      {"rate_hz", scene.loop.rate_hz},
                      {"degrade", scene.loop.degrade}};
    }
    json["warnings"] = checked.warnings;
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    return;
  }
  fmt::print("{}: valid{}{}\n", options.file, scene.title.empty() ? "" : ": ", scene.title);
  fmt::print("  bone   {}\n", checked.bone);
  fmt::print("  moduli {}\n", DescribeMaterial(scene, checked.material));
  fmt::print("  tool   {}\n", DescribeDrivenTool(scene.tool));
  const std::size_t parts = path.segments().size();
  fmt::print("  path   {} {}, {:.1f} mm in {:.2f} s, {} ticks at {} Hz\n", parts,
             scene.path.strokes.empty() ? "segment"
             : parts == 1               ? "stroke"
                                        : "strokes",
             path.length_mm(), path.duration_s(), ticks, scene.simulation.rate_hz);
  if (slab) {
    fmt::print("  force  slab mode, law {}, at up to {:.3g} mm/s\n", ToString(scene.slab.params.reading),
               path.CalcMaxSpeed());
    fmt::print("         {}\n", DescribeSlabLaw(scene));
    return;
  }
  fmt::print("  force  {}, at {:.3g} mm/s {}\n", law.name, path.CalcMaxSpeed(), DescribeBites(scene));
  fmt::print("         {}\n", law.summary);
  const bool own_values = scene.force.values() != ForceLaw(law.name).values();
  fmt::print("         from: {}\n",
             !scene.force.has_own_table()
                 ? fmt::format("{}{}", law.source, own_values ? "; the scene sets other values" : "")
                 : fmt::format("the scene's own table: {}", fmt::join(ListSources(*scene.force.table()), "; ")));
  fmt::print("         {}\n         {}\n         {}\n", DescribeAccuracy(scene.force, MakeTool(scene)),
             DescribeBlades(scene.force, MakeTool(scene)), FindCaveat(law).good_for);
  if (const std::optional<ToothAtTopBite> tooth = CalcToothAtTopBite(scene)) {
    const bool within =
        tooth->J_per_mm3 >= kMinSpecificEnergy_J_per_mm3 && tooth->J_per_mm3 <= kMaxSpecificEnergy_J_per_mm3;
    fmt::print(
        "         at that bite {:.3g} N of thrust and {:.3g} N of cutting force on {} in cortical bone, {:.3g} "
        "J/mm3; {} {:g} to {:g} J/mm3 ({})\n",
        tooth->thrust_N, tooth->cutting_N, DescribeTooth(scene.tool.shape), tooth->J_per_mm3,
        within ? "within" : "outside", kMinSpecificEnergy_J_per_mm3, kMaxSpecificEnergy_J_per_mm3,
        kSpecificEnergySource);
  }
  if (!loop) return;
  fmt::print("  hand   {} on {}, {:.3g} N on the device for 1 N in the simulation\n", loop->hand.name,
             loop->profile.name, loop->force_scale);
  fmt::print("         coupling at the {}: {}\n", scene.coupling.at == CouplingPoint::kGrip ? "grip" : "tool's centre",
             DescribeCoupling(*loop));
  fmt::print("  loop   {:g} Hz, {}\n", scene.loop.rate_hz,
             scene.loop.degrade ? "may reduce fidelity to save time" : "always at full fidelity");
}

}  // namespace

void AddCheckCommand(CLI::App& app) {
  const auto options = std::make_shared<CheckArguments>();
  CLI::App* command =
      app.add_subcommand("check", "Check a scene and the files that it names, and summarise what it will do");
  command->add_option("SCENE", options->file, "Scene file (TOML; see 'kerf scene --defaults')")->required();
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
