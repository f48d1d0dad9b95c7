// Combination of the parts of the mandible.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "bone/material/atlas.h"
#include "bone/material/region_table.h"
#include "bone/models/mandible.h"
#include "bone/models/mandible_canal.h"
#include "bone/models/mandible_teeth.h"
#include "kerf/error.h"

namespace kerf {
namespace {

void Validate(const MandibleParams& params) {
  CheckParameters(params, "mandible");
  if (params.teeth != 0 && params.teeth != 14 && params.teeth != 16) {
    throw Error(fmt::format("mandible: teeth = {} is not 0, 14 or 16", params.teeth));
  }
  if (params.coronoid_height_mm < params.ramus_height_mm + 5 || params.condyle_height_mm < params.ramus_height_mm + 4) {
    throw Error(
        fmt::format("mandible: the notch at ramus_height_mm = {} is not at least 5 mm below the coronoid at {} and "
                    "4 mm below the condyle at {}",
                    params.ramus_height_mm, params.coronoid_height_mm, params.condyle_height_mm));
  }
  if (params.canal_to_buccal_mm + params.canal_diameter_mm + 1 > params.first_molar_width_mm) {
    throw Error(
        fmt::format("mandible: the canal, {} mm thick and {} mm from the buccal face, leaves less than 1 mm of bone on "
                    "the lingual side of a body {} mm wide",
                    params.canal_diameter_mm, params.canal_to_buccal_mm, params.first_molar_width_mm));
  }
}

/// Ridges and knobs that the swept shapes lack.
struct Ridges {
  RoundedCones oblique;  // external oblique line, from the front edge of the ramus to the first molar
  Vec3 protuberance{0};  // of the chin
  Vec3 tubercle{0};
  Vec3 genial{0};
};

Ridges MakeRidges(const MandibleLayout& layout, const MandibleBody& body, const MandibleRamus& ramus) {
  const auto on_face = [&](double s, double t, double outward) {
    const BodySection section = body.Section(s);
    const double w = section.HalfWidth(t);
    const double n = section.Middle(t) + (outward > 0 ? w - outward : -w - outward);
    const Vec2 xy = layout.base.Point(s) + n * layout.base.Normal(s);
    return Vec3{xy.x, xy.y, Mix(section.base_z, section.crest_z, t)};
  };
  const auto on_front_edge = [&](double height) {
    const double u = 29.5 * layout.params.ramus_width_mm / 31.3;
    const double v = layout.RamusV(u, height);
    const Vec2 yz = layout.FromRamus({u, v});
    return Vec3{layout.RamusX(u, v) + 0.15 * ramus.HalfThickness({u, v}), yz.x, yz.y};
  };
  const ArchPlaces& at = layout.on_base;
  const double scale = layout.params.ramus_height_mm / 44.8;
  const std::vector<Vec3> oblique = {
      on_front_edge(40 * scale), on_front_edge(30 * scale), on_face(at.second_molar + 3, 0.80, 1.6),
      on_face(0.5 * (at.second_molar + at.first_molar) + 1, 0.66, 1.6), on_face(at.first_molar + 1, 0.5, 3.0)};
  const std::array<double, 5> oblique_radius = {0.8, 2.2, 2.5, 2.0, 1.4};
  Ridges r;
  std::vector<double> at_knot, x, y, z;
  for (std::size_t i = 0; i < oblique.size(); ++i) {
    at_knot.push_back(i == 0 ? 0 : at_knot.back() + glm::distance(oblique[i], oblique[i - 1]));
    x.push_back(oblique[i].x), y.push_back(oblique[i].y), z.push_back(oblique[i].z);
  }
  const CubicSpline sx(at_knot, x), sy(at_knot, y), sz(at_knot, z);
  const CubicSpline radius(at_knot, {oblique_radius.begin(), oblique_radius.end()});
  constexpr int kPieces = 32;  // few enough to be fast, enough to make the joints invisible
  for (int i = 0; i < kPieces; ++i) {
    const double s0 = at_knot.back() * i / kPieces;
    const double s1 = at_knot.back() * (i + 1) / kPieces;
    r.oblique.Add({sx.Value(s0), sy.Value(s0), sz.Value(s0)}, {sx.Value(s1), sy.Value(s1), sz.Value(s1)},
                  radius.Value(s0), radius.Value(s1));
  }
  const double base = layout.menton_yz.y;
  r.protuberance = {0, 3.8, base + 7.4};
  r.tubercle = {9.0, 5.6, base + 7.6};
  r.genial = {1.7, 11.9, base + 10.5};
  return r;
}

// The values are steeper than a distance by these factors; the constant allows for joints. Tested by sampling in
// tests/bone/models/mandible_test.cpp.
double CalcBoneReach(double radius_mm) {
  return 1.2 * radius_mm + 0.15;
}
double CalcToothReach(double radius_mm) {
  return 1.4 * radius_mm + 0.15;
}

enum class RegionKind { kTooth, kCancellous, kCortical, kMixed };

// The slope of the bone's value is limited to this range where the depth of the cortex is found.
constexpr double kLowestSlope = 0.7, kHighestSlope = 1.15;
constexpr double kSlopeStep_mm = 0.05;
constexpr double kRounding_mm = 1e-9;

}  // namespace

struct MandibleShape::Parts {
  explicit Parts(const MandibleParams& params)
      : layout(MakeMandibleLayout(params)),
        body(layout),
        ramus(layout),
        teeth(layout),
        canal(layout, body, ramus),
        ridges(MakeRidges(layout, body, ramus)) {}

