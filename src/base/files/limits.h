// Upper limits for JSON files, in one place for this folder (docs/reliability.md lists the limits of all folders).
#pragma once

#include <cstddef>

namespace kerf {

/// Maximum size of a file with points and curves that a user placed, at a few hundred bytes each. After parsing, they
/// take about thirty times as much memory.
inline constexpr std::size_t kMaxMarkupBytes = std::size_t{64} << 20;
/// Maximum nesting depth of lists and objects; a 3D Slicer file has five levels. Recursive processing uses a stack
/// frame per level.
inline constexpr int kMaxJsonDepth = 64;

}  // namespace kerf
