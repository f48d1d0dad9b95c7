// Parts of scene files with a block, and a small scene made of them: a disc moves straight down into the block.
// Numbers are written with a decimal point, so that tests can find and replace them.
#pragma once

#include <fmt/format.h>

#include <string>

#include "kerf/geometry.h"

namespace kerf::test {

/// Returns the number with a decimal point. ({:#} gives 6.0 in fmt 9 and 6. in fmt 10, which is not TOML.)
inline std::string Real(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// A block with its top face at z = 0, centred on the z axis.
inline std::string BlockToml(const Vec3& size_mm, double voxel_mm) {
  return fmt::format(
      "[bone]\nmodel = \"block\"\n[bone.block]\nsize_x_mm = {}\nsize_y_mm = {}\nsize_z_mm = {}\nvoxel_mm = "
      "{}\n",
      Real(size_mm.x), Real(size_mm.y), Real(size_mm.z), Real(voxel_mm));
}

/// A layer of the block, after its other keys; the first is at the top.
inline std::string LayerToml(double thickness_mm, int region) {
  return fmt::format("[[bone.block.layer]]\nthickness_mm = {}\nregion = {}\n", Real(thickness_mm), region);
}

inline std::string SawToml(double diameter_mm, double thickness_mm, int teeth) {
  return fmt::format("[tool]\ndiameter_mm = {}\nthickness_mm = {}\nteeth = {}\n", Real(diameter_mm), Real(thickness_mm),
                     teeth);
}

/// A stroke of the path. `more`: further keys of it.
inline std::string StrokeToml(const Vec3& start_mm, const Vec3& end_mm, double feed_mm_per_s, const Vec3& disc_normal,
                              const std::string& more = "") {
  const auto list = [](const Vec3& v) { return fmt::format("[{}, {}, {}]", Real(v.x), Real(v.y), Real(v.z)); };
  return fmt::format("[[path.stroke]]\nstart_mm = {}\nend_mm = {}\nfeed_mm_per_s = {}\ndisc_normal = {}\n{}",
                     list(start_mm), list(end_mm), Real(feed_mm_per_s), list(disc_normal), more);
}

/// Heights of the centre of the disc, which touches the block at 7.5 mm.
struct DownStroke {
  double from_mm = 7.8;
  double to_mm = 2.5;
  double feed_mm_per_s = 3;
};

/// Returns a scene with a block of 6 x 4 x 3 mm about the origin in voxels of 0.25 mm, and a disc of 12 mm with its
/// axis along x. `more`: text appended to the scene's file.
inline std::string MakeBlockScene(const DownStroke& stroke = {},
                                  const std::string& more = "[output]\npictures = false\n") {
  return BlockToml({6, 4, 3}, 0.25) + SawToml(12, 0.5, 16) +
         StrokeToml({0, 0, stroke.from_mm}, {0, 0, stroke.to_mm}, stroke.feed_mm_per_s, {1, 0, 0}) + more;
}

/// A bar of 3 x 4 mm along x, 8 mm long, in voxels of 0.2 mm, and a disc.
inline const std::string kBarToml = BlockToml({8, 4, 3}, 0.2) + SawToml(12, 0.5, 16);

/// The disc is lowered through the bar's middle, and touches it 2 mm further along.
inline const std::string kThroughBarToml = StrokeToml({0, 0, 6.5}, {0, 0, 0.5}, 3, {1, 0, 0}) +
                                           StrokeToml({2, 0, 7}, {2, 0, 6.5}, 3, {1, 0, 0}) +
                                           "[hand]\nmodel = \"H4\"\n";

/// A piece is cut off next to the bar's middle at `feed_mm_per_s`; then the hand moves far away, sideways, and down
/// through the smaller piece.
inline std::string CutOffToml(double feed_mm_per_s) {
  const std::string goes_on = "retract = false\n";
  return StrokeToml({0.5, 0, 6.5}, {0.5, 0, 0.5}, feed_mm_per_s, {1, 0, 0}) +
         StrokeToml({0.5, 0, 0.5}, {0.5, 0, 22}, 20, {1, 0, 0}, goes_on) +
         StrokeToml({0.5, 0, 22}, {2.4, 0, 22}, 2, {1, 0, 0}, goes_on) +
         StrokeToml({2.4, 0, 22}, {2.4, 0, 2}, 8, {1, 0, 0}, goes_on) +
         "[force]\nlaw = \"hertz_chip\"\n[hand]\nmodel = \"H4\"\n[effects.fragments]\n";
}

}  // namespace kerf::test
