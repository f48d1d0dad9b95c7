#include "experiment/reference/rim.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf::reference {
namespace {

constexpr double kMinInterval_rad = 1e-8;
constexpr int kLevels = 5;  // across the disc's thickness

/// Takes samples along one circle and collects its pieces.
class Walk {
 public:
  Walk(const ExactBone& bone, const DiscSaw& saw, const Pose& X_WT, const Circle& circle, double step_rad,
       std::vector<Piece>& pieces)
      : bone_(bone), saw_(saw), X_WT_(X_WT), circle_(circle), short_rad_(0.5 * step_rad), pieces_(pieces) {}

  struct Look {
    double angle = 0;
    int kind = 0;  // 0: no bone; otherwise its region, or 1 without materials
    ToothCut cut;
    double clear_mm = 0;  // lower bound of the distance to bone
  };

  Look LookAt(double angle) const {
    Look look;
    look.angle = angle;
    const Vec3 p_W =
        X_WT_.Point({circle_.radius_mm * std::cos(angle), circle_.radius_mm * std::sin(angle), circle_.z_mm});
    const double solid = bone_.solid().distance_mm(p_W);
    if (solid >= 0) {
      look.clear_mm = 0.5 * solid;  // the distance function may grow up to twice as fast as the distance
      return look;
    }
    if (bone_.IsSwept(p_W)) return look;
    look.kind = 1;
    if (!circle_.with_material) return look;
    const ExactSolid::Material material = bone_.solid().material(p_W);
    look.cut = MakeCut(material, saw_);
    look.kind = look.cut.E_star_MPa > 0 ? material.region : 0;
    return look;
  }

  /// Adds the pieces between two samples.
  void Settle(const Look& a, const Look& b) {
    if (a.kind == b.kind) {
      if (a.kind != 0) Add({a.angle, b.angle, a.cut, b.cut}, a.kind);
      return;
    }
    const double middle = 0.5 * (a.angle + b.angle);
    if (b.angle - a.angle <= kMinInterval_rad) {
      if (a.kind != 0) Add({a.angle, middle, a.cut, a.cut}, a.kind);
      if (b.kind != 0) Add({middle, b.angle, b.cut, b.cut}, b.kind);
      return;
    }
    const Look m = LookAt(middle);
    Settle(a, m);
    Settle(m, b);
  }

 private:
  void Add(const Piece& piece, int kind) {
    // A sliver from the bisection is merged with the piece before it.
    if (!pieces_.empty() && last_kind_ == kind && pieces_.back().to_rad == piece.from_rad &&
        (piece.to_rad - piece.from_rad < short_rad_ || pieces_.back().to_rad - pieces_.back().from_rad < short_rad_)) {
      pieces_.back().to_rad = piece.to_rad;
      pieces_.back().cut_to = piece.cut_to;
      return;
    }
    pieces_.push_back(piece);
    last_kind_ = kind;
  }

  const ExactBone& bone_;
  const DiscSaw& saw_;
  const Pose& X_WT_;
  const Circle& circle_;
  double short_rad_;
  std::vector<Piece>& pieces_;
  int last_kind_ = 0;
};

}  // namespace

ToothCut MakeCut(const ExactSolid::Material& bone, const DiscSaw& saw) {
  if (bone.region == 0 || !(bone.E_MPa > 0)) return {};
  const double E_star_MPa = 1 / ((1 - saw.nu * saw.nu) / saw.E_MPa + (1 - bone.nu * bone.nu) / bone.E_MPa);
  return MakeToothCut(bone.E_MPa, E_star_MPa, bone.tissue);
}

void FindPieces(const ExactBone& bone, const DiscSaw& saw, const Pose& X_WT, const Circle& circle, double from_rad,
                double to_rad, int points, std::vector<Piece>& pieces) {
  pieces.clear();
  if (!(to_rad > from_rad)) return;
  const int intervals =
      std::max(1, static_cast<int>(std::ceil(points * (to_rad - from_rad) / (2 * std::numbers::pi) - 1e-9)));
  const double step = (to_rad - from_rad) / intervals;
  Walk walk(bone, saw, X_WT, circle, step, pieces);
  Walk::Look last = walk.LookAt(from_rad);
  for (int i = 0; i < intervals;) {
    // Skips the part of the circle that certainly contains no bone.
    const double skipped = std::floor(last.clear_mm / (circle.radius_mm * step));
    i += static_cast<int>(std::clamp(skipped, 1.0, static_cast<double>(intervals - i)));
    const Walk::Look next = walk.LookAt(i == intervals ? to_rad : from_rad + i * step);
    walk.Settle(last, next);
    last = next;
  }
}

