// The volume that the exact cut took, by lines across the disc.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "accuracy/errors.h"

namespace kerf {
namespace {

constexpr int kCoarse = 96;             // lines along each axis, to find where there is a cut
constexpr double kLines = 200000;       // over what is found
constexpr double kLeastStep_mm = 2e-3;  // of the walk along a line; crossings are found between steps
constexpr double kMargin_mm = 0.01;

/// Lines along the disc's axis as it stands at the start.
class Lines {
 public:
  Lines(const ExactBone& exact, const Pose& X, double lower_mm, double upper_mm)
      : exact_(exact), X_(X), lower_mm_(lower_mm), upper_mm_(upper_mm) {}

  /// Length of the line through (u, v) that was swept and had been bone, mm.
  double Measure(double u, double v) const {
    double length = 0;
    double z = lower_mm_;
    double value = Value(u, v, z);
    while (z < upper_mm_) {
      // No nearer than this is a wall, nor the bone's own surface; its function may rise twice as fast as the distance.
      const double step = std::max(0.5 * std::abs(value), kLeastStep_mm);
      const double next_z = std::min(z + step, upper_mm_);
      const double next = Value(u, v, next_z);
      if (value < 0 && next < 0) {
        length += next_z - z;
      } else if (value < 0 || next < 0) {
        length += (next_z - z) * (value < 0 ? value : next) / (value < 0 ? value - next : next - value);
      }
      z = next_z;
      value = next;
    }
    return length;
  }

 private:
  /// Below 0 where bone was taken.
  double Value(double u, double v, double z) const {
    const Vec3 p_W = X_.Point({u, v, z});
    const double uncut = exact_.solid().distance_mm(p_W);
    return uncut > 0 ? uncut : std::max(uncut, -exact_.Distance(p_W));
  }

  const ExactBone& exact_;
  Pose X_;
  double lower_mm_, upper_mm_;
};

}  // namespace

double CalcExactRemoved_mm3(const ExactBone& exact, std::span<const ReferenceTick> ticks, const DiscSaw& saw) {
  if (exact.swept_bounds().empty() || ticks.empty()) return 0;
  // Askew, so that no straight edge of the bone falls between lines all at once.
  Pose X = ticks.front().X_WT;
  X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(0.37, Vec3(0, 0, 1)));
  // What the disc can have met, seen from where it stood first.
  Vec3 lower(1e9), upper(-1e9);
  for (const ReferenceTick& tick : ticks) {
    const Vec3 p = X.InversePoint(tick.X_WT.p_AB);
    const Vec3 n = X.InverseVector(tick.X_WT.Vector({0, 0, 1}));
    const double r = saw.radius_mm();
    const double tilt = r * std::hypot(n.x, n.y) + 0.5 * saw.thickness_mm + kMargin_mm;
    lower = glm::min(lower, p - Vec3(r, r, tilt));
    upper = glm::max(upper, p + Vec3(r, r, tilt));
  }
  const Lines lines(exact, X, lower.z, upper.z);
  Box3 found;
  const Vec3 cell = (upper - lower) / static_cast<double>(kCoarse);
  for (int i = 0; i < kCoarse; ++i) {
    for (int j = 0; j < kCoarse; ++j) {
      const Vec3 p = lower + cell * Vec3(i + 0.5, j + 0.5, 0);
      if (lines.Measure(p.x, p.y) > 0) found.Include({p.x, p.y, 0});
    }
  }
  if (found.empty()) return 0;
  // A round edge may reach on between two lines: as far as the chord of an arc one cell high.
  const double beyond = std::max(cell.x, cell.y) + std::sqrt(2 * saw.radius_mm() * std::max(cell.x, cell.y));
  lower = glm::max(lower, found.lower - beyond);
  upper = glm::min(upper, found.upper + beyond);
  const Vec3 size = upper - lower;
  const double apart = std::sqrt(size.x * size.y / kLines);
  const int columns = static_cast<int>(std::ceil(size.x / apart));
  const int rows = static_cast<int>(std::ceil(size.y / apart));
  const double dx = size.x / columns, dy = size.y / rows;
  double sum = 0;
  for (int i = 0; i < columns; ++i) {
    // Each column begins elsewhere, likewise.
    const double offset = std::fmod(0.61803398875 * i, 1.0);
    for (int j = 0; j < rows; ++j) sum += lines.Measure(lower.x + (i + 0.5) * dx, lower.y + (j + offset) * dy);
  }
  return sum * dx * dy;
}

}  // namespace kerf
