#include "bone/material/atlas.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/core/symmetric_eigen.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kMinPoints = 100;

/// Returns the quantile `q` (0 to 1) of the values. Reorders them.
double CalcQuantile(std::vector<double>& values, double q) {
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// Returns the eigenvector of the largest eigenvalue of a symmetric 3x3 matrix.
Vec3 CalcMainAxis(const std::array<std::array<double, 3>, 3>& a) {
  const SymmetricEigen eigen = CalcSymmetricEigen(a);
  const auto largest = std::max_element(eigen.values.begin(), eigen.values.end());
  return eigen.vectors[static_cast<std::size_t>(largest - eigen.values.begin())];
}

/// Fills bins without a value from their neighbours, then smooths all values.
template <std::size_t n>
void FillAndSmooth(std::array<std::optional<double>, n>& bins, int passes, std::array<double, n>* out) {
  std::array<double, n>& y = *out;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < n; ++i) {
    if (!bins[i]) continue;
    for (std::size_t j = last ? *last + 1 : 0; j < i; ++j) {
      const double t = last ? static_cast<double>(j - *last) / static_cast<double>(i - *last) : 1;
      y[j] = last ? *bins[*last] + t * (*bins[i] - *bins[*last]) : *bins[i];
    }
    y[i] = *bins[i];
    last = i;
  }
  for (std::size_t j = last ? *last + 1 : 0; j < n; ++j) y[j] = last ? *bins[*last] : 0;
  for (int pass = 0; pass < passes; ++pass) {
    std::array<double, n> z = y;
    // At the symphysis the arch continues as its own mirror image.
    for (std::size_t i = 0; i < n; ++i) z[i] = 0.25 * (y[i == 0 ? 0 : i - 1] + 2 * y[i] + y[std::min(i + 1, n - 1)]);
    y = z;
  }
}

/// Interpolates linearly between bin centres; constant beyond the outermost ones.
template <std::size_t n>
double Interpolate(const std::array<double, n>& y, double bin) {
  const double t = std::clamp(bin - 0.5, 0.0, static_cast<double>(n - 1));
  const auto i = std::min(static_cast<std::size_t>(t), n - 2);
  return y[i] + (t - static_cast<double>(i)) * (y[i + 1] - y[i]);
}

double CalcAngle(const Vec3& p_M) {
  return std::atan2(std::abs(p_M.x), p_M.y);
}

}  // namespace

MandibleAtlas::MandibleAtlas(const std::vector<Vec3>& points_W, const Vec3& up_W) {
  if (points_W.size() < kMinPoints)
    throw Error("too few points of bone to find the regions of a mandible (fewer than 100)");
  FindAxes(points_W, up_W);
  std::vector<Vec3> points_M;
  points_M.reserve(points_W.size());
  for (const Vec3& p : points_W) points_M.push_back(ToMandible(p));
  for (int side = 0; side < 2; ++side) FindArch(points_M, side);
  FindRamus(points_M);
}

Vec3 MandibleAtlas::ToMandible(const Vec3& p_W) const {
  const Vec3 d = p_W - origin_W_;
  return {glm::dot(d, x_W_), glm::dot(d, f_W_), glm::dot(d, h_W_)};
}