  /// Returns the value for the bone of the left half. Parts that are too far away to affect the value are not
  /// evaluated.
  double Bone(const Vec3& p, const MandibleParts& near = {}) const {
    double f = 0;
    if (p.z - body_top > 0 && p.y > 30) {
      // Next to or above the body the ramus is evaluated first, because it is cheaper.
      f = ramus.Distance(p, 1e9);
      if (p.z - body_top < f + kRamusSeam) f = SmoothUnion(f, body.Distance(p), kRamusSeam);
    } else {
      f = body.Distance(p);
      f = SmoothUnion(f, ramus.Distance(p, f + kRamusSeam), kRamusSeam);
    }
    if (f > kFar) return f - 4;  // everything below adds less than 4 mm: a lower bound
    if (near.oblique_line) f = SmoothUnion(f, ridges.oblique.Distance(p, f + kObliqueSeam), kObliqueSeam);
    if (near.chin && p.x < kChinEnd && p.y < kChinEnd) {
      f = SmoothUnion(f, EllipsoidDistance(p - ridges.protuberance, kProtuberance), kProtuberanceSeam);
      f = SmoothUnion(f, glm::distance(p, ridges.tubercle) - kTubercle, kTubercleSeam);
      f = SmoothUnion(f, glm::distance(p, ridges.genial) - kGenial, kGenialSeam);
    }
    if (near.sockets != 0 && f > kSocketDepth && BoxDistance(teeth.root_box(), p) < f + kSocketReach) {
      f = SmoothUnion(f, teeth.SocketDistance(p, f + kSocketReach, near.sockets), 1.6);
    }
    if (near.openings) f = SmoothDifference(f, canal.OpeningDistance(p, kOpeningSeam - f), kOpeningSeam);
    if (near.lingula) f = SmoothUnion(f, canal.LingulaDistance(p, f + kLingulaSeam), kLingulaSeam);
    return f;
  }

  MandibleParts FindParts(const Vec3& centre, double radius_mm) const;
  double Cortex(const Vec3& p) const;
  double Cortex(double s, double t, bool facial) const;
  /// Returns limits of Cortex() in a ball.
  std::pair<double, double> CalcCortexRange(const Vec3& centre, double radius_mm) const;
  int Region(const Vec3& p, const MandibleParts& near) const;
  RegionKind ClassifyRegion(const Vec3& centre, double radius_mm, const MandibleParts& near) const;

  static constexpr double kRamusSeam = 5.0, kObliqueSeam = 4.0, kLingulaSeam = 1.5, kOpeningSeam = 1.2;
  static constexpr double kFar = 8;                        // value from which on small parts are left out, mm
  static constexpr double kChinEnd = 25;                   // x and y beyond which the chin is left out
  static constexpr Vec3 kProtuberance{9.0, 5.0, 5.0};      // radii
  static constexpr double kTubercle = 3.8, kGenial = 1.2;  // radii
  static constexpr double kProtuberanceSeam = 4.5, kTubercleSeam = 5.0, kGenialSeam = 2.0;
  static constexpr double kSocketDepth = -4, kSocketReach = 2.0;

