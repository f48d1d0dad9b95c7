#include "session/marks/mark.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <set>
#include <utility>

#include "kerf/error.h"
#include "session/marks/segment.h"

namespace kerf {
namespace {

constexpr double kSamePlace_mm = 1e-9;
constexpr int kMaxHalvings = 12;

void CheckPoint(const Mark& mark, const Vec3& p_W) {
  if (!IsInWorld(p_W)) throw Error(fmt::format("a point of the mark '{}' is not a valid place", mark.name));
}

void CheckIndex(const Mark& mark, std::size_t i) {
  if (i >= mark.points_W.size()) {
    throw Error(
        fmt::format("the mark '{}' has {} points, so there is no point {}", mark.name, mark.points_W.size(), i + 1));
  }
}

void CheckRoom(const Mark& mark) {
  if (mark.points_W.size() >= kMaxMarkPoints) {
    throw Error(
        fmt::format("the mark '{}' has {} points already, the largest possible number", mark.name, kMaxMarkPoints));
  }
}

std::string MakeUnusedName(const std::vector<Mark>& marks, const std::string& wanted) {
  const auto is_taken = [&](const std::string& name) {
    return std::any_of(marks.begin(), marks.end(), [&](const Mark& mark) { return mark.name == name; });
  };
  // A number at the end is replaced.
  const std::size_t last = wanted.find_last_not_of("0123456789");
  const bool numbered = last != std::string::npos && last > 0 && last + 1 < wanted.size() && wanted[last] == ' ';
  const std::string base = numbered ? wanted.substr(0, last) : wanted;
  std::string name = wanted;
  for (int i = 2; is_taken(name); ++i) name = fmt::format("{} {}", base, i);
  return name;
}

/// A span of the spline between its second and third point, by the algorithm of Barry and Goldman.
class SplineSpan {
 public:
  SplineSpan(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) : p_{a, b, c, d} {
    for (std::size_t i = 1; i < 4; ++i) t_[i] = t_[i - 1] + std::sqrt(glm::length(p_[i] - p_[i - 1]));
  }
  /// `f`: 0 at the second point, 1 at the third.
  Vec3 Calc(double f) const {
    const double t = t_[1] + f * (t_[2] - t_[1]);
    const auto mix = [&](const Vec3& a, const Vec3& b, std::size_t i, std::size_t j) {
      return (t_[j] - t) / (t_[j] - t_[i]) * a + (t - t_[i]) / (t_[j] - t_[i]) * b;
    };
    const Vec3 a = mix(p_[0], p_[1], 0, 1);
    const Vec3 b = mix(p_[1], p_[2], 1, 2);
    const Vec3 c = mix(p_[2], p_[3], 2, 3);
    return mix(mix(a, b, 0, 2), mix(b, c, 1, 3), 1, 2);
  }

