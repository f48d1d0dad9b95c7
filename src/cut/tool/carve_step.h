// One step of a tool as the innermost loop of removal reads it (cut/removal/carve.h).
#pragma once

#include <array>
#include <cstddef>

namespace kerf {

/// One step of the tool, in mm, in the frame of the EdgeZone at the end of the step. The tool comes from `back` *
/// `length`. The `back` of a blade has no z component.
struct CarveStep {
  std::size_t kind = 0;       // of the tool: index of the alternative of Tool
  bool whole_voxels = false;  // write phi in steps of a voxel
  int precision_bits = 24;    // bits of phi's significand that are kept, 4 to 24 (all bits of a float)
  bool new_only = false;      // skip what the previous step, which ended at this one's start, has carved as deeply
  float radius = 0;
  float half_thickness = 0;  // blade only
  float edge_depth = 0;      // blade only: depth inside the rim to which it cuts
  float back[3] = {0, 0, 0};
  float length = 0;
  float flank_slack = 0;  // new_only: bound on the distance of a blade's flats from where they last cut; of a solid of
                          // revolution, on the way of its surface by the rotation since the previous step
  float band = 0;
  struct Face {
    float r, z, offset;  // as RoundSolid::Face
    // Set by Prepare(). Along the step, from its end, the slope of the face's distance is (turn * coordinate across the
    // axis + rise * radius) / radius. The distance is least where the coordinate is that of the axis plus at_least
    // times the line's distance from the axis.
    float turn = 0, rise = 0, at_least = 0;
    float extent = 0;  // half of a brick's extent across the face, at most
  };
  Face faces[3] = {};    // of a solid of revolution
  float ceiling = 1e9f;  // of a solid of revolution: height up to which it cuts
  float voxel = 0;
  float rounding = 0;       // error bound of the float arithmetic
  float grid[3][3] = {{}};  // [i]: step to the next voxel along axis i of the bone's grid
  /// Blade with an outline: the sides of its sweep, counter-clockwise.
  struct Side {
    float x, y;    // corner at its start
    float nx, ny;  // outward normal
    float length;
    bool cuts;  // belongs to the edge
  };
  static constexpr int kMaxSides = 32;
  int sides = 0;
  Side side[kMaxSides] = {};
  /// Returns the middle of a leaf, from the position of its lowest voxel.
  std::array<float, 3> Middle(const std::array<float, 3>& corner) const {
    constexpr float kHalfLeaf = 3.5f;
    std::array<float, 3> middle = corner;
    for (std::size_t i = 0; i < 3; ++i) middle[i] += kHalfLeaf * (grid[0][i] + grid[1][i] + grid[2][i]);
    return middle;
  }
  /// Returns a step of a disc or a ball for FindBricks() only: what it can't change, no step like this one changes, in
  /// any direction, as long as no point of the zone is then more than `slack` mm from where it is at the end of this
  /// one.
  CarveStep Widened(float slack) const;
  /// Computes the members below, which are the same for all leaves. A leaf is divided into 64 bricks of 2 x 4 voxels
  /// along y and z.
  void Prepare();
  alignas(64) float steps_x[3][8] = {{}};      // [i]: from a leaf's first voxel to the next ones along x, tool axis i
  alignas(64) float middles[3][8] = {{}};      // to the middles of the bricks with the same x
  alignas(64) float voxels[8][3][8] = {{{}}};  // to the voxels of each of these bricks
  float half_y[3] = {0, 0, 0};                 // from the middle of a brick to its outermost voxels along y
  float half_z[3] = {0, 0, 0};                 // and along z
  float brick_mm = 0;    // distance of a brick's corner from its middle across the spindle, at most
  float brick_z_mm = 0;  // and along the spindle
  float bend_mm = 0;     // bound on the distance of a brick's corner from the tangent at its middle
  float per_across = 0;  // 1 / part of `back` across the axis; 0 if there is none
  float way_across = 0;  // that part of the way
  float behind_mm = 0;   // bound along `back` for the middles of bricks that reach in front of the start
};

}  // namespace kerf
