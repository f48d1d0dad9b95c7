// kerf picture: draws a bone or a CT.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "app/cli/commands.h"
#include "app/cli/ct_options.h"
#include "app/cli/ct_sheet.h"
#include "app/cli/mask_options.h"
#include "app/cli/numbers.h"
#include "base/files/files.h"
#include "bone/import/dicom_input.h"
#include "bone/import/image_header.h"
#include "bone/segmentation/mask_file.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct PictureArguments {
  std::string file;
  std::string output;
  std::string view = "three-quarter";
  std::string colour = "tissue";
  std::string size;
  std::string title;
  bool dark = false;
  bool axes = false;
  CtSheetOptions ct;
  MaskArguments mask;
};

bool ParseSize(const std::string& text, int& width, int& height) {
  const char* end = text.data() + text.size();
  const auto [after_width, width_error] = std::from_chars(text.data(), end, width);
  if (width_error != std::errc() || after_width == end || *after_width != 'x') return false;
  const auto [after_height, height_error] = std::from_chars(after_width + 1, end, height);
  return height_error == std::errc() && after_height == end;
}

std::string CheckSize(const std::string& text) {
  int width = 0;
  int height = 0;
  const bool fits =
      ParseSize(text, width, height) && kPictureSideRange.Contains(width) && kPictureSideRange.Contains(height);
  return fits ? std::string()
              : fmt::format("'{}' is not a size: give WIDTHxHEIGHT, each {}", text,
                            ShowRange(kPictureSideRange, "pixels"));
}

/// Returns true if an import would read the path as a CT.
bool IsCt(const std::string& path) {
  return HasImageExtension(path) || DicomInput::Is(path);
}

void DrawCt(const PictureArguments& options) {
  CtSheetOptions sheet = options.ct;
  sheet.input = options.file;
  sheet.output = options.output;
  sheet.title = options.title;
  if (!options.size.empty()) ParseSize(options.size, sheet.width, sheet.height);
  if (!options.mask.file.empty()) {
    sheet.import.isolate.mask = ReadMaskFile(options.mask.file, "", options.mask.labels, true).mask;
  }
  DrawCtSheet(sheet);
}

void DrawBone(const PictureArguments& options) {
  const Bone bone = ReadBone(options.file);
  PictureSpec spec;
  if (!options.size.empty()) ParseSize(options.size, spec.width, spec.height);
  spec.axes = options.axes;
  spec.camera = MakeCamera(*ViewFromString(options.view));
  spec.dark = options.dark;
  const Vec3 size = bone.CalcBounds().size();
  spec.title = options.title.empty() ? std::filesystem::path(options.file).stem().string() : options.title;
  spec.caption = fmt::format("{:.1f} cm³, {:.0f} x {:.0f} x {:.0f} mm, voxels of {:g} mm", bone.CalcVolume() / 1000,
                             size.x, size.y, size.z, bone.voxel_mm());
  const ColourBy by = options.colour == "region"  ? ColourBy::kRegion
                      : options.colour == "plain" ? ColourBy::kPlain
                                                  : ColourBy::kTissue;
  Shape shape;
  shape.mesh_W = ExtractSurface(bone);
  if (shape.mesh_W.triangles.empty())
    throw Error(fmt::format("{}: contains no bone, so there is nothing to draw", options.file));
  SurfaceColours colours = CalcSurfaceColours(bone, shape.mesh_W, by);
  shape.point_colours = std::move(colours.points);
  spec.legend = std::move(colours.legend);
  spec.shapes.push_back(std::move(shape));
  WritePicture(spec, options.output);
  fmt::print("{}\n", options.output);
}

void Run(const CLI::App& command, const PictureArguments& options) {
  constexpr char kOnlyCt[] = "applies to CTs, but the input is a bone";
  const bool ct = IsCt(options.file);
  for (const char* name : {"--view", "--colour", "--dark"}) {
    if (ct && command.count(name) > 0) throw CLI::ValidationError(name, "applies to bones; a CT is drawn in slices");
  }
  for (const char* name : {"--slice", "--keep", "--drop", "--iso", "--mask"}) {
    if (!ct && command.count(name) > 0) throw CLI::ValidationError(name, kOnlyCt);
  }
  if (!ct) RejectCtOptions(command, kOnlyCt);
  CheckMaskOptions(command, options.mask);
  CheckWritable(options.output);
  CheckInputsNotOverwritten({options.file, options.mask.file}, {options.output});
  ct ? DrawCt(options) : DrawBone(options);
}

}  // namespace

void AddPictureCommand(CLI::App& app) {
  const auto o = std::make_shared<PictureArguments>();
  CLI::App* command = app.add_subcommand("picture", "Draw a bone or a CT as a PNG; needs no display");
  command
      ->add_option("BONE", o->file,
                   "Bone file (.vdb), or a CT, as 'kerf import' reads it: a folder of DICOM files or an image")
      ->required();
  command->add_option("-o,--output", o->output, "Picture file to write (.png)")->required();
  command->add_flag("--axes", o->axes,
                    "Draw patient coordinates (LPS), mm, along the edges, and a grid; always drawn for a CT");
  command
      ->add_option("--size", o->size,
                   fmt::format("Width and height, pixels, each {} (CT: {}); default: 1280x720 (CT: 2400x1800)",
                               ShowRange(kPictureSideRange, ""), ShowRange(kSheetSideRange, "")))
      ->check(CLI::Validator(CheckSize, ""));
  command->add_option("--title", o->title, "Title of the picture; default: the file's name");

  const std::string bone = "A bone";
  command
      ->add_option("--view", o->view,
                   "Side from which the patient is seen: front, back, left, right, top, bottom or three-quarter")
      ->check(CLI::IsMember({"front", "back", "left", "right", "top", "bottom", "three-quarter"}).description(""))
      ->group(bone);
  command
      ->add_option(
          "--colour", o->colour,
          "Meaning of the colours: tissue (cortical, cancellous, tooth, canal), region (of the table) or plain")
      ->check(CLI::IsMember({"tissue", "region", "plain"}).description(""))
      ->group(bone);
  command->add_flag("--dark", o->dark, "Use a dark background instead of white")->group(bone);

  const std::string ct = "A CT, to read off points for 'kerf import --keep' and '--drop'";
  command
      ->add_option("--slice", o->ct.slices,
                   "Slice to draw: x=MM, y=MM or z=MM; may be repeated; default: the bone from the front and the left, "
                   "and axial slices through the points, or ten over the bone's height")
      ->allow_extra_args(false)
      ->group(ct);
  command->add_option("--keep", o->ct.keep, "Point x,y,z (LPS, mm) to mark in green; may be repeated")
      ->allow_extra_args(false)
      ->group(ct);
  command->add_option("--drop", o->ct.drop, "Point x,y,z (LPS, mm) to mark in orange; may be repeated")
      ->allow_extra_args(false)
      ->group(ct);
  AddIsoOption(*command, o->ct.import.isolate.iso_hu, o->ct.import.iso_auto, kIsoRange_HU)->group(ct);
  AddCtOptions(*command, o->ct.import, ct);
  AddMaskOptions(*command, o->mask, o->ct.import, "what it selects, adds and cuts off is tinted", ct);
  command->callback([o, command] { Run(*command, *o); });
}

}  // namespace kerf::cli
