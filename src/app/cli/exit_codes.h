// What the program's exit codes mean.
#pragma once

namespace kerf::cli {

inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;
/// The results were written, but of a recording that is damaged or cut short.
inline constexpr int kReadDamaged = 3;

/// Thrown by a command that has written its results and has warned of the damage: the program ends with kReadDamaged.
struct ReadDamaged {};

}  // namespace kerf::cli
