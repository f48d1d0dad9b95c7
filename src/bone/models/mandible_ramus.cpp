#include "bone/models/mandible_ramus.h"

#include <array>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <optional>

#include "bone/models/recent_values.h"

namespace kerf {
namespace {

// Dimensions of the default mandible, mm, for which the outline is defined.
constexpr double kWidth = 31.3;
constexpr double kNotch = 44.8;
constexpr double kCoronoid = 59;
constexpr double kCondyle = 54;

/// Outline as (distance from the back edge, height above the base line), mm, of the default ramus. It runs from the
/// angle up the back edge, over the condyle's neck, the notch and the coronoid, down the front edge to the oblique
/// line, and back along the lower border.
constexpr std::array<std::array<double, 2>, 33> kOutline = {{
    {1.6, 2.2},   {0.3, 5.5},   {0.0, 11.0},  {0.7, 18.0},  {1.2, 25.0},  {1.1, 31.5},  {0.4, 37.0},
    {-0.2, 42.5}, {0.8, 47.2},  {4.0, 50.0},  {7.3, 49.6},  {8.4, 47.3},  {9.3, 45.9},  {11.4, 44.95},
    {14.0, 44.8}, {17.5, 45.5}, {21.5, 47.6}, {25.6, 51.6}, {28.8, 56.2}, {31.2, 58.9}, {33.3, 57.6},
    {34.3, 53.0}, {33.7, 47.0}, {32.4, 41.5}, {31.4, 36.0}, {31.2, 30.5}, {32.4, 25.0}, {35.6, 19.0},
    {37.8, 14.5}, {37.0, 9.5},  {33.0, 4.6},  {26.0, 1.6},  {11.0, 0.7},
}};

/// Returns the closed Catmull-Rom curve through the points, as a polygon.
std::vector<Vec2> MakePolygon(const std::vector<Vec2>& points) {
  std::vector<Vec2> polygon;
  const std::size_t n = points.size();
  constexpr int kPieces = 12;
  for (std::size_t i = 0; i < n; ++i) {
    // Centripetal parametrisation, so that unequal spacing causes no loops.
    const Vec2 p0 = points[(i + n - 1) % n], p1 = points[i], p2 = points[(i + 1) % n], p3 = points[(i + 2) % n];
    const double t1 = std::sqrt(glm::distance(p0, p1));
    const double t2 = t1 + std::sqrt(glm::distance(p1, p2));
    const double t3 = t2 + std::sqrt(glm::distance(p2, p3));
    for (int k = 0; k < kPieces; ++k) {
      const double t = t1 + (t2 - t1) * k / kPieces;
      const Vec2 a1 = (t1 - t) / t1 * p0 + t / t1 * p1;
      const Vec2 a2 = (t2 - t) / (t2 - t1) * p1 + (t - t1) / (t2 - t1) * p2;
      const Vec2 a3 = (t3 - t) / (t3 - t2) * p2 + (t - t2) / (t3 - t2) * p3;
      const Vec2 b1 = (t2 - t) / t2 * a1 + t / t2 * a2;
      const Vec2 b2 = (t3 - t) / (t3 - t1) * a2 + (t - t1) / (t3 - t1) * a3;
      polygon.push_back((t2 - t) / (t2 - t1) * b1 + (t - t1) / (t2 - t1) * b2);
    }
  }
  return polygon;
}

double CalcPolygonDistance(const std::vector<Vec2>& polygon, const Vec2& p) {
  double best = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 e = polygon[i] - polygon[j];
    const Vec2 d = p - polygon[j];
    const double t = std::clamp(glm::dot(d, e) / glm::dot(e, e), 0.0, 1.0);
    const Vec2 r = d - t * e;
    best = std::min(best, glm::dot(r, r));
    if ((polygon[i].y > p.y) != (polygon[j].y > p.y) && p.x < polygon[j].x + e.x * (p.y - polygon[j].y) / e.y)
      inside = !inside;
  }
  return (inside ? -1 : 1) * std::sqrt(best);
}

}  // namespace