void MandibleAtlas::FindAxes(const std::vector<Vec3>& points_W, const Vec3& up_W) {
  // The left-right axis: because of the two rami, the spread is by far the largest in this direction.
  Vec3 mean{0};
  for (const Vec3& p : points_W) mean += p;
  mean /= static_cast<double>(points_W.size());
  std::array<std::array<double, 3>, 3> spread{};
  for (const Vec3& p : points_W) {
    const Vec3 d = p - mean;
    const std::array<double, 3> e = {d.x, d.y, d.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) spread[i][j] += e[i] * e[j];
    }
  }
  x_W_ = CalcMainAxis(spread);
  if (x_W_.x < 0) x_W_ = -x_W_;
  if (!(std::abs(x_W_.x) > 0.5)) {
    throw Error("cannot find the left-right axis of this mandible: its widest direction is not the patient's x axis");
  }

  std::vector<double> x;
  for (const Vec3& p : points_W) x.push_back(glm::dot(p - mean, x_W_));
  const double lowest_x = CalcQuantile(x, 0.005);
  const double highest_x = CalcQuantile(x, 0.995);
  origin_W_ = mean + 0.5 * (lowest_x + highest_x) * x_W_;

  // The upward axis: the bone rests with its chin and its angles on the base plane. In the side view this plane is the
  // line through the lowest point of the front third and that of the back half. It is recomputed until it no longer
  // changes.
  h_W_ = glm::normalize(up_W - glm::dot(up_W, x_W_) * x_W_);
  double lowest = 0;
  double back = 0;
  double front = 0;
  for (int round = 0; round < 12; ++round) {
    f_W_ = glm::cross(x_W_, h_W_);
    std::vector<double> f;
    for (const Vec3& p : points_W) f.push_back(glm::dot(p - origin_W_, f_W_));
    back = CalcQuantile(f, 0.002);
    front = CalcQuantile(f, 0.998);
    Vec3 chin{0};
    Vec3 angle{0};
    double chin_h = 1e300;
    double angle_h = 1e300;
    for (const Vec3& p : points_W) {
      const double fraction = (glm::dot(p - origin_W_, f_W_) - back) / (front - back);
      const double h = glm::dot(p - origin_W_, h_W_);
      if (fraction > 0.67 && h < chin_h) chin_h = h, chin = p;
      if (fraction < 0.5 && h < angle_h) angle_h = h, angle = p;
    }
    if (!(front - back > 10) || chin_h > 1e200 || angle_h > 1e200) {
      throw Error("the points of bone do not have the extent of a mandible");
    }
    lowest = std::min(chin_h, angle_h);
    const double slope = (chin_h - angle_h) / std::max(1.0, glm::dot(chin - angle, f_W_));
    h_W_ = glm::normalize(h_W_ - std::clamp(slope, -0.5, 0.5) * f_W_);
    if (std::abs(slope) < 1e-4) break;
  }
  f_W_ = glm::cross(x_W_, h_W_);

  // The angle is measured around a point in the midline a little in front of the condyles.
  origin_W_ += (back + 0.18 * (front - back)) * f_W_ + lowest * h_W_;
  std::vector<double> h;
  for (const Vec3& p : points_W) h.push_back(glm::dot(p - origin_W_, h_W_));
  height_mm_ = CalcQuantile(h, 0.9995);
  if (!(height_mm_ > 5 && highest_x - lowest_x > 10))
    throw Error("the points of bone do not have the extent of a mandible");
}

void MandibleAtlas::FindArch(const std::vector<Vec3>& points_M, int side) {
  Side& arch = sides_[static_cast<std::size_t>(side)];
  const double bin_width = kMaxAngle / kAngles;
  const double bin_height = 1.05 * height_mm_ / kHeights;
  struct Sum {
    double sum = 0;
    int count = 0;
  };
  std::array<Sum, kAngles> radius_sum{};
  std::array<std::array<Sum, kHeights>, kAngles> middle_sum{};
  std::array<std::vector<double>, kAngles> heights;
  std::vector<double> back_angles;
  for (const Vec3& p : points_M) {
    // The midline belongs to both sides.
    if ((side == 1 ? p.x : -p.x) < -2) continue;
    const double angle = CalcAngle(p);
    const double radius = std::hypot(p.x, p.y);
    const auto i = static_cast<std::size_t>(std::clamp(angle / bin_width, 0.0, kAngles - 1.0));
    const auto j = static_cast<std::size_t>(std::clamp(p.z / bin_height, 0.0, kHeights - 1.0));
    ++middle_sum[i][j].count;
    middle_sum[i][j].sum += radius;
    heights[i].push_back(p.z);
    if (p.z < 0.42 * height_mm_) {
      ++radius_sum[i].count;
      radius_sum[i].sum += radius;
      back_angles.push_back(angle);
    }
  }
  if (back_angles.size() < kMinPoints / 10)
    throw Error("one half of the mandible has too few points to find its regions");

  std::array<std::optional<double>, kAngles> bins;
  for (std::size_t i = 0; i < kAngles; ++i) {
    bins[i] = radius_sum[i].count > 0 ? std::optional(radius_sum[i].sum / radius_sum[i].count) : std::nullopt;
  }
  std::array<double, kAngles>& radius = arch.radius;
  FillAndSmooth(bins, 3, &radius);
  for (int i = 0; i < kAngles; ++i) {
    const double angle = (i + 0.5) * kMaxAngle / kAngles;
    const double r = radius[static_cast<std::size_t>(i)];
    arch.point[static_cast<std::size_t>(i)] = {r * std::sin(angle), r * std::cos(angle)};
  }

  double length = 0;
  for (std::size_t i = 0; i < kAngles; ++i) {
    const double slope = i == 0 ? 0 : (radius[i] - radius[i - 1]) / bin_width;
    const double step = std::hypot(radius[i], slope) * bin_width;
    arch.along[i] = length + 0.5 * step;
    length += step;
  }
  const double back_angle = CalcQuantile(back_angles, 0.995);
  const double whole = Interpolate(arch.along, back_angle / bin_width);
  for (double& s : arch.along) s /= whole;

  // Crest and lower border. The coronoid overhangs the back of the body: there the crest is assumed to continue as in
  // front of the coronoid.
  std::vector<double> front_crests;
  std::array<std::optional<double>, kAngles> crest;
  std::array<std::optional<double>, kAngles> base;
  for (std::size_t i = 0; i < kAngles; ++i) {
    if (heights[i].size() < 3) continue;
    base[i] = CalcQuantile(heights[i], 0.0);
    if (arch.along[i] > 0.62) continue;
    crest[i] = CalcQuantile(heights[i], 1.0);
    if (arch.along[i] > 0.1 && arch.along[i] < 0.45) front_crests.push_back(*crest[i]);
  }
  const double usual_crest = front_crests.empty() ? 0.5 * height_mm_ : CalcQuantile(front_crests, 0.5);
  for (auto& value : crest) {
    if (value && *value > 1.2 * usual_crest) value.reset();
  }
  if (std::none_of(crest.begin(), crest.end(), [](const auto& v) { return v.has_value(); })) crest[0] = usual_crest;
  FillAndSmooth(crest, 2, &arch.crest);
  FillAndSmooth(base, 2, &arch.base);

  // Middle of the thickness by angle and height; empty cells get it from cells at the same angle or, if these are empty
  // too, from the arch.
  for (std::size_t i = 0; i < kAngles; ++i) {
    std::array<std::optional<double>, kHeights> column;
    bool any = false;
    for (std::size_t j = 0; j < kHeights; ++j) {
      if (middle_sum[i][j].count == 0) continue;
      column[j] = middle_sum[i][j].sum / middle_sum[i][j].count;
      any = true;
    }
    if (!any) column[0] = radius[i];
    FillAndSmooth(column, 1, &arch.middle[i]);
  }
}

