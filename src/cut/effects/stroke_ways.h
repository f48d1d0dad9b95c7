// The two ways of a stroke, for forces that act against its motion. Tick-safe.
#pragma once

#include <array>
#include <cmath>

#include "cut/tool/drive.h"

namespace kerf {

/// One of the two ways of a stroke.
struct StrokeWay {
  double share = 0;     // of the step's time
  double mm_per_s = 0;  // velocity along the edge
};

/// Strokes a minute up to which a tool in a hand follows the stroke. The mass of a real handpiece prevents more.
inline constexpr double kFollowedRate_per_min = 1200;

/// Returns the ways forwards and backwards. One way has the whole step unless the step contains a turn. A fast stroke
/// in a hand moves half of any step either way: the model's tool has no mass, so that a force which acts one way would
/// make it follow the stroke. `rpm`: double strokes a minute, signed.
inline std::array<StrokeWay, 2> FindStrokeWays(const DriveStep& stroke, double rpm, bool is_held) {
  const double speed = stroke.speed_mm_per_s;
  if (!(speed > 0)) return {{{1, 0}, {0, 0}}};
  const bool follows = !is_held || std::abs(rpm) <= kFollowedRate_per_min;
  const double forwards = follows ? 0.5 * (1 + stroke.velocity_mm_per_s / speed) : 0.5;
  return {{{forwards, speed}, {1 - forwards, -speed}}};
}

}  // namespace kerf