MandibleRamus::MandibleRamus(const MandibleLayout& layout) : layout_(&layout), id_(MakeFunctionId()) {
  const MandibleParams& p = layout.params;
  std::vector<Vec2> points;
  for (const auto& [u, height] : kOutline) {
    double h = height * p.ramus_height_mm / kNotch;
    if (height > kNotch) {
      // Above the notch, the coronoid in front and the neck behind are each scaled to their own height.
      const double top = u > 14 ? (p.coronoid_height_mm - p.ramus_height_mm) / (kCoronoid - kNotch)
                                : (p.condyle_height_mm - p.ramus_height_mm) / (kCondyle - kNotch);
      h = p.ramus_height_mm + (height - kNotch) * top;
    }
    const double u_mm = u * p.ramus_width_mm / kWidth;
    points.emplace_back(u_mm, layout.RamusV(u_mm, h));
  }
  v_notch_ = layout.RamusV(14, p.ramus_height_mm);
  const std::vector<Vec2> polygon = MakePolygon(points);
  for (const Vec2& uv : polygon) {
    const Vec2 yz = layout.FromRamus(uv);
    const double x = layout.RamusX(uv.x, uv.y);
    const double t = p.ramus_thickness_mm;  // more than half the thickness everywhere
    box_.Include({x - t, yz.x, yz.y});
    box_.Include({x + t, yz.x, yz.y});
  }
  count_u_ = static_cast<int>(90 / step_);
  count_v_ = static_cast<int>(140 / step_);
  outline_.resize(static_cast<std::size_t>(count_u_) * static_cast<std::size_t>(count_v_));
  for (int j = 0; j < count_v_; ++j) {
    for (int i = 0; i < count_u_; ++i) {
      const auto n = static_cast<std::size_t>(j) * static_cast<std::size_t>(count_u_) + static_cast<std::size_t>(i);
      outline_[n] = static_cast<float>(CalcPolygonDistance(polygon, origin_ + step_ * Vec2(i, j)));
    }
  }

  // The head: its long axis points outward and slightly forward; the two axes meet in front of the foramen magnum.
  const double turn = glm::radians(18.0);
  condyle_axis_ = glm::normalize(Vec3{std::cos(turn), -std::sin(turn), 0.10});
  condyle_up_ = glm::normalize(Vec3{0, layout.v_yz.x, layout.v_yz.y} -
                               glm::dot(Vec3{0, layout.v_yz.x, layout.v_yz.y}, condyle_axis_) * condyle_axis_);
  condyle_front_ = glm::cross(condyle_up_, condyle_axis_);
  condyle_radii_ = {0.5 * p.condyle_width_mm, 0.5 * p.condyle_depth_mm, 5.2};
  // The centre is chosen so that the outer pole and the top have the prescribed positions.
  const auto reach = [&](const Vec3& direction) {
    const Vec3 local{glm::dot(direction, condyle_axis_), glm::dot(direction, condyle_front_),
                     glm::dot(direction, condyle_up_)};
    return glm::length(local * condyle_radii_);
  };
  const double u = 2.6 * p.ramus_width_mm / kWidth;
  const Vec3 up{0, -std::sin(layout.base_slope), std::cos(layout.base_slope)};  // perpendicular to the base line
  const double v = layout.RamusV(u, p.condyle_height_mm - reach(up));
  const Vec2 yz = layout.FromRamus({u, v});
  condyle_ = {0.5 * p.bicondylar_mm - reach({1, 0, 0}), yz.x, yz.y};
  const Vec2 low = layout.FromRamus({4.2 * p.ramus_width_mm / kWidth, v - 15});
  const Vec3 below{layout.RamusX(4, v - 15), low.x, low.y};
  // The neck widens towards both poles.
  const double pole = condyle_radii_.x - 4.2;
  const Vec3 head = condyle_ - 0.6 * condyle_up_ + 0.2 * condyle_front_;
  neck_[0] = RoundedCone<Vec3>(below, head - pole * condyle_axis_, 2.6, 3.0);
  neck_[1] = RoundedCone<Vec3>(below, head + 0.8 * pole * condyle_axis_, 2.6, 3.0);
  for (const Vec3& centre : {below, condyle_}) {
    const double r = centre == below ? 4.0 : condyle_radii_.x + 1;
    condyle_box_.Include(centre - r);
    condyle_box_.Include(centre + r);
  }
}