void MandibleAtlas::FindRamus(const std::vector<Vec3>& points_M) {
  // Finds the middle between the front and back edges in slices above the body and below the notch, then fits a line
  // through these points.
  constexpr int kSlices = 8;
  std::array<double, kSlices> front{};
  std::array<double, kSlices> back{};
  front.fill(-1e300);
  back.fill(1e300);
  const double lower = 0.45;
  const double upper = 0.72;
  for (const Vec3& p : points_M) {
    const double t = (p.z / height_mm_ - lower) / (upper - lower) * kSlices;
    // Teeth and the front of the body also reach this height.
    if (t < 0 || t >= kSlices || CalcCoordinates(p.x * x_W_ + p.y * f_W_ + p.z * h_W_ + origin_W_).along < 0.55)
      continue;
    const auto i = static_cast<std::size_t>(t);
    front[i] = std::max(front[i], p.y);
    back[i] = std::min(back[i], p.y);
  }
  double n = 0, sum_h = 0, sum_f = 0, sum_hh = 0, sum_hf = 0;
  for (std::size_t i = 0; i < kSlices; ++i) {
    if (front[i] < back[i]) continue;
    const double h = (lower + (static_cast<double>(i) + 0.5) / kSlices * (upper - lower)) * height_mm_;
    const double f = 0.5 * (front[i] + back[i]);
    n += 1, sum_h += h, sum_f += f, sum_hh += h * h, sum_hf += h * f;
  }
  if (n < 2) return;
  const double determinant = n * sum_hh - sum_h * sum_h;
  ramus_lean_ = std::clamp((n * sum_hf - sum_h * sum_f) / determinant, -1.0, 0.3);
  ramus_middle_mm_ = (sum_f - ramus_lean_ * sum_h) / n;

  // A condyle may be lower than its coronoid, and lower on one side than on the other. The lower of the two tops is
  // used, so that both condyles have a head.
  std::array<std::vector<double>, 2> behind;
  for (const Vec3& p : points_M) {
    const double rise = p.z / height_mm_;
    if (rise > 0.6 && p.y < ramus_middle_mm_ + ramus_lean_ * p.z) behind[p.x >= 0 ? 1 : 0].push_back(rise);
  }
  condyle_top_ = 1;
  for (std::vector<double>& rises : behind) {
    if (!rises.empty()) condyle_top_ = std::min(condyle_top_, CalcQuantile(rises, 0.998));
  }
}

