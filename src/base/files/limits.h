// The most that a file may ask for, in one place for this folder (docs/reliability.md lists those of all).
#pragma once

#include <cstddef>

namespace kerf {

/// Points and curves that people place, some hundred bytes each. Parsed they take about thirty times as much.
inline constexpr std::size_t kMaxMarkupBytes = std::size_t{64} << 20;
/// Lists and objects within each other: a file of 3D Slicer has five. Each takes a frame of the stack in what goes
/// through them.
inline constexpr int kMaxJsonDepth = 64;

}  // namespace kerf
