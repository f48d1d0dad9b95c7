// Removal of a piece from a bone and its restoration: the values that change, leaf by leaf.
#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "bone/grid/piece_finder.h"
#include "kerf/bone.h"

namespace kerf {

/// Values of the cut in a leaf of the bone (see SetCut()) with the piece and without it. Without it, its space is cut.
struct LeafChange {
  std::array<int, 3> index{};
  std::array<float, 512> with{};
  std::array<float, 512> without{};
};

struct PieceRemoval {
  std::vector<LeafChange> leaves;  // 4 kB each
  Box3 bounds_W;                   // of the leaves; world frame, mm
  Bone piece;                      // the piece alone: to be meshed, written, or drawn at a pose
  std::array<double, 256>
      mm3{};  // volume by region that the bone loses: that of the piece, except for rounding of edges
};

inline constexpr int kAllDust = 0;  // used in place of a piece's id for all dust

/// Computes the removal of piece `id`, as the finder found it in this bone or in one that differs only by leaves that
/// were passed to the finder. Values change in the piece and, near it, outside the bone. The surface of the remaining
/// bone stays bit-identical where at least two voxels lie between it and the piece. In a narrower kerf the cut is
/// continued from the remaining bone as if there were no piece, which moves the surface by up to a fortieth of a voxel.
/// Throws kerf::Error if there is no such piece. Not tick-safe: takes two seconds for half a mandible at 0.1 mm.
PieceRemoval MakePieceRemoval(const Bone& bone, const PieceFinder& finder, int id);

/// Returns whether a tool of reach `reach_mm` at p_W is so far from the box in which the bone changes that the lists of
/// leaves near the tool's edge contain no leaf of this box. These lists look ahead by a leaf or 1 mm, plus the band;
/// this function requires at least twice that. Tick-safe.
inline bool IsToolClearOf(const Box3& bounds_W, const Vec3& p_W, double reach_mm, double voxel_mm) {
  return glm::length(p_W - glm::clamp(p_W, bounds_W.lower, bounds_W.upper)) > reach_mm + 24 * voxel_mm + 2;
}

/// Replaces the value `from` with `to`. `now` is the current value, which cutting may have raised in between. The
/// result is the same whether the bone is cut before or after the replacement.
inline float ReplaceValue(float now, float from, float to) {
  return now == from ? to : now > to ? now : to;
}

}  // namespace kerf
