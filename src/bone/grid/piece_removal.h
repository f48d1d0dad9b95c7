// A piece that is taken out of a bone, and put back: which values change, leaf by leaf.
#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "bone/grid/piece_finder.h"
#include "kerf/bone.h"

namespace kerf {

/// A leaf of the bone (SetLeaf()) with the piece and without it.
struct LeafChange {
  std::array<int, 3> index{};
  std::array<float, 512> with{};
  std::array<float, 512> without{};
};

struct PieceRemoval {
  std::vector<LeafChange> leaves;  // 4 kB each
  Box3 bounds_W;                   // of the leaves
  Bone piece;                      // by itself: to be meshed, written, drawn at a pose
  std::array<double, 256> mm3{};   // of it, by region
};

inline constexpr int kAllDust = 0;  // in the place of a piece's number: all that is too small for one

/// Of a piece as the finder found it in this bone, or in one that was the same but for leaves told to it. Values change
/// where the piece is, and outside of the bone where it was what was near: the surface of what is left stays as it is
/// to the bit, but where both touch by an edge or a corner. Throws Error when there is no such piece. Not for the tick:
/// two seconds for half a mandible at 0.1 mm.
PieceRemoval MakePieceRemoval(const Bone& bone, const PieceFinder& finder, int id);

/// Whether a tool of that reach at p_W is so far from the box that changes that the lists of leaves near its edge don't
/// hold any of it: they look ahead by a leaf or 1 mm, and by the band; one more of each is asked. Tick-safe.
inline bool IsToolClearOf(const Box3& bounds_W, const Vec3& p_W, double reach_mm, double voxel_mm) {
  return glm::length(p_W - glm::clamp(p_W, bounds_W.lower, bounds_W.upper)) > reach_mm + 24 * voxel_mm + 2;
}

/// A value as it becomes where `from` is to be `to`, `now` being what it is: cutting raised it in between, or not. Cut
/// before or after, it comes out the same.
inline float ReplaceValue(float now, float from, float to) {
  return now == from ? to : now > to ? now : to;
}

}  // namespace kerf