  MandibleLayout layout;
  MandibleBody body;
  double body_top = -5;  // top of the body, z
  MandibleRamus ramus;
  MandibleTeeth teeth;
  MandibleCanal canal;
  Ridges ridges;
  MandibleLandmarks landmarks;
  Box3 bounds;
  std::optional<MandibleAtlas> atlas;
};

namespace {

Vec3 ToLeft(const Vec3& p_W) {
  return {std::abs(p_W.x), p_W.y, p_W.z};
}

}  // namespace

MandibleParts MandibleShape::Parts::FindParts(const Vec3& centre, double radius_mm) const {
  const double reach = CalcBoneReach(radius_mm);
  MandibleParts near;
  near.oblique_line = near.chin = near.openings = near.lingula = false;
  near.sockets = 0;
  // The value of the parts so far, as in Bone(), differs in the ball by at most `reach` from that at its centre.
  double f = Bone(centre, near);
  if (f > kFar - 4 - reach) return {};
  const auto is_near = [&](double distance, double seam) { return distance - radius_mm <= f + reach + seam; };
  const double oblique = ridges.oblique.Distance(centre, f + reach + radius_mm + kObliqueSeam);
  near.oblique_line = is_near(oblique, kObliqueSeam);
  f = SmoothUnion(f, oblique, kObliqueSeam);
  if (centre.x - radius_mm < kChinEnd && centre.y - radius_mm < kChinEnd) {
    // The approximate distance of an ellipsoid grows by at least the ratio of its least and its largest radius.
    const double ratio = kProtuberance.y / kProtuberance.x;
    near.chin = ratio * (glm::distance(centre, ridges.protuberance) - radius_mm) - kProtuberance.y <=
                    f + reach + kProtuberanceSeam ||
                is_near(glm::distance(centre, ridges.tubercle) - kTubercle, kTubercleSeam) ||
                is_near(glm::distance(centre, ridges.genial) - kGenial, kGenialSeam);
  }
  if (f + reach > kSocketDepth) near.sockets = teeth.FindNearSockets(centre, radius_mm, f + reach + kSocketReach);
  f = Bone(centre, near);
  const double opening = canal.OpeningDistance(centre, kOpeningSeam - f + reach + radius_mm);
  near.openings = opening - radius_mm <= kOpeningSeam - f + reach;
  f = Bone(centre, near);
  near.lingula = is_near(canal.LingulaDistance(centre, f + reach + radius_mm + kLingulaSeam), kLingulaSeam);
  // Of a tooth, Value(), Classify() and RegionAt() need the distance up to those limits.
  f = Bone(centre, near);
  near.teeth = teeth.FindNear(centre, radius_mm, std::max(f + reach, 0.0) + reach + CalcToothReach(radius_mm) + 0.5);
  return near;
}

double MandibleShape::Parts::Cortex(const Vec3& p) const {
  const CurvePlace place = layout.base.FindClosest({p.x, p.y});
  const BodySection section = body.Section(place.s);
  const double t = std::clamp((p.z - section.base_z) / (section.crest_z - section.base_z), 0.0, 1.0);
  return Cortex(place.s, t, place.offset > section.Middle(t));
}

std::pair<double, double> MandibleShape::Parts::CalcCortexRange(const Vec3& centre, double radius_mm) const {
  // Larger than any change per mm that sampling found: 0.57 with the default parameters, 1.06 with the ends of ranges.
  constexpr double kSlope = 1.5;
  const CurvePlace place = layout.base.FindClosest({centre.x, centre.y});
  const BodySection section = body.Section(place.s);
  const double t = std::clamp((centre.z - section.base_z) / (section.crest_z - section.base_z), 0.0, 1.0);
  const auto [least, most] = std::minmax({Cortex(place.s, t, true), Cortex(place.s, t, false)});
  return {least - kSlope * radius_mm, most + kSlope * radius_mm};
}

/// Returns the thickness of a plate of the cortex at a place of the body: `t` as in BodySection.
double MandibleShape::Parts::Cortex(double s, double t, bool facial) const {
  const MandibleParams& m = layout.params;
  const double at_molar = facial ? m.cortex_buccal_mm : m.cortex_lingual_mm;
  const double at_front =
      m.cortex_front_mm * (facial ? 1 : m.cortex_lingual_mm / std::max(m.cortex_buccal_mm, m.cortex_lingual_mm));
  const double s1 = layout.on_base.first_molar;
  const double plate = s < s1 ? Mix(at_front, at_molar, s / s1)
                              : Mix(at_molar, m.cortex_back_mm, SmoothStep(s1, layout.base.length(), s));
  // The plate is thickest along the lower border of the body and thin at the crest.
  const double on_body = 1 - SmoothStep(layout.on_base.third_molar, layout.base.length(), s);
  return plate * (1 + on_body * (0.35 * (1 - SmoothStep(0.08, 0.28, t)) - 0.25 * SmoothStep(0.7, 1.0, t)));
}

RegionKind MandibleShape::Parts::ClassifyRegion(const Vec3& centre, double radius_mm, const MandibleParts& near) const {
  const double bone_reach = CalcBoneReach(radius_mm), tooth_reach = CalcToothReach(radius_mm);
  const double bone = Bone(centre, near);
  if (bone > kFar - 4 - bone_reach) return RegionKind::kMixed;  // only a lower bound is known
  const double beyond_tooth = std::max(bone + bone_reach, 0.0) + tooth_reach;
  const double tooth = teeth.Distance(centre, beyond_tooth, near.teeth);
  if (tooth < -tooth_reach) return RegionKind::kTooth;
  if (!(tooth > beyond_tooth)) return RegionKind::kMixed;
  const double largest_depth = bone_reach - bone, least_depth = -bone - bone_reach;
  if (largest_depth > 0) {
    const double to_canal = canal.Distance(centre);
    if (!(to_canal > radius_mm + kRounding_mm)) return RegionKind::kMixed;
  }
  const auto [thinnest, thickest] = CalcCortexRange(centre, radius_mm);
  if (largest_depth < kLowestSlope * thinnest) return RegionKind::kCortical;
  return least_depth > kHighestSlope * thickest ? RegionKind::kCancellous : RegionKind::kMixed;
}

/// Returns kRegionByPlace for the cortex.
int MandibleShape::Parts::Region(const Vec3& p, const MandibleParts& near) const {
  const double bone = Bone(p, near);
  const double tooth = teeth.Distance(p, std::max(bone, 0.0), near.teeth);
  if (tooth < 0 || (bone > 0 && tooth < bone)) return kToothRegion;
  if (bone < 0) {
    if (canal.Distance(p) < 0) return kCanalRegion;
    const double cortex = Cortex(p);
    double depth = -bone;
    if (depth > kLowestSlope * cortex && depth < kHighestSlope * cortex) {
      // Deep inside, the field is no longer a distance, so it is divided by its slope.
      constexpr double h = kSlopeStep_mm;
      const double value = depth;
      Vec3 slope{0};
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 step{0};
        step[axis] = h;
        slope[axis] = Bone(p + step, near) - Bone(p - step, near);
        depth = value / std::clamp(glm::length(slope) / (2 * h), kLowestSlope, kHighestSlope);
        if (depth <= cortex) break;  // with the other axes it would be even less
      }
    }
    if (depth > cortex) return kCancellousRegion;
  }
  return kRegionByPlace;
}

