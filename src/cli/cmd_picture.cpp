// kerf picture: what a bone looks like.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "bone/surface.h"
#include "bonefile/bonefile.h"
#include "cli/commands.h"
#include "files/files.h"
#include "kerf/error.h"
#include "render/picture.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string file;
  std::string output;
  std::string view = "three-quarter";
  std::string colour = "tissue";
  std::string size = "1280x720";
  std::string title;
  bool dark = false;
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
  const bool fits = ParseSize(text, width, height) && width >= 64 && height >= 64 && width <= 8192 && height <= 8192;
  return fits ? std::string() : fmt::format("'{}' is no size: give it as WIDTHxHEIGHT, each 64 to 8192 pixels", text);
}

void Run(const Options& options) {
  CheckWritable(options.output);
  CheckInputsStay({options.file}, {options.output});
  const Bone bone = ReadBone(options.file);
  PictureSpec spec;
  ParseSize(options.size, spec.width, spec.height);
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
    throw Error(fmt::format("{}: holds no bone, so there is nothing to see", options.file));
  SurfaceColours colours = CalcSurfaceColours(bone, shape.mesh_W, by);
  shape.point_colours = std::move(colours.points);
  spec.legend = std::move(colours.legend);
  spec.shapes.push_back(std::move(shape));
  WritePicture(spec, options.output);
  fmt::print("{}\n", options.output);
}

}  // namespace

void AddPictureCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("picture", "Draw a bone as a PNG; needs no display.");
  command->add_option("BONE", options->file, "The bone (.vdb).")->required();
  command->add_option("-o,--output", options->output, "The picture to write (.png).")->required();
  command
      ->add_option(
          "--view", options->view,
          "From where the patient is seen: front, back, left, right, top, bottom or three-quarter (the default).")
      ->check(CLI::IsMember({"front", "back", "left", "right", "top", "bottom", "three-quarter"}).description(""));
  command
      ->add_option("--colour", options->colour,
                   "What the colours say: tissue (cortical, cancellous, tooth, canal; the default), region (of the "
                   "table) or plain.")
      ->check(CLI::IsMember({"tissue", "region", "plain"}).description(""));
  command
      ->add_option("--size", options->size, "Width and height in pixels, as in the default 1280x720; each 64 to 8192.")
      ->check(CLI::Validator(CheckSize, ""));
  command->add_option("--title", options->title, "The line at the top; by default the bone's file name.");
  command->add_flag("--dark", options->dark, "Dark background instead of white.");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
