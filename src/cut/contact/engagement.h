// Engaged part of the cutting edge between two samples of it, computed for many pairs at once with vector instructions.
#pragma once

#include <cstddef>

namespace kerf {

/// Parts of intervals between neighbouring points of the edge. Within a part the whole bone's phi and the cut in front
/// of the edge are taken as linear. The arrays are readable up to a multiple of 8 elements.
struct IntervalParts {
  static constexpr std::size_t kRoom = 64;
  std::size_t size = 0;
  int interval[kRoom];
  // Of each part's start and end: the place in its interval, 0 to 1, start < end; and the two fields there, mm.
  alignas(64) double t_a[kRoom] = {}, t_b[kRoom] = {};
  alignas(64) double whole_a_mm[kRoom] = {}, whole_b_mm[kRoom] = {};
  alignas(64) double cut_a_mm[kRoom] = {}, cut_b_mm[kRoom] = {};
};

/// Depths over which the engagement rises, mm: from 0 to 1 while the whole bone's phi falls from half of `entry_mm` to
/// minus that, times from 0 to 1 while the cut falls from 0 to -`look_ahead_mm`.
struct EngagementDepths {
  double entry_mm;
  double look_ahead_mm;
};

/// Integrates the engagement over each part, times the hat function of the interval's start (1 - t) and of its end (t).
/// Exact up to rounding, with the same bits at every vector width. Tick-safe.
void IntegrateEngagement(const EngagementDepths& depths, const IntervalParts& parts, double* of_start, double* of_end);

}  // namespace kerf
