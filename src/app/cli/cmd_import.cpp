// kerf import: makes a bone from a CT or a surface.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/ct_options.h"
#include "app/cli/mask_options.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/core/number_text.h"
#include "base/files/files.h"
#include "base/files/markups.h"
#include "base/files/peak_memory.h"
#include "bone/import/dicom_input.h"
#include "bone/import/image_header.h"
#include "bone/import/import.h"
#include "bone/material/region_table.h"
#include "bone/segmentation/mask_file.h"
#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

struct ImportArguments {
  std::string input;
  std::string output;
  bool list = false;
  bool json = false;
  bool no_isolate = false;
  bool any_shape = false;
  bool no_fill = false;
  bool teeth_asked = false;  // requested by a tooth option
  std::vector<std::string> keep, drop, keep_markups, drop_markups;
  std::string materials;
  MaskArguments mask;
  ImportOptions import;
  // Of the mask.
  std::vector<Segment> segments;
  std::vector<SegmentMeaning> meanings;
};

Json ToJson(const Vec3& v) {
  return {v.x, v.y, v.z};
}

void List(const ImportArguments& options) {
  std::error_code failed;
  if (std::filesystem::exists(options.input, failed) && !DicomInput::Is(options.input)) {
    throw Error(fmt::format("{}: --list requires DICOM: a folder, one of its files, or a .zip", options.input));
  }
  const DicomInput input(options.input);
  Json list = Json::array();
  for (const DicomSeries& s : input.series()) {
    const DicomSlice& first = s.slices.front();
    const double gap_mm = s.stated_gap_mm();
    list.push_back({{"uid", s.name()},
                    {"description", s.description},
                    {"part", s.part_name},
                    {"modality", s.modality},
                    {"columns", first.size[0]},
                    {"rows", first.size[1]},
                    {"slices", s.slices.size()},
                    {"spacing_mm", {first.pixel_mm[0], first.pixel_mm[1], gap_mm}},
                    {"thickness_mm", first.thickness_mm},
                    {"kernel", first.kernel},
                    {"transfer_syntax", first.transfer_syntax},
                    {"left_out", s.warnings}});
    if (options.json) continue;
    fmt::print("{}\n  {}, {} x {} x {} voxels of {:.4g} x {:.4g} x {} mm", s.name(),
               s.modality.empty() ? "no modality" : s.modality, first.size[0], first.size[1], s.slices.size(),
               first.pixel_mm[0], first.pixel_mm[1], gap_mm > 0 ? fmt::format("{:.4g}", gap_mm) : "?");
    if (gap_mm > 0 && !first.spacing_from.empty()) fmt::print(" (by {})", first.spacing_from);
    if (first.thickness_mm > 0) fmt::print(", slices {:.4g} mm thick", first.thickness_mm);
    if (!first.kernel.empty()) fmt::print(", kernel {}", first.kernel);
    for (const std::string& text : {s.part_name, s.description}) {
      if (!text.empty()) fmt::print(", {}", text);
    }
    fmt::print("\n");
    for (const std::string& warning : s.warnings) fmt::print("  {}\n", warning);
  }
  if (options.json)
    fmt::print("{}\n", Json{{"series", list}}.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

/// Returns the surface's error as JSON; null if it is unknown.
Json ErrorJson(const SurfaceError& e) {
  if (e.points == 0) return nullptr;
  return {{"expected_mm", e.CalcExpected()},    {"offset_mm", e.offset_mm},
          {"scatter_mm", e.scatter_mm},         {"blur_mm", e.blur_mm},
          {"half_height_HU", e.half_height_hu}, {"points", e.points}};
}

/// Returns the properties of the kept CT numbers as JSON; null if none were kept.
Json HuJson(const ImportReport& r) {
  if (r.hu_voxel_mm == 0) return nullptr;
  return {{"voxel_mm", r.hu_voxel_mm}, {"min_HU", r.hu.min}, {"mean_HU", r.hu.mean}, {"max_HU", r.hu.max}};
}

/// Returns the properties of the input surface as JSON; null if the input was a CT.
Json SurfaceJson(const ImportReport& r) {
  if (r.kind != "surface") return nullptr;
  return {{"triangles", r.surface.triangles},
          {"shells", r.surface.shells},
          {"hollow_shells", r.surface.hollow_shells},
          {"hollow_mm3", r.surface.hollow_mm3},
          {"inner_solid_shells", r.surface.inner_solid_shells},
          {"repairs", r.surface.repairs}};
}

const char* ToString(JawSide side) {
  return side == JawSide::kLeft ? "left" : side == JawSide::kRight ? "right" : "unknown";
}

const char* ToString(JawPart jaw) {
  return jaw == JawPart::kLower ? "lower" : jaw == JawPart::kUpper ? "upper" : "unknown";
}

/// Returns what a segment is taken for, such as "tooth 36" or "canal, left".
std::string Describe(const SegmentMeaning& meaning) {
  std::string text = kerf::ToString(meaning.role);
  if (meaning.role == SegmentRole::kOtherBone) text += " bone";
  if (meaning.fdi != 0) text += fmt::format(" {}", meaning.fdi);
  if (meaning.role == SegmentRole::kTooth && meaning.fdi == 0) text += fmt::format(", {} jaw", ToString(meaning.jaw));
  if (meaning.role == SegmentRole::kCanal && meaning.side != JawSide::kUnknown) {
    text += fmt::format(", {}", ToString(meaning.side));
  }
  return text;
}

/// Returns the mask and how it was used as JSON; null without a mask.
Json MaskJson(const ImportArguments& options, const MaskReport& mask) {
  if (!mask.used) return nullptr;
  Json segments = Json::array();
  for (std::size_t n = 0; n < options.segments.size(); ++n) {
    const Segment& segment = options.segments[n];
    const SegmentMeaning& meaning = options.meanings[n];
    Json json = {
        {"name", segment.name},     {"label", segment.label},           {"layer", segment.layer},
        {"voxels", segment.voxels}, {"volume_mm3", segment.volume_mm3}, {"role", kerf::ToString(meaning.role)}};
    if (meaning.role == SegmentRole::kTooth) {
      json["jaw"] = ToString(meaning.jaw);
      if (meaning.fdi != 0) json["fdi"] = meaning.fdi;
    }
    if (meaning.role == SegmentRole::kCanal) json["side"] = ToString(meaning.side);
    segments.push_back(std::move(json));
  }
  return {
      {"file", options.mask.file},           {"reach_mm", mask.reach_mm},       {"wanted_mm3", mask.wanted_mm3},
      {"added_mm3", mask.added_mm3},         {"cut_off_mm3", mask.cut_off_mm3}, {"given_away_mm3", mask.given_away_mm3},
      {"given_away_mm", mask.given_away_mm}, {"beyond_mm3", mask.beyond_mm3},   {"segments", segments}};
}

void PrintJson(const ImportArguments& options, const ImportReport& r, const Bone& bone, double write_s) {
  Json seconds;
  double total = 0;
  for (const auto& [name, s] : r.seconds) {
    seconds[name] = s;
    total += s;
  }
  seconds["write"] = write_s;
  seconds["total"] = total + write_s;
  Json regions = Json::array();
  for (const auto& [id, mm3] : r.region_mm3) {
    const bool known = bone.materials().Contains(id);
    regions.push_back({{"id", id}, {"name", known ? bone.materials().At(id).name : "none"}, {"volume_mm3", mm3}});
  }
  const Json json = {{"input", options.input},
                     {"kind", r.kind},
                     {"series_uid", r.series_uid},
                     {"ct_voxels", r.size},
                     {"ct_spacing_mm", ToJson(r.spacing_mm)},
                     {"input_hash", fmt::format("{:016x}", r.input_hash)},
                     {"warnings", r.warnings},
                     {"iso_HU", r.iso},
                     {"isolation", r.isolation},
                     {"mask", MaskJson(options, r.mask)},
                     {"contact_mm2", r.contact_mm2},
                     {"volume_mm3", r.solid_mm3},
                     {"volume_above_iso_mm3", r.iso_mm3},
                     {"filled_mm3", r.filled_mm3},
                     {"voids_filled", r.voids.count},
                     {"voids_filled_mm3", r.voids.mm3},
                     {"tooth_mm3", r.tooth_mm3},
                     {"surface", SurfaceJson(r)},
                     {"box_lower_mm", ToJson(r.box.lower)},
                     {"box_upper_mm", ToJson(r.box.upper)},
                     {"box_size_mm", ToJson(r.box.size())},
                     {"pieces", r.pieces},
                     {"dropped_pieces", r.dropped_pieces},
                     {"dropped_mm3", r.dropped_mm3},
                     {"mandible", r.mandible},
                     {"shape_objection", r.shape_objection},
                     {"cut_by_scan", r.cut_by_scan},
                     {"cut_mm2", r.cut_mm2},
                     {"surface_error", ErrorJson(r.surface_error)},
                     {"voxel_mm", bone.voxel_mm()},
                     {"region_voxel_mm", bone.region_voxel_mm()},
                     {"active_voxels", r.active_voxels},
                     {"bone_memory_bytes", r.memory_bytes},
                     {"peak_memory_MB", ReadPeakMemory_MB()},
                     {"hu", HuJson(r)},
                     {"regions", regions},
                     {"seconds", seconds},
                     {"output", options.output}};
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

/// Describes the voids. They are smaller than the CT's voxels, so they are counted separately from the marrow.
std::string VoidsText(const ImportReport& r) {
  if (r.voids.count == 0) return "";
  return fmt::format(" and {} small void{} of {}{}", r.voids.count, r.voids.count == 1 ? "" : "s",
                     FormatVolume(r.voids.mm3), r.voids.count == 1 ? "" : " together");
}

void PrintText(const ImportArguments& options, const ImportReport& r, const Bone& bone, double write_s) {
  const Vec3 size = r.box.size();
  const Vec3 centre = r.box.centre();
  if (r.kind == "mask") {
    fmt::print("mask       {}, {}\n", FormatVolume(r.mask.wanted_mm3), r.isolation);
  } else if (r.kind != "surface") {
    fmt::print("read       {} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm\n", r.size[0], r.size[1], r.size[2],
               r.spacing_mm.x, r.spacing_mm.y, r.spacing_mm.z);
    fmt::print("isolation  {}; {:.0f} mm2 of contact with other bone\n", r.isolation, r.contact_mm2);
  }
  for (std::size_t n = 0; n < options.segments.size(); ++n) {
    fmt::print("{:<10} {}: {}\n", n == 0 ? "segments" : "", kerf::Describe(options.segments[n]),
               Describe(options.meanings[n]));
  }
  fmt::print("volume     {}", FormatVolume(r.solid_mm3));
  if (r.kind != "surface" && r.kind != "mask") {
    fmt::print(" ({} above {:.0f} HU, {} of marrow and canals filled{}, {})", FormatVolume(r.iso_mm3), r.iso,
               FormatVolume(r.filled_mm3), VoidsText(r),
               r.tooth_mm3 > 0 ? FormatVolume(r.tooth_mm3) + " of teeth" : "no teeth");
    if (r.mask.used) {
      fmt::print(
          "\nmask       {}; overrides the CT beyond {:.4g} mm: {} added, {} of joined bone cut off, {} of "
          "the mask's not kept",
          FormatVolume(r.mask.wanted_mm3), r.mask.reach_mm, FormatVolume(r.mask.added_mm3),
          FormatVolume(r.mask.cut_off_mm3), FormatVolume(r.mask.given_away_mm3));
    }
  } else if (r.kind == "surface") {
    fmt::print("\nsurface    {} triangles in {}", r.surface.triangles, r.surface.how);
  }
  fmt::print("\nbox        {:.1f} x {:.1f} x {:.1f} mm around ({:.1f}, {:.1f}, {:.1f})\n", size.x, size.y, size.z,
             centre.x, centre.y, centre.z);
  if (const SurfaceError& e = r.surface_error; e.points > 0) {
    fmt::print("surface    expected error {:.2f} mm (rms): offset {:+.2f} mm (+ is outward), scatter {:.2f} mm\n",
               e.CalcExpected(), e.offset_mm, e.scatter_mm);
  }
  fmt::print("pieces     {}", r.pieces);
  if (r.dropped_pieces > 0)
    fmt::print("; {} smaller pieces of {} in total omitted", r.dropped_pieces, FormatVolume(r.dropped_mm3));
  fmt::print("\nvoxels     {} of {} mm, {:.0f} MB; peak memory {:.0f} MB\n", r.active_voxels, bone.voxel_mm(),
             static_cast<double>(r.memory_bytes) / 1e6, ReadPeakMemory_MB());
  if (r.hu_voxel_mm > 0) {
    fmt::print("CT numbers {:.0f} to {:.0f} HU in the bone, mean {:.0f}, on voxels of {:.4g} mm\n", r.hu.min, r.hu.max,
               r.hu.mean, r.hu_voxel_mm);
  }
  double total = write_s;
  std::string stages;
  for (const auto& [name, s] : r.seconds) {
    total += s;
    stages += fmt::format("{} {:.1f}, ", name, s);
  }
  fmt::print("time       {:.1f} s ({}write {:.1f})\n", total, stages, write_s);
  fmt::print("written    {}\n", options.output);
}

void Warn(const ImportArguments& options, const ImportReport& r) {
  for (const std::string& warning : r.warnings) Say("{}", warning);
  if (r.kind != "surface" && r.kind != "mask" && r.tooth_mm3 == 0 && (r.mandible || options.teeth_asked)) {
    Say("if the CT shows teeth, lower --tooth-hu: no part of the bone has {:.0f} HU or more",
        options.import.tissue.tooth_hu);
  }
  if (r.cut_by_scan) {
    Say("the bone reaches the edge of the scan and is cut off there{}",
        r.cut_mm2 > 0 ? fmt::format(", over {:.0f} mm2", r.cut_mm2) : "");
  }
  if (!r.mandible) {
    Say("all cortical bone is one region, because the bone is not recognised as a mandible{}{}",
        r.shape_objection.empty() ? "" : ": ", r.shape_objection);
  }
}

/// Rejects options that have no effect on this kind of input.
void CheckOptionsApply(const CLI::App& command, const ImportArguments& options) {
  const std::string& input = options.input;
  CheckMaskOptions(command, options.mask);
  if (input.empty() && command.count("--mask") == 0) throw CLI::RequiredError("INPUT");
  if (input.empty()) {
    for (const char* option :
         {"--list",         "--series",       "--as-ct",      "--spacing-z",     "--keep",        "--drop",
          "--keep-markups", "--drop-markups", "--no-isolate", "--any-shape",     "--iso",         "--no-fill",
          "--cortical-hu",  "--shell",        "--tooth-hu",   "--tooth-body-hu", "--tooth-reach", "--keep-hu",
          "--hu-voxel",     "--mask-reach",   "--units"}) {
      if (command.count(option) > 0)
        throw CLI::ValidationError(option, "does not apply to a mask without a CT or a surface");
    }
    return;
  }
  const bool is_surface = IsSurfacePath(input);
  if (is_surface && command.count("--mask") > 0)
    throw CLI::ValidationError("--mask", "applies to a CT only, but INPUT is a surface, which is imported whole");
  if (command.count("--mask") > 0 && command.count("--no-isolate") > 0)
    throw CLI::ValidationError("--no-isolate", "imports all bone, but --mask selects one");
  const std::vector<const char*> idle =
      is_surface ? std::vector{"--list",        "--series",       "--as-ct",        "--spacing-z",  "--keep",
                               "--drop",        "--keep-markups", "--drop-markups", "--no-isolate", "--any-shape",
                               "--iso",         "--cortical-hu",  "--shell",        "--tooth-hu",   "--tooth-body-hu",
                               "--tooth-reach", "--keep-hu",      "--hu-voxel"}
                 : std::vector{"--units", "--mesh-shell"};
  for (const char* option : idle) {
    if (command.count(option) == 0) continue;
    throw CLI::ValidationError(option, is_surface
                                           ? "applies to a CT only, but INPUT is a surface, which is imported whole"
                                           : "applies to a surface only, but INPUT is a CT");
  }
}

void Run(ImportArguments& options) {
  if (options.list) {
    List(options);
    return;
  }
  if (options.output.empty()) throw CLI::RequiredError("-o");
  if (std::filesystem::path(options.output).extension() != ".vdb") {
    throw CLI::ValidationError("-o", fmt::format("'{}' must end in .vdb", options.output));
  }
  CheckWritable(options.output);
  std::vector<std::string> inputs{options.input, options.materials, options.mask.file};
  for (const auto* markups : {&options.keep_markups, &options.drop_markups}) {
    inputs.insert(inputs.end(), markups->begin(), markups->end());
  }
  CheckInputsNotOverwritten(inputs, {options.output});
  ImportOptions& import = options.import;
  import.isolate.isolate = !options.no_isolate;
  import.isolate.check_shape = !options.any_shape;
  import.fill = !options.no_fill;
  for (const std::string& text : options.keep) import.isolate.keep_W.push_back(ParsePoint(text, "--keep"));
  for (const std::string& text : options.drop) import.isolate.drop_W.push_back(ParsePoint(text, "--drop"));
  for (const std::string& path : options.keep_markups) {
    for (const Vec3& p_W : ReadMarkups(path)) import.isolate.keep_W.push_back(p_W);
  }
  for (const std::string& path : options.drop_markups) {
    for (const Vec3& p_W : ReadMarkups(path)) import.isolate.drop_W.push_back(p_W);
  }
  if (!options.materials.empty()) {
    import.materials = ParseRegionTable(ReadTextFile(options.materials), options.materials);
    import.materials_name = std::filesystem::path(options.materials).filename().string();
  }
  if (!options.mask.file.empty()) {
    // `--frame` states the frame of the CT if there is one; the mask's own is then that of its header.
    const bool has_ct = !options.input.empty();
    MaskFile file = ReadMaskFile(options.mask.file, has_ct ? "" : import.frame, options.mask.labels, has_ct);
    import.isolate.mask = std::move(file.mask);
    options.segments = std::move(file.segments);
    options.meanings = std::move(file.meanings);
  }
  ImportResult result;
  double write_s = 0;
  {
    ProgressBar bar("importing");
    import.progress = [&bar](double fraction) { bar.Show(0.97 * fraction);
  };
  result = Import(options.input, import);
  const auto start = std::chrono::steady_clock::now();
  WriteBone(result.bone, options.output);
  write_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}
Warn(options, result.report);
if (options.json) {
  PrintJson(options, result.report, result.bone, write_s);
} else {
  PrintText(options, result.report, result.bone, write_s);
}
}  // namespace

}  // namespace kerf::cli

void AddImportCommand(CLI::App& app) {
  const auto o = std::make_shared<ImportArguments>();
  CLI::App* c =
      app.add_subcommand("import", "Make a bone from a CT (DICOM, NRRD, NIfTI, MetaImage) or a closed surface");
  c->add_option("INPUT", o->input,
                fmt::format("DICOM (folder, DICOMDIR, slice or .zip), image ({}) or surface (.stl .obj .ply); may be "
                            "omitted with --mask",
                            ListImageExtensions()));
  c->add_option("-o,--output", o->output, "Bone file to write (.vdb)");
  c->add_flag("--list", o->list, "Only list the DICOM series");
  c->add_flag("--json", o->json, "Print as JSON");
  AddNumber(*c, "--voxel", o->import, "voxel_mm");
  AddCtOptions(*c, o->import, "The file");

  const std::string which = "Selection of the bone";
  c->add_option("--keep", o->keep, "Point x,y,z in the wanted bone, patient coordinates LPS, mm; may be repeated")
      ->allow_extra_args(false)
      ->group(which);
  c->add_option("--drop", o->drop, "Point x,y,z in unwanted bone; may be repeated")
      ->allow_extra_args(false)
      ->group(which);
  c->add_option("--keep-markups", o->keep_markups,
                "Point list of 3D Slicer (.mrk.json) in the wanted bone; may be repeated")
      ->allow_extra_args(false)
      ->group(which);
  c->add_option("--drop-markups", o->drop_markups,
                "Point list of 3D Slicer (.mrk.json) in unwanted bone; may be repeated")
      ->allow_extra_args(false)
      ->group(which);
  AddMaskOptions(*c, o->mask, o->import, "without INPUT, the bone is made from it alone", which);
  c->add_flag("--no-isolate", o->no_isolate,
              "Import all bone, in pieces of at least 1 cm3, without isolating the mandible")
      ->group(which);
  c->add_flag("--any-shape", o->any_shape,
              "Write the bone that --keep and --drop points or a mask select, even if it does not look like a mandible")
      ->group(which);

  const std::string surface = "Surface and tissues";
  AddIsoOption(*c, o->import.isolate.iso_hu, o->import.iso_auto, kIsoRange_HU)->group(surface);
  c->add_flag("--no-fill", o->no_fill,
              "Leave marrow spaces and canals below the iso value hollow; for a surface, leave every inner shell "
              "hollow (default: only shells that face inward)")
      ->group(surface);
  AddNumber(*c, "--cortical-hu", o->import, "cortical_hu")->group(surface);
  AddNumber(*c, "--shell", o->import, "shell_mm")->group(surface);
  AddNumber(*c, "--mesh-shell", o->import, "mesh_shell_mm")->group(surface);
  c->add_option("--units", o->import.mesh_units,
                "Unit of a surface's coordinates: mm, cm, m, in or um; default: mm, if that gives the size of a bone")
      ->check(CLI::IsMember({"mm", "cm", "m", "in", "um"}))
      ->group(surface);
  AddNumber(*c, "--tooth-hu", o->import, "tooth_hu")->group(surface);
  c->add_option("--tooth-body-hu", o->import.tissue.tooth_body_hu, "Minimum HU of dentin that is joined to enamel")
      ->group(surface);
  c->add_option("--tooth-reach", o->import.tissue.tooth_reach_mm, "Maximum distance of dentin from enamel, mm")
      ->group(surface);
  c->add_option("--materials", o->materials, "Region table (CSV) instead of the built-in one")->group(surface);
  CLI::Option* keep_hu = c->add_flag("--keep-hu", o->import.keep_hu,
                                     "Store the CT numbers in the bone, so that a scene can take its stiffness from "
                                     "them ([material] kind = \"ct\")")
                             ->group(surface);
  AddNumber(*c, "--hu-voxel", o->import, "hu_voxel_mm")->needs(keep_hu)->group(surface);
  c->callback([o, c] {
    CheckOptionsApply(*c, *o);
    o->teeth_asked = c->count("--tooth-hu") + c->count("--tooth-body-hu") + c->count("--tooth-reach") > 0;
    Run(*o);
  });
}

}  // namespace kerf::cli