Flux::Flux(const DiscSaw& saw, int rim_points, double flat_spacing_mm, bool flats)
    : saw_(saw), rim_points_(rim_points), flat_spacing_mm_(flat_spacing_mm), flats_(flats) {}

double Flux::Calc(const ExactBone& bone, const Pose& X_WT, const Vec3& v_T, const Vec3& w_T) const {
  double sum = CalcRim(bone, X_WT, v_T, w_T);
  if (flats_) sum += CalcFlats(bone, X_WT, v_T, w_T);
  return sum;
}

/// Integrates over the rim as circles, each in the middle of its part of the thickness.
double Flux::CalcRim(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const {
  const double height = saw_.thickness_mm / kLevels;
  std::vector<Piece> pieces;
  double sum = 0;
  for (int level = 0; level < kLevels; ++level) {
    const Circle circle{saw_.radius_mm(), (level + 0.5) * height - 0.5 * saw_.thickness_mm, false};
    // Rotation about an axis in the disc's plane moves the circle sideways as a whole.
    const double x = v.x + w.y * circle.z_mm;
    const double y = v.y - w.x * circle.z_mm;
    const double speed = std::hypot(x, y);
    if (!(speed > 0)) continue;
    const double feed = std::atan2(y, x);
    FindPieces(bone, saw_, X_WT, circle, feed - 0.5 * std::numbers::pi, feed + 0.5 * std::numbers::pi, rim_points_,
               pieces);
    for (const Piece& piece : pieces) {
      sum += speed * (std::sin(piece.to_rad - feed) - std::sin(piece.from_rad - feed)) * circle.radius_mm * height;
    }
  }
  return sum;
}

/// Integrates over the flats as rings, each in the middle of its width.
double Flux::CalcFlats(const ExactBone& bone, const Pose& X_WT, const Vec3& v, const Vec3& w) const {
  const double fastest = std::abs(v.z) + std::hypot(w.x, w.y) * saw_.radius_mm();
  if (!(fastest > 1e-9)) return 0;
  const int rings = std::max(1, static_cast<int>(std::ceil(saw_.radius_mm() / flat_spacing_mm_)));
  const double width = saw_.radius_mm() / rings;
  std::vector<Piece> pieces;
  double sum = 0;
  for (int ring = 0; ring < rings; ++ring) {
    for (const double side : {-1.0, 1.0}) {
      const Circle circle{(ring + 0.5) * width, 0.5 * side * saw_.thickness_mm, false};
      const int points =
          std::max(16, static_cast<int>(std::ceil(2 * std::numbers::pi * circle.radius_mm / flat_spacing_mm_)));
      // The outward speed of a point of the ring is side (v_z + r (w_x sin - w_y cos)). It is above 0 within `half` of
      // `top`.
      const double turning = circle.radius_mm * std::hypot(w.x, w.y);
      double top = 0;
      double half = std::numbers::pi;
      if (turning > std::abs(v.z)) {
        top = std::atan2(side * w.x, -side * w.y);
        half = std::acos(-side * v.z / turning);
      } else if (side * v.z <= 0) {
        continue;
      }
      FindPieces(bone, saw_, X_WT, circle, top - half, top + half, points, pieces);
      for (const Piece& p : pieces) {
        const double area = circle.radius_mm * width;
        sum += side * area *
               (v.z * (p.to_rad - p.from_rad) + circle.radius_mm * (-w.x * (std::cos(p.to_rad) - std::cos(p.from_rad)) -
                                                                    w.y * (std::sin(p.to_rad) - std::sin(p.from_rad))));
      }
    }
  }
  return sum;
}

Vec3 TurnBetween(const Quat& R_a, const Quat& R_b) {
  Quat d = glm::conjugate(R_a) * R_b;
  if (d.w < 0) d = -d;
  const Vec3 axis(d.x, d.y, d.z);
  const double sine = glm::length(axis);
  if (sine < 1e-150) return Vec3(0);
  return 2 * std::atan2(sine, d.w) / sine * axis;
}

Quat Turn(const Quat& R, const Vec3& turn_rad) {
  const double angle = glm::length(turn_rad);
  if (angle < 1e-150) return R;
  const Vec3 axis = std::sin(0.5 * angle) / angle * turn_rad;
  return glm::normalize(R * Quat(std::cos(0.5 * angle), axis.x, axis.y, axis.z));
}

Pose Between(const Pose& X_a, const Pose& X_b, double fraction) {
  if (fraction <= 0) return X_a;
  if (fraction >= 1) return X_b;
  return {Turn(X_a.R_AB, fraction * TurnBetween(X_a.R_AB, X_b.R_AB)), X_a.p_AB + fraction * (X_b.p_AB - X_a.p_AB)};
}

}  // namespace kerf::reference
