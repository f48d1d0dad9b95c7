#include "bone/models/mandible_teeth.h"

#include <array>
#include <glm/gtc/constants.hpp>

namespace kerf {
namespace {

struct Measures {
  int kind;             // 0 incisor, 1 canine, 2 premolar, 3 molar
  double width, depth;  // of the crown, mm
  double edge_z;        // z of edge or cusps, mm
  double neck_z;        // z of the base of the crown, mm
  double root;          // length, mm
  double tilt_deg;      // the top leans facially; about the arch's direction
};

// From the midline to the back.
constexpr std::array<Measures, 8> kTeeth = {{
    {0, 5.3, 5.9, 0.0, -9.3, 12.5, 8},
    {0, 5.9, 6.1, 0.0, -9.4, 13.5, 7},
    {1, 6.9, 7.6, 0.8, -9.6, 15.5, 3},
    {2, 7.0, 7.6, 0.2, -8.6, 14.0, -3},
    {2, 7.1, 8.0, 0.2, -8.0, 14.0, -7},
    {3, 11.2, 10.4, 0.9, -6.3, 13.5, -13},
    {3, 10.7, 10.2, 1.9, -5.2, 11.0, -17},
    {3, 10.5, 9.8, 2.9, -4.2, 10.5, -20},
}};

constexpr double kBeyond_mm = 1e-3;  // a distance of which only a limit is known is returned as this much more

/// Returns the height of a cone-shaped hill of height 1 with a round top; 0 beyond `reach`.
double Cusp(double t, double b, double t0, double b0, double reach) {
  const double r2 = ((t - t0) * (t - t0) + (b - b0) * (b - b0)) / (reach * reach);
  return r2 >= 1 ? 0 : (1 - r2) * (1 - r2);
}

}  // namespace

template <typename BoxOf>
TeethMask MandibleTeeth::FindBoxes(const Vec3& centre_W, double reach_mm, BoxOf&& box_of) const {
  TeethMask near = 0;
  for (std::size_t n = 0; n < teeth_.size(); ++n) {
    if (BoxDistance(box_of(teeth_[n]), centre_W) <= reach_mm) near |= static_cast<TeethMask>(1 << n);
  }
  return near;
}

MandibleTeeth::MandibleTeeth(const MandibleLayout& layout) {
  const int per_side = layout.params.teeth / 2;
  double s = 0;
  for (int n = 0; n < per_side; ++n) {
    const Measures& m = kTeeth[static_cast<std::size_t>(n)];
    const double middle = s + 0.5 * m.width;
    s += m.width;
    Tooth tooth;
    tooth.kind = static_cast<Kind>(m.kind);
    tooth.width = 0.995 * m.width;  // leaves a small gap between neighbours
    tooth.depth = m.depth;
    tooth.height = m.edge_z - m.neck_z;
    const Vec2 at = layout.dental.Point(middle);
    const Vec2 tangent = layout.dental.Tangent(middle);
    const Vec2 normal = layout.dental.Normal(middle);
    const double tilt = glm::radians(m.tilt_deg);
    const Vec3 out{normal.x, normal.y, 0};
    tooth.along = {tangent.x, tangent.y, 0};
    tooth.up = std::cos(tilt) * Vec3{0, 0, 1} + std::sin(tilt) * out;
    tooth.out = std::cos(tilt) * out - std::sin(tilt) * Vec3{0, 0, 1};
    // The edge, or the middle of the cusps, is on the arch; the neck is below it along the tooth's axis.
    tooth.neck = Vec3{at.x, at.y, m.edge_z} - tooth.height * tooth.up;
    const auto root_point = [&](double a, double b, double down) {
      return tooth.neck + a * tooth.along + b * tooth.out - down * tooth.up;
    };
    std::vector<std::pair<Vec3, double>> root_ends;
    const auto add_root = [&](const Vec3& neck, const Vec3& tip, double neck_radius, double tip_radius) {
      tooth.roots.emplace_back(neck, tip, neck_radius, tip_radius);
      root_ends.emplace_back(neck, neck_radius);
      root_ends.emplace_back(tip, tip_radius);
    };
    if (tooth.kind == Kind::kMolar) {
      for (const double side : {-1.0, 1.0}) {
        const double lean = n == 7 ? 1.2 : 0.6;  // roots curve to the back
        for (const double b : {-0.22, 0.22}) {
          add_root(root_point(side * 0.24 * m.width, b * m.depth, -0.6),
                   root_point(side * 0.27 * m.width + lean, 0.35 * b * m.depth, m.root - 1.2), 2.35, 1.2);
        }
      }
    } else {
      const double r = 0.34 * m.width;
      for (const double b : {-1.0, 1.0}) {
        const double spread = 0.5 * m.depth - r - 0.25;
        add_root(root_point(0, b * spread, -0.5), root_point(0.5, 0.35 * b * spread, m.root - 0.9), r, 0.9);
      }
    }
    for (int corner = 0; corner < 8; ++corner) {
      const double w = (corner & 1 ? 0.55 : -0.55) * tooth.width;
      const double d = (corner & 2 ? 0.6 : -0.6) * tooth.depth;
      tooth.box.Include(root_point(w, d, corner & 4 ? 2.5 : -tooth.height));
    }
    for (const auto& [tip, radius] : root_ends) {
      tooth.root_box.Include(tip - radius - 0.6);
      tooth.root_box.Include(tip + radius + 0.6);
    }
    tooth.box.Include(tooth.root_box.lower);
    tooth.box.Include(tooth.root_box.upper);
    box_.Include(tooth.box.lower);
    box_.Include(tooth.box.upper);
    root_box_.Include(tooth.root_box.lower);
    root_box_.Include(tooth.root_box.upper);
    teeth_.push_back(std::move(tooth));
  }
}

double MandibleTeeth::CrownDistance(const Tooth& tooth, const Vec3& local, double limit) {
  const double t = local.x;
  const double b = local.y;
  const double z = local.z;
  const double h = std::clamp(z / tooth.height, 0.0, 1.0);
  const double w = 0.5 * tooth.width;
  const double d = 0.5 * tooth.depth;
  double across = d;  // half depth at this height
  double middle = 0;  // offset of the middle of the depth
  double along = w;
  double top = tooth.height;
  double power = 2.4;
  double edge = 0.6;  // radius between side and top
  switch (tooth.kind) {
    case Kind::kIncisor:
      // Chisel shape: broad at the edge, deep at the neck, with a hollow lingual face.
      along = w * Mix(0.72, 1.0, SmoothStep(0, 0.8, h));
      across = Mix(d, 0.95, std::pow(h, 0.85));
      middle = 0.35 * (d - across) * h;
      power = Mix(2.2, 5.0, h * h);
      top -= 0.35 * (t / w) * (t / w);
      edge = 0.45;
      break;
    case Kind::kCanine:
      along = w * Mix(0.74, 1.0, SmoothStep(0, 0.65, h));
      power = Mix(2.3, 2.8, h);
      across = Mix(d, 1.7, std::pow(h, 1.3));
      middle = 0.45 * (d - across) * h;
      top -= 2.4 * std::sqrt((t / w) * (t / w) + 0.03);
      top -= 0.55 * std::max(0.0, -b);
      edge = 0.6;
      break;
    case Kind::kPremolar: {
      along = w * Mix(0.78, 1.0, SmoothStep(0, 0.6, h));
      power = Mix(2.4, 2.8, h);
      across = d * (0.86 + 0.14 * std::sin(glm::pi<double>() * std::min(1.0, 0.15 + 0.85 * h)) - 0.14 * h * h);
      const double hills = 2.3 * Cusp(t, b, 0, 0.42 * d, 1.05 * w) + 1.5 * Cusp(t, b, 0.1 * w, -0.5 * d, 0.9 * w) +
                           0.75 * (Cusp(t, b, w, 0, 0.55 * w) + Cusp(t, b, -w, 0, 0.55 * w));
      top += -2.4 + std::min(hills, 2.4);
      edge = 0.9;
      break;
    }
    case Kind::kMolar: {
      power = 3.2;
      along = w * Mix(0.84, 1.0, SmoothStep(0, 0.6, h));
      across = d * (0.88 + 0.12 * std::sin(glm::pi<double>() * std::min(1.0, 0.1 + 0.9 * h)) - 0.12 * h * h);
      const double reach = 0.62 * w;
      const double hills = 1.9 * (Cusp(t, b, -0.46 * w, 0.46 * d, reach) + Cusp(t, b, 0.30 * w, 0.50 * d, reach)) +
                           2.1 * (Cusp(t, b, -0.46 * w, -0.50 * d, reach) + Cusp(t, b, 0.42 * w, -0.50 * d, reach)) +
                           1.5 * Cusp(t, b, 0.80 * w, 0.18 * d, 0.45 * w) + 0.9 * Cusp(t, b, -0.95 * w, 0, 0.4 * w);
      top += -2.1 + std::min(hills, 2.3);
      edge = 1.0;
      break;
    }
  }
  // Superellipse around the axis, scaled to approximate a distance.
  const double x = std::abs(t) / along;
  const double y = std::abs(b - middle) / across;
  const auto distance = [&](double norm) {
    const double from_axis = std::sqrt(t * t + (b - middle) * (b - middle));  // std::hypot() takes much longer
    const double side = norm < 1e-6 ? -std::min(along, across) : (norm - 1) * from_axis / norm * 0.9;
    const double inside = std::max(side, -std::min(along, across));
    const double upper = (z - top) * 0.8;
    const double body = RoundedIntersection(inside, upper, edge);
    // The lower end of the neck is open towards the roots.
    return RoundedIntersection(body, -z - 1.0, 0.8);
  };
  // The norm is at least the larger coordinate, and the distance grows with it.
  constexpr double kRounding = 1e-9;
  if (const double least = distance(std::max(x, y)); least > limit + kRounding) return least;
  return distance(std::pow(std::pow(x, power) + std::pow(y, power), 1 / power));
}

TeethMask MandibleTeeth::FindNear(const Vec3& centre_W, double radius_mm, double limit) const {
  const double reach_mm = radius_mm + std::max(limit, 0.0) + 2 * kBeyond_mm;
  return FindBoxes(centre_W, reach_mm, [](const Tooth& tooth) -> const Box3& { return tooth.box; });
}

TeethMask MandibleTeeth::FindNearSockets(const Vec3& centre_W, double radius_mm, double limit) const {
  const double reach_mm = radius_mm + std::max(limit, 0.0) + 2 * kBeyond_mm;
  return FindBoxes(centre_W, reach_mm, [](const Tooth& tooth) -> const Box3& { return tooth.root_box; });
}

double MandibleTeeth::Distance(const Vec3& p_W, double limit, TeethMask teeth) const {
  constexpr double kSeam = 0.8;
  double best = limit + kBeyond_mm;
  if (teeth == 0 || teeth_.empty() || BoxDistance(box_, p_W) > best) return best;
  for (std::size_t n = 0; n < teeth_.size(); ++n) {
    const Tooth& tooth = teeth_[n];
    if ((teeth >> n & 1) == 0 || BoxDistance(tooth.box, p_W) > std::max(best, 0.0)) continue;
    const Vec3 d = p_W - tooth.neck;
    const Vec3 local{glm::dot(d, tooth.along), glm::dot(d, tooth.out), glm::dot(d, tooth.up)};
    const bool by_roots = local.z < 2 + std::max(best, 0.0);
    double roots = 1e9;
    if (by_roots) {
      for (const auto& root : tooth.roots) roots = SmoothUnion(roots, root.Distance(p_W), kSeam);
    }
    double value = 1e9;
    if (local.z > -3 - std::max(best, 0.0)) {
      // Beyond the seam the crown does not count, nor if crown and roots are both further away than `best`.
      const double counts = best + 0.25 * kSeam;
      const double crown_limit = by_roots ? std::min(roots + kSeam, roots > counts ? counts : 1e9) : best;
      value = CrownDistance(tooth, local, crown_limit);
    }
    best = std::min(best, by_roots ? SmoothUnion(value, roots, kSeam) : value);
  }
  return best;
}

double MandibleTeeth::SocketDistance(const Vec3& p_W, double limit, TeethMask teeth) const {
  double best = limit + kBeyond_mm;
  for (std::size_t n = 0; n < teeth_.size(); ++n) {
    const Tooth& tooth = teeth_[n];
    if ((teeth >> n & 1) == 0 || BoxDistance(tooth.root_box, p_W) > std::max(best, 0.0)) continue;
    // The layer of bone exists only below the rim of the socket.
    const double rim = glm::dot(p_W - tooth.neck, tooth.up) + 2.8;
    double roots = 1e9;
    for (const auto& root : tooth.roots) roots = SmoothUnion(roots, root.Distance(p_W), 0.8);
    best = std::min(best, RoundedIntersection(roots - 0.55, rim, 0.5));
  }
  return best;
}

}  // namespace kerf
