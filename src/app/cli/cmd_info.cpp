#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/cli/commands.h"
#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "bone/grid/ct_modulus.h"
#include "bone/vdb/bonefile.h"
#include "kerf/surface.h"

namespace kerf::cli {
namespace {

using nlohmann::ordered_json;

struct InfoArguments {
  std::string bone;
  bool json = false;
};

void PrintJson(const Bone& bone, const Pieces& split) {
  const Box3 box = bone.CalcBounds();
  ordered_json json;
  json["frame"] = "LPS";
  json["units"] = "mm";
  json["volume_mm3"] = bone.CalcVolume();
  json["bounds"] = {{"lower_mm", {box.lower.x, box.lower.y, box.lower.z}},
                    {"upper_mm", {box.upper.x, box.upper.y, box.upper.z}},
                    {"size_mm", {box.size().x, box.size().y, box.size().z}}};
  json["pieces"] = ordered_json::array();
  for (const Bone& piece : split.pieces) json["pieces"].push_back({{"volume_mm3", piece.CalcVolume()}});
  json["crumbs"] = {{"count", split.dust_count}, {"volume_mm3", split.dust_mm3}, {"below_mm3", kSmallestPiece_mm3}};
  json["voxel_mm"] = bone.voxel_mm();
  json["band_mm"] = bone.band_mm();
  json["active_voxels"] = bone.CountActiveVoxels();
  json["region_voxel_mm"] = bone.region_voxel_mm();
  json["hu"] = nullptr;
  if (bone.has_hu()) {
    const HuRange hu = CalcHuRange(bone);
    json["hu"] = {{"voxel_mm", bone.hu_voxel_mm()}, {"min_HU", hu.min}, {"mean_HU", hu.mean}, {"max_HU", hu.max}};
  }
  json["memory_bytes"] = bone.CalcMemoryBytes();
  json["hash"] = fmt::format("{:016x}", bone.CalcHash());
  json["regions"] = ordered_json::array();
  const std::map<int, double> volumes = bone.CalcRegionVolumes();
  for (const auto& [id, region] : bone.materials().regions()) {
    const auto volume = volumes.find(id);
    json["regions"].push_back({{"id", id},
                               {"name", region.name},
                               {"tissue", ToString(region.tissue)},
                               {"E_GPa", region.E_MPa / 1000},
                               {"nu", region.nu},
                               {"estimate", region.estimate},
                               {"source", region.source},
                               {"volume_mm3", volume == volumes.end() ? 0.0 : volume->second}});
    if (region.has_interval()) {
      json["regions"].back()["E_interval_GPa"] = {region.E_lower_MPa / 1000, region.E_upper_MPa / 1000};
    }
  }
  json["notes"] = bone.notes();
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void PrintText(const std::string& file, const Bone& bone, const Pieces& split) {
  const Box3 box = bone.CalcBounds();
  fmt::print("{}\n", file);
  fmt::print("  volume    {} in {} piece{}", FormatVolume(bone.CalcVolume()), split.pieces.size(),
             split.pieces.size() == 1 ? "" : "s");
  if (split.dust_count > 0) {
    fmt::print("; {} crumb{} below {:g} mm3 not counted", split.dust_count, split.dust_count == 1 ? "" : "s",
               kSmallestPiece_mm3);
  }
  fmt::print("\n");
  fmt::print("  box       {:.1f} x {:.1f} x {:.1f} mm, from ({:.1f}, {:.1f}, {:.1f}) to ({:.1f}, {:.1f}, {:.1f})\n",
             box.size().x, box.size().y, box.size().z, box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y,
             box.upper.z);
  fmt::print("  frame     LPS, mm: x to the patient's left, y to the back, z to the head\n");
  fmt::print("  voxels    {:g} mm, {} in a band of {:g} mm about the surface; regions {:g} mm\n", bone.voxel_mm(),
             bone.CountActiveVoxels(), bone.band_mm(), bone.region_voxel_mm());
  if (bone.has_hu()) {
    const HuRange hu = CalcHuRange(bone);
    fmt::print("  CT        {:.0f} to {:.0f} HU in the bone, mean {:.0f}, on voxels of {:g} mm\n", hu.min, hu.max,
               hu.mean, bone.hu_voxel_mm());
  }
  fmt::print("  memory    {:.1f} MB\n", static_cast<double>(bone.CalcMemoryBytes()) / 1e6);
  fmt::print("  hash      {:016x}\n", bone.CalcHash());
  for (const auto& [key, value] : bone.notes()) fmt::print("  {:<9} {}\n", key, Printable(value));
  fmt::print("\n  {:>3}  {:<34} {:<11} {:>8} {:>5} {:>10}  {:<4} {}\n", "id", "region", "tissue", "E (GPa)", "nu",
             "mm3", "est.", "source");
  const std::map<int, double> volumes = bone.CalcRegionVolumes();
  for (const auto& [id, mm3] : volumes) {
    if (!bone.materials().Contains(id)) {
      if (mm3 < 0.05) continue;  // only slivers in the outermost cells
      fmt::print("  {:>3}  {:<34} {:<11} {:>8} {:>5} {:>10.1f}\n", id, "(no material)", "", "", "", mm3);
      continue;
    }
    const Region& r = bone.materials().At(id);
    fmt::print("  {:>3}  {:<34} {:<11} {:>8.4g} {:>5.2f} {:>10.1f}  {:<4} {}\n", id, r.name, ToString(r.tissue),
               r.E_MPa / 1000, r.nu, mm3, r.estimate ? "yes" : "no", r.source);
  }
}

void Run(const InfoArguments& options) {
  const Bone bone = ReadBone(options.bone, {.hu = true});
  const Pieces split = SplitPieces(bone);
  if (options.json) {
    PrintJson(bone, split);
  } else {
    PrintText(options.bone, bone, split);
  }
}

}  // namespace

void AddInfoCommand(CLI::App& app) {
  const auto options = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand("info", "Show the contents of a bone file: size, frame, regions, provenance");
  command->add_option("BONE", options->bone, "Bone file (.vdb)")->required();
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
