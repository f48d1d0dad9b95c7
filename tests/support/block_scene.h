// A small scene for tests of the program: a disc moves straight down into a block.
#pragma once

#include <fmt/format.h>

#include <string>

namespace kerf::test {

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
  return fmt::format(R"([bone]
model = "block"
[bone.block]
size_x_mm = 6.0
size_y_mm = 4.0
size_z_mm = 3.0
voxel_mm = 0.25
[tool]
diameter_mm = 12.0
thickness_mm = 0.5
teeth = 16
[[path.stroke]]
start_mm = [0.0, 0.0, {}]
end_mm = [0.0, 0.0, {}]
feed_mm_per_s = {}
disc_normal = [1.0, 0.0, 0.0]
{})",
                     stroke.from_mm, stroke.to_mm, stroke.feed_mm_per_s, more);
}

}  // namespace kerf::test