double MandibleRamus::OutlineDistance(const Vec2& uv) const {
  // Catmull-Rom interpolation in both directions, so that the grid causes no creases.
  const Vec2 g = (uv - origin_) / step_;
  const double x = std::clamp(g.x, 1.0, count_u_ - 2.001);
  const double y = std::clamp(g.y, 1.0, count_v_ - 2.001);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const auto weights = [](double t) -> std::array<double, 4> {
    return {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
            t * t * (-0.5 + 0.5 * t)};
  };
  const std::array<double, 4> wx = weights(x - i);
  const std::array<double, 4> wy = weights(y - j);
  double sum = 0;
  for (int b = 0; b < 4; ++b) {
    const float* row = &outline_[static_cast<std::size_t>(j - 1 + b) * static_cast<std::size_t>(count_u_) +
                                 static_cast<std::size_t>(i - 1)];
    sum +=
        wy[static_cast<std::size_t>(b)] * (wx[0] * static_cast<double>(row[0]) + wx[1] * static_cast<double>(row[1]) +
                                           wx[2] * static_cast<double>(row[2]) + wx[3] * static_cast<double>(row[3]));
  }
  // Outside the grid the distance only increases.
  return sum + glm::length(g - Vec2{x, y}) * step_;
}

double MandibleRamus::HalfThickness(const Vec2& uv) const {
  const MandibleParams& p = layout_->params;
  const double u = uv.x * kWidth / p.ramus_width_mm;
  const double v = uv.y;
  const double k = p.ramus_thickness_mm / 7.6;
  double t = 3.8;                                                  // behind the lingula
  t += 1.0 * SmoothStep(18, 30, u) * (1 - SmoothStep(20, 36, v));  // thicker at the front edge
  t -= 0.7 * (1 - SmoothStep(-6, 14, v + 0.4 * u));                // thinner towards the lower
                                                                   // border
  t -= 1.5 *
       SmoothStep(v_notch_ - 18, v_notch_, v + 0.25 * std::sqrt((u - 15) * (u - 15) + 16));  // thin below the notch
  t -= 0.5 * SmoothStep(v_notch_ - 8, v_notch_ + 6, v) * SmoothStep(16, 26, u);              // thinner at the coronoid
  t += 1.0 * SmoothStep(v_notch_ - 10, v_notch_ + 4, v) * (1 - SmoothStep(5, 10, u));        // thicker at the neck
  return k * t;
}

double MandibleRamus::PlateDistance(const Vec3& p_W, double limit) const {
  if (BoxDistance(box_, p_W) > limit) return limit + 1e-6;
  struct Thickness {
    double half;
    double middle_x;
  };
  struct Place {
    double in_plane = 0;
    std::optional<Thickness> thickness;  // where it was needed
  };
  thread_local RecentValues<Place> recent;
  const auto uv = [&] { return layout_->ToRamus(p_W.y, p_W.z); };
  Place& place = recent.Get(id_, {p_W.y, p_W.z}, [&] { return Place{OutlineDistance(uv()), {}}; });
  if (place.in_plane > std::min(limit, 15.0)) return place.in_plane;
  if (!place.thickness) place.thickness = {HalfThickness(uv()), layout_->RamusX(uv().x, uv().y)};
  const double t = place.thickness->half;
  const double across = (std::abs(p_W.x - place.thickness->middle_x) - t) * 0.97;  // correction: the middle surface is
                                                                                   // slightly inclined
  return RoundedIntersection(place.in_plane, across, 0.92 * t);
}

double MandibleRamus::CondyleDistance(const Vec3& p_W, double limit) const {
  if (BoxDistance(condyle_box_, p_W) > limit) return limit + 1e-6;
  const Vec3 d = p_W - condyle_;
  const Vec3 local{glm::dot(d, condyle_axis_), glm::dot(d, condyle_front_), glm::dot(d, condyle_up_)};
  const double head = EllipsoidDistance(local, condyle_radii_);
  return SmoothUnion(head, SmoothUnion(neck_[0].Distance(p_W), neck_[1].Distance(p_W), 3.0), 3.0);
}

double MandibleRamus::Distance(const Vec3& p_W, double limit) const {
  constexpr double kSeam = 3.5;
  const double plate = PlateDistance(p_W, limit + kSeam);
  return SmoothUnion(plate, CondyleDistance(p_W, std::min(plate, limit) + kSeam), kSeam);
}

}  // namespace kerf
