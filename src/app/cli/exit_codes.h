// Exit codes of the program.
#pragma once

namespace kerf::cli {

inline constexpr int kFailed = 1;
inline constexpr int kUsage = 2;
/// The results were written, but the recording they come from is damaged or truncated.
inline constexpr int kReadDamaged = 3;

/// Thrown by a command that has written its results and has warned of the damage; the program exits with kReadDamaged.
struct ReadDamaged {};

}  // namespace kerf::cli
