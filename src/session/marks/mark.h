// Structures that a user marks on a bone: curves with a radius.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

enum class MarkKind : std::uint8_t { kNerve, kCanal, kTooth, kRoot, kOther, kLesion };
/// Words of files, in the order of MarkKind.
inline constexpr std::array<std::string_view, 6> kMarkKindWords{"nerve", "canal", "tooth", "root", "other", "lesion"};
std::string_view ToString(MarkKind kind);
std::optional<MarkKind> MarkKindFromString(std::string_view word);
/// Nerves with their canals, and teeth with their roots.
constexpr bool IsNerve(MarkKind kind) {
  return kind == MarkKind::kNerve || kind == MarkKind::kCanal;
}
constexpr bool IsTooth(MarkKind kind) {
  return kind == MarkKind::kTooth || kind == MarkKind::kRoot;
}

/// A smooth curve through points, with a radius: a tube with round ends. A single point is a ball.
struct Mark {
  std::string name{};
  MarkKind kind = MarkKind::kNerve;
  double radius_mm = 1;
  std::vector<Vec3> points_W{};  // world frame, mm; on the surface or in CT slices

  bool operator==(const Mark&) const = default;
};

inline constexpr TextLimit kMarkNameLimit{60};
inline constexpr Range kMarkRadiusRange_mm{0.05, 50};
inline constexpr std::size_t kMaxMarks = 100;
inline constexpr std::size_t kMaxMarkPoints = 1000;

/// Throws kerf::Error naming the first mark without a name, with a duplicate name, with a radius or a point out of
/// range, or with too many points, or if there are too many marks.
void CheckMarks(const std::vector<Mark>& marks);
/// Returns the first unused of "nerve", "nerve 2", ...
std::string MakeMarkName(const std::vector<Mark>& marks, MarkKind kind);
/// Appends marks. A name that is already in use gets a number: "nerve 2".
void AppendMarks(std::vector<Mark>& marks, std::vector<Mark> added);

/// Marks that are read from a file must not be farther outside of the box around the bone.
inline constexpr double kMarkSurroundings_mm = 50;
/// Throws kerf::Error naming the first mark with a point farther outside of the bone's box than kMarkSurroundings_mm.
void CheckMarksNear(const std::vector<Mark>& marks, const Box3& bone_W);

/// Edits. All throw kerf::Error if there is no such point, if the mark would have too many, or if a point is outside
/// the world. AddPoint() continues the curve at its end. InsertPoint() inserts the point between the two neighbours
/// whose part of the curve is nearest to it (beyond an end too; use AddPoint() there), and returns its index.
void AddPoint(Mark& mark, const Vec3& p_W);
std::size_t InsertPoint(Mark& mark, const Vec3& p_W);
void MovePoint(Mark& mark, std::size_t i, const Vec3& p_W);
void RemovePoint(Mark& mark, std::size_t i);

/// Returns the curve as a polyline: the centripetal Catmull-Rom spline through the points, which has neither loops nor
/// cusps between them (Yuksel et al. 2011). At its ends it leaves towards the mirrored neighbour. Two points give a
/// straight line. Consecutive points at the same place count once. The polyline deviates from the spline by less than
/// kCurveError_mm. `first_of_span` (optional) receives, for each point of the mark but the last, the index where the
/// polyline passes through it.
std::vector<Vec3> CalcCurve(const std::vector<Vec3>& points_W, std::vector<std::size_t>* first_of_span = nullptr);
inline constexpr double kCurveError_mm = 0.01;

}  // namespace kerf
