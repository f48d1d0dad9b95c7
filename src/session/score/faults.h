// Faults of a cut: where it lies relative to the wanted one, and what that costs.
#pragma once

#include <string_view>
#include <vector>

#include "session/score/measures.h"

namespace kerf {

/// Returns 0 for a measure without a value.
double GetOrZero(const ScoreSheet& sheet, std::string_view key);

/// Returns true if the wanted cut goes through the bone, so that there is no depth.
bool IsThrough(ExerciseKind kind);
/// Returns the part of outside_mm3 that lies beside the wanted cut.
double CalcBeside_mm3(const ScoreSheet& sheet);
/// Returns true if the cut lies further beside the wanted one than the margin.
bool IsBeside(const ScoreSheet& sheet);
/// Returns true if most of the removed bone lies beside the wanted cut, further from its plane than the margin.
bool IsMostlyBeside(const ScoreSheet& sheet);
/// Returns false if the plane that was fitted to the removed bone cannot be that of the cut. Several cuts side by side
/// have no common plane.
bool IsPlaneSensible(const ScoreSheet& sheet);
/// Returns true for a measure of the fitted plane.
bool IsOfPlane(std::string_view key);
/// Returns true if the cut stays above the wanted depth rather than below it.
bool IsShallow(const ScoreSheet& sheet);

/// Aspects of a cut that cost points.
enum class Fault {
  kMissing,  // part of the wanted cut was not made
  kBeside,   // the cut lies beside the wanted one
  kTilted,   // it has another direction
  kTooDeep,
  kTooShallow,
  kPlunge,   // beyond the far side
  kOutside,  // bone removed beside the wanted cut
  kBeyondEnd,
  kNerve,
  kTrembling,
  kLongPath,
  kSlow,
  kFeed,  // not the wanted one
};
/// Returns the fault that a lost point of a measure means.
Fault FaultOf(std::string_view key, bool beside, bool shallow);

struct FaultLoss {
  Fault fault;
  double lost = 0;  // points of 100
};
/// Returns what cost points in a graded attempt, the largest loss first; the losses add up to 100 - total. Points for
/// bone that was removed outside are attributed to what lies there: below the wanted cut to the depth, beyond its ends
/// and beside it. Points for bone that is missing or was removed beside are attributed to the position if the cut lies
/// beside the wanted one by more than the margin, because moving it would regain them. Returns nothing for a sheet
/// without a total.
std::vector<FaultLoss> FindLosses(const ScoreSheet& sheet);

}  // namespace kerf