MandibleShape::MandibleShape(const MandibleParams& params) {
  Validate(params);
  auto parts = std::make_unique<Parts>(params);
  MandibleLandmarks& l = parts->landmarks;
  const MandibleLayout& layout = parts->layout;
  l.menton = {0, layout.menton_yz.x, layout.menton_yz.y};
  const double gonion_v = 8;
  l.gonion = {layout.RamusX(0, gonion_v), layout.gonion_yz.x, layout.gonion_yz.y};
  l.base_line = {0, -std::cos(layout.base_slope), -std::sin(layout.base_slope)};
  l.back_edge = {0, layout.v_yz.x, layout.v_yz.y};
  l.first_molar = parts->canal.first_molar();
  const Vec2 out = layout.base.Normal(layout.on_base.first_molar);
  l.first_molar_out = {out.x, out.y, 0};
  const Vec2 out_f = layout.base.Normal(layout.on_base.mental_foramen);
  l.mental_foramen_out = {out_f.x, out_f.y, 0};
  l.mental_foramen = parts->canal.mental_foramen();
  l.mandibular_foramen = parts->canal.mandibular_foramen();
  l.lingula = parts->canal.lingula();
  l.condyle = parts->ramus.condyle();

  // Points of the bone for the atlas, on a grid of 2 mm.
  std::vector<Vec3> points;
  const Parts& c = *parts;
  constexpr double kStep = 2;
  for (double x = 0; x <= 76; x += kStep) {
    for (double y = -14; y <= 120; y += kStep) {
      for (double z = -60; z <= 62; z += kStep) {
        const double bone = c.Bone({x, y, z});
        if (bone > 2 * kStep && c.teeth.Distance({x, y, z}, 2 * kStep) > 2 * kStep) {
          // Nothing within about 2 steps: skip ahead.
          z += kStep * std::floor(std::min(bone, 2 * kStep) / (2 * kStep));
          continue;
        }
        parts->bounds.Include({x, y, z});
        if (bone > 0) continue;
        points.push_back({x, y, z});
        points.push_back({-x, y, z});
      }
    }
  }
  parts->bounds.Include({-parts->bounds.upper.x, parts->bounds.lower.y, parts->bounds.lower.z});
  parts->bounds = parts->bounds.Grown(kStep);
  parts->atlas.emplace(points);
  parts_ = std::move(parts);
}

