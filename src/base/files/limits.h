// Upper limits for JSON files, in one place for this folder (docs/reliability.md lists the limits of all folders).
#pragma once

#include <cstddef>

namespace kerf {

/// Points and curves placed by users, a few hundred bytes each. In memory, after parsing, they are about thirty times
/// as large.
inline constexpr std::size_t kMaxMarkupBytes = std::size_t{64} << 20;
/// Nesting depth of lists and objects; a 3D Slicer file has five levels. Recursive processing uses a stack frame per
/// level.
inline constexpr int kMaxJsonDepth = 64;

}  // namespace kerf