 private:
  std::array<Vec3, 4> p_;
  std::array<double, 4> t_{};
};

/// Appends points of the span in (from, to], as many as the polyline needs to stay within kCurveError_mm of it.
void Flatten(const SplineSpan& span, double from, const Vec3& p_from, double to, const Vec3& p_to, int halvings,
             std::vector<Vec3>& line) {
  const double middle = 0.5 * (from + to);
  const Vec3 p = span.Calc(middle);
  // The distance of a smooth curve from its chord is largest near the middle. The spans are halved three times in any
  // case, so that each part bends to one side only.
  const bool is_close = halvings >= 3 && CalcSegmentDistance(p, p_from, p_to) < 0.5 * kCurveError_mm;
  if (is_close || halvings == kMaxHalvings) {
    line.push_back(p_to);
    return;
  }
  Flatten(span, from, p_from, middle, p, halvings + 1, line);
  Flatten(span, middle, p, to, p_to, halvings + 1, line);
}

}  // namespace

std::string_view ToString(MarkKind kind) {
  return kMarkKindWords[static_cast<std::size_t>(kind)];
}

std::optional<MarkKind> MarkKindFromString(std::string_view word) {
  for (std::size_t i = 0; i < kMarkKindWords.size(); ++i) {
    if (word == kMarkKindWords[i]) return static_cast<MarkKind>(i);
  }
  return {};
}

void CheckMarks(const std::vector<Mark>& marks) {
  if (marks.size() > kMaxMarks) throw Error(fmt::format("there can be at most {} marks", kMaxMarks));
  std::set<std::string> names;
  for (const Mark& mark : marks) {
    if (mark.name.empty()) throw Error("a mark has no name");
    if (!names.insert(mark.name).second) {
      throw Error(fmt::format("two marks are named '{}'; each needs its own name", mark.name));
    }
    CheckRange("radius_mm", mark.radius_mm, kMarkRadiusRange_mm, fmt::format("mark '{}'", mark.name));
    if (mark.points_W.size() > kMaxMarkPoints) {
      throw Error(fmt::format("the mark '{}' has {} points; the largest possible number is {}", mark.name,
                              mark.points_W.size(), kMaxMarkPoints));
    }
    for (const Vec3& p_W : mark.points_W) CheckPoint(mark, p_W);
  }
}

std::string MakeMarkName(const std::vector<Mark>& marks, MarkKind kind) {
  return MakeUnusedName(marks, std::string(ToString(kind)));
}

void AppendMarks(std::vector<Mark>& marks, std::vector<Mark> added) {
  for (Mark& mark : added) {
    mark.name = MakeUnusedName(marks, mark.name);
    marks.push_back(std::move(mark));
  }
}

void CheckMarksNear(const std::vector<Mark>& marks, const Box3& bone_W) {
  for (const Mark& mark : marks) {
    double farthest_mm = 0;
    for (const Vec3& p_W : mark.points_W) {
      farthest_mm = std::max(farthest_mm, glm::length(p_W - glm::clamp(p_W, bone_W.lower, bone_W.upper)));
    }
    if (farthest_mm <= kMarkSurroundings_mm) continue;
    throw Error(
        fmt::format("the mark '{}' lies up to {:.0f} mm outside of the bone; the file probably belongs to another scan "
                    "or states another coordinate frame",
                    mark.name, farthest_mm));
  }
}

void AddPoint(Mark& mark, const Vec3& p_W) {
  CheckRoom(mark);
  CheckPoint(mark, p_W);
  mark.points_W.push_back(p_W);
}

std::size_t InsertPoint(Mark& mark, const Vec3& p_W) {
  CheckRoom(mark);
  CheckPoint(mark, p_W);
  std::size_t best = mark.points_W.size();
  if (mark.points_W.size() > 1) {
    std::vector<std::size_t> first;
    const std::vector<Vec3> line = CalcCurve(mark.points_W, &first);
    double best_mm = 0;
    for (std::size_t span = 0; span < first.size(); ++span) {
      const std::size_t end = span + 1 < first.size() ? first[span + 1] : line.size() - 1;
      for (std::size_t i = first[span]; i < end; ++i) {
        const double distance_mm = CalcSegmentDistance(p_W, line[i], line[i + 1]);
        if (best < mark.points_W.size() && distance_mm >= best_mm) continue;
        best_mm = distance_mm;
        best = span + 1;
      }
    }
  }
  mark.points_W.insert(mark.points_W.begin() + static_cast<std::ptrdiff_t>(best), p_W);
  return best;
}

void MovePoint(Mark& mark, std::size_t i, const Vec3& p_W) {
  CheckIndex(mark, i);
  CheckPoint(mark, p_W);
  mark.points_W[i] = p_W;
}

void RemovePoint(Mark& mark, std::size_t i) {
  CheckIndex(mark, i);
  mark.points_W.erase(mark.points_W.begin() + static_cast<std::ptrdiff_t>(i));
}

std::vector<Vec3> CalcCurve(const std::vector<Vec3>& points_W, std::vector<std::size_t>* first_of_span) {
  std::vector<Vec3> p;
  std::vector<std::size_t> number;  // of the point in `p`, for each point of the mark
  for (const Vec3& point : points_W) {
    if (p.empty() || glm::length(point - p.back()) > kSamePlace_mm) p.push_back(point);
    number.push_back(p.size() - 1);
  }
  std::vector<Vec3> line;
  std::vector<std::size_t> passes;  // index of the line at each point of `p`
  if (!p.empty()) {
    line.push_back(p.front());
    passes.push_back(0);
  }
  for (std::size_t i = 0; i + 1 < p.size(); ++i) {
    const Vec3 before = i > 0 ? p[i - 1] : 2.0 * p[0] - p[1];
    const Vec3 after = i + 2 < p.size() ? p[i + 2] : 2.0 * p[i + 1] - p[i];
    if (p.size() == 2) {
      line.push_back(p[1]);
    } else {
      Flatten(SplineSpan(before, p[i], p[i + 1], after), 0, p[i], 1, p[i + 1], 0, line);
    }
    passes.push_back(line.size() - 1);
  }
  if (first_of_span != nullptr) {
    first_of_span->clear();
    for (std::size_t i = 0; i + 1 < points_W.size(); ++i) first_of_span->push_back(passes[number[i]]);
  }
  return line;
}

}  // namespace kerf
