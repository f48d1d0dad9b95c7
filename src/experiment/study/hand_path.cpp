#include "experiment/study/hand_path.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

#include "free_form_csv.h"
#include "session/scene/path_csv.h"

namespace kerf {
namespace {

/// Interpolates from b to c over a step `dt` with a cubic Hermite polynomial. Its slope at each end is the mean slope
/// between the two neighbours of that end.
template <typename T>
T Cubic(const T& a, const T& b, const T& c, const T& d, double before, double dt, double after, double fraction) {
  const T slope_b = (c - a) * (dt / (before + dt));
  const T slope_c = (d - b) * (dt / (dt + after));
  const double u = fraction, u2 = u * u, u3 = u2 * u;
  return b * (2 * u3 - 3 * u2 + 1) + slope_b * (u3 - 2 * u2 + u) + c * (3 * u2 - 2 * u3) + slope_c * (u3 - u2);
}

}  // namespace

HandPath::HandPath(const std::string& csv, const std::string& file) : rows_(ParsePathCsv(csv, file)) {
  const double start_s = rows_.front().time_s;
  for (TimedPose& row : rows_) row.time_s -= start_s;
  // q and -q are the same rotation. Each row gets the sign that is nearer to the row before it, so that a cubic can
  // connect them.
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    Quat& q = rows_[i].X_WT.R_AB;
    if (glm::dot(rows_[i - 1].X_WT.R_AB, q) < 0) q = -q;
  }
}

Pose HandPath::CalcPose(double t_s) const {
  if (!(t_s > 0)) return rows_.front().X_WT;
  if (t_s >= rows_.back().time_s) return rows_.back().X_WT;
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), t_s, [](double t, const TimedPose& row) { return t < row.time_s; });
  const auto c = static_cast<std::size_t>(after - rows_.begin());
  const std::size_t b = c - 1;
  // At the ends, the point itself replaces the missing neighbour.
  const std::size_t a = b > 0 ? b - 1 : b;
  const std::size_t d = std::min(c + 1, rows_.size() - 1);
  const double dt = rows_[c].time_s - rows_[b].time_s;
  const double before = b > 0 ? rows_[b].time_s - rows_[a].time_s : dt;
  const double later = d > c ? rows_[d].time_s - rows_[c].time_s : dt;
  const double fraction = (t_s - rows_[b].time_s) / dt;
  const auto place = [&](std::size_t i) -> const Pose& { return rows_[i].X_WT; };
  return {
      glm::normalize(Cubic(place(a).R_AB, place(b).R_AB, place(c).R_AB, place(d).R_AB, before, dt, later, fraction)),
      Cubic(place(a).p_AB, place(b).p_AB, place(c).p_AB, place(d).p_AB, before, dt, later, fraction)};
}

HandPath FreeFormHandPath() {
  return {kFreeFormHandCsv, "volumes/free_form_hand.csv"};
}
HandPath FreeFormToolPath() {
  return {kFreeFormToolCsv, "volumes/free_form_tool.csv"};
}

}  // namespace kerf