double MandibleAtlas::FindBin(const Side& arch, const Vec3& p_M, double angle) {
  // Finds the nearest point of the arch, not the one on the ray from the axis, so that a cut across the body stays in
  // its column. Searches only near the ray, because the two halves of a horseshoe face each other.
  constexpr int kReach = 9;
  const int at_ray = static_cast<int>(angle / kMaxAngle * kAngles);
  const double x = std::abs(p_M.x);
  const auto point = [&arch](int i) { return arch.point[static_cast<std::size_t>(i)]; };
  const int first = std::clamp(at_ray - kReach, 0, kAngles - 2);
  const int last = std::clamp(at_ray + kReach, 1, kAngles - 1);
  double nearest2 = 1e300;
  double bin = first;
  auto [x0, y0] = point(first);
  for (int i = first; i < last; ++i) {
    const auto [x1, y1] = point(i + 1);
    const double ex = x1 - x0;
    const double ey = y1 - y0;
    const double length2 = std::max(ex * ex + ey * ey, 1e-12);
    const double t = std::clamp(((x - x0) * ex + (p_M.y - y0) * ey) / length2, 0.0, 1.0);
    const double dx = x - x0 - t * ex;
    const double dy = p_M.y - y0 - t * ey;
    if (dx * dx + dy * dy < nearest2) {
      nearest2 = dx * dx + dy * dy;
      bin = i + t;
    }
    x0 = x1;
    y0 = y1;
  }
  return bin + 0.5;  // the centre of the first bin is at 0.5
}

MandibleCoordinates MandibleAtlas::CalcCoordinates(const Vec3& p_W) const {
  const Vec3 p_M = ToMandible(p_W);
  MandibleCoordinates c;
  c.side = p_M.x >= 0 ? 1 : 0;
  const Side& arch = sides_[static_cast<std::size_t>(c.side)];
  const double angle = CalcAngle(p_M);
  const double at_arch = FindBin(arch, p_M, angle);
  c.along = Interpolate(arch.along, at_arch);
  const double crest = Interpolate(arch.crest, at_arch);
  const double base = Interpolate(arch.base, at_arch);
  c.depth = (crest - p_M.z) / std::max(1.0, crest - base);
  c.rise = p_M.z / height_mm_;
  c.forward_mm = p_M.y - (ramus_middle_mm_ + ramus_lean_ * p_M.z);
  const double height_bin = p_M.z / (1.05 * height_mm_) * kHeights;
  const double t = std::clamp(angle / kMaxAngle * kAngles - 0.5, 0.0, kAngles - 1.0);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(t), kAngles - 2);
  const double lower = Interpolate(arch.middle[i], height_bin);
  const double upper = Interpolate(arch.middle[i + 1], height_bin);
  c.facial_mm = std::sqrt(p_M.x * p_M.x + p_M.y * p_M.y) - (lower + (t - static_cast<double>(i)) * (upper - lower));
  return c;
}

// The condylar process begins at the rise kNeckRise. Its head has the height kHeadHeight (7 mm), or is the upper half
// of the process if that is less. Both constants are fractions of the highest point's height.
constexpr double kNeckRise = 0.72;
constexpr double kHeadHeight = 0.12;

int MandibleAtlas::RegionAt(const Vec3& p_W) const {
  const MandibleCoordinates c = CalcCoordinates(p_W);
  const int lingual = c.facial_mm < 0 ? 1 : 0;
  // The ramus is above the back of the body: the coronoid leans forward over the molars.
  const bool body = c.along < 0.42 || (c.along < kMolarColumn[1] && c.depth > -0.35);
  if (body) {
    if (c.along >= kMolarColumn[0]) {
      return c.depth < kBodyBands[1] ? 24 : c.depth < kBodyBands[2] ? 21 : c.depth < kBodyBands[3] ? 13 : 6;
    }
    const bool symphysis = c.along < 0.18;
    if (c.depth < kBodyBands[1]) return (symphysis ? 17 : 19) + lingual;
    if (c.depth < kBodyBands[3]) return (symphysis ? 8 : 10) + lingual;
    return (symphysis ? 1 : 3) + lingual;
  }
  const bool front = c.forward_mm > 0;
  if (c.rise < 0.20) return lingual ? 7 : 5;
  if (c.rise < 0.40) return lingual ? 14 : 12;
  if (c.rise < 0.60) return (front ? 22 : 15) + lingual;
  if (c.rise < kNeckRise) return 25 + lingual;
  if (front) return 27 + lingual;
  const double head = condyle_top_ - std::min(kHeadHeight, 0.5 * (condyle_top_ - kNeckRise));
  return c.rise < head ? 29 + lingual : 31;
}

}  // namespace kerf