MandibleShape::~MandibleShape() = default;

double MandibleShape::BoneValue(const Vec3& p_W) const {
  return parts_->Bone(ToLeft(p_W));
}

double MandibleShape::ToothValue(const Vec3& p_W) const {
  return parts_->teeth.Distance(ToLeft(p_W), 1e6);
}

double MandibleShape::CanalValue(const Vec3& p_W) const {
  return parts_->canal.Distance(ToLeft(p_W));
}

double MandibleShape::Value(const Vec3& p_W, const MandibleParts& parts) const {
  const Vec3 p = ToLeft(p_W);
  const double bone = parts_->Bone(p, parts);
  return SmoothUnion(bone, parts_->teeth.Distance(p, bone + 0.5, parts.teeth), 0.4);
}

BlockClass MandibleShape::Classify(const Vec3& centre_W, double radius_mm, const MandibleParts& parts) const {
  const double bone_reach = CalcBoneReach(radius_mm);
  const double tooth_reach = CalcToothReach(radius_mm);
  const Vec3 p = ToLeft(centre_W);
  const double bone = parts_->Bone(p, parts);
  if (bone < -bone_reach) return BlockClass::kInside;
  const double tooth = parts_->teeth.Distance(p, tooth_reach, parts.teeth);
  if (tooth < -tooth_reach) return BlockClass::kInside;
  return bone > bone_reach && tooth > tooth_reach ? BlockClass::kOutside : BlockClass::kMixed;
}

int MandibleShape::RegionAt(const Vec3& p_W) const {
  const int region = parts_->Region(ToLeft(p_W), {});
  return region == kRegionByPlace ? CortexRegionAt(p_W) : region;
}

int MandibleShape::CortexRegionAt(const Vec3& p_W) const {
  return parts_->atlas->RegionAt(p_W);
}

void MandibleShape::SetRegions(const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) const {
  constexpr int kEdge = 8;  // of a leaf, voxels
  const auto centre_of = [&](const glm::ivec3& first, int edge) {
    return leaf.voxel_mm * (Vec3(leaf.first[0], leaf.first[1], leaf.first[2]) + Vec3(first) + 0.5 * (edge - 1));
  };
  const auto radius_of = [&](int edge) { return 0.5 * std::sqrt(3.0) * (edge - 1) * leaf.voxel_mm + kRounding_mm; };
  const MandibleParts near = FindParts(centre_of({0, 0, 0}, kEdge), radius_of(kEdge) + kSlopeStep_mm);
  const auto set = [&](auto&& self, const glm::ivec3& first, int edge) -> void {
    const auto for_each = [&](int step, auto&& visit) {
      for (int x = 0; x < edge; x += step) {
        for (int y = 0; y < edge; y += step) {
          for (int z = 0; z < edge; z += step) visit(first + glm::ivec3{x, y, z});
        }
      }
    };
    const RegionKind kind = parts_->ClassifyRegion(ToLeft(centre_of(first, edge)), radius_of(edge), near);
    if (kind == RegionKind::kMixed && edge > 2) {
      return for_each(edge / 2, [&](const glm::ivec3& part) { self(self, part, edge / 2); });
    }
    for_each(1, [&](const glm::ivec3& voxel) {
      const int n = (voxel.x * kEdge + voxel.y) * kEdge + voxel.z;
      if (!wanted[static_cast<std::size_t>(n)]) return;
      const Vec3 p_W = leaf.CalcPosition(n);
      ids[static_cast<std::size_t>(n)] = kind == RegionKind::kTooth        ? kToothRegion
                                         : kind == RegionKind::kCancellous ? kCancellousRegion
                                         : kind == RegionKind::kCortical   ? kRegionByPlace
                                                                           : parts_->Region(ToLeft(p_W), near);
    });
  };
  set(set, {0, 0, 0}, kEdge);
}

MandibleParts MandibleShape::FindParts(const Vec3& centre_W, double radius_mm) const {
  return parts_->FindParts(ToLeft(centre_W), radius_mm);
}

const MandibleLandmarks& MandibleShape::landmarks() const {
  return parts_->landmarks;
}

Box3 MandibleShape::bounds() const {
  return parts_->bounds;
}

}  // namespace kerf
