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
  double Bone(const Vec3& p) const {
    constexpr double kRamusSeam = 5.0, kObliqueSeam = 4.0, kLingulaSeam = 1.5, kOpeningSeam = 1.2;
    double f = 0;
    if (p.z - body_top > 0 && p.y > 30) {
      // Next to or above the body the ramus is evaluated first, because it is cheaper.
      f = ramus.Distance(p, 1e9);
      if (p.z - body_top < f + kRamusSeam) f = SmoothUnion(f, body.Distance(p), kRamusSeam);
    } else {
      f = body.Distance(p);
      f = SmoothUnion(f, ramus.Distance(p, f + kRamusSeam), kRamusSeam);
    }
    if (f > 8) return f - 4;  // everything below adds less than 4 mm: a lower bound
    f = SmoothUnion(f, ridges.oblique.Distance(p, f + kObliqueSeam), kObliqueSeam);
    if (p.x < 25 && p.y < 25) {
      f = SmoothUnion(f, EllipsoidDistance(p - ridges.protuberance, {9.0, 5.0, 5.0}), 4.5);
      f = SmoothUnion(f, glm::distance(p, ridges.tubercle) - 3.8, 5.0);
      f = SmoothUnion(f, glm::distance(p, ridges.genial) - 1.2, 2.0);
    }
    if (f > -4 && BoxDistance(teeth.root_box(), p) < f + 2.0) f = SmoothUnion(f, teeth.SocketDistance(p, f + 2.0), 1.6);
    f = SmoothDifference(f, canal.OpeningDistance(p, kOpeningSeam - f), kOpeningSeam);
    return SmoothUnion(f, canal.LingulaDistance(p, f + kLingulaSeam), kLingulaSeam);
  }

  double Cortex(const Vec3& p) const;
  int Region(const Vec3& p, const Vec3& p_W) const;

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

double MandibleShape::Parts::Cortex(const Vec3& p) const {
  const MandibleParams& m = layout.params;
  const CurvePlace place = layout.base.FindClosest({p.x, p.y});
  const BodySection section = body.Section(place.s);
  const double t = std::clamp((p.z - section.base_z) / (section.crest_z - section.base_z), 0.0, 1.0);
  const bool facial = place.offset > section.Middle(t);
  const double at_molar = facial ? m.cortex_buccal_mm : m.cortex_lingual_mm;
  const double at_front =
      m.cortex_front_mm * (facial ? 1 : m.cortex_lingual_mm / std::max(m.cortex_buccal_mm, m.cortex_lingual_mm));
  const double s1 = layout.on_base.first_molar;
  const double plate = place.s < s1 ? Mix(at_front, at_molar, place.s / s1)
                                    : Mix(at_molar, m.cortex_back_mm, SmoothStep(s1, layout.base.length(), place.s));
  // The plate is thickest along the lower border of the body and thin at the crest.
  const double on_body = 1 - SmoothStep(layout.on_base.third_molar, layout.base.length(), place.s);
  return plate * (1 + on_body * (0.35 * (1 - SmoothStep(0.08, 0.28, t)) - 0.25 * SmoothStep(0.7, 1.0, t)));
}

int MandibleShape::Parts::Region(const Vec3& p, const Vec3& p_W) const {
  const double bone = Bone(p);
  const double tooth = teeth.Distance(p, std::max(bone, 0.0));
  if (tooth < 0 || (bone > 0 && tooth < bone)) return kToothRegion;
  if (bone < 0) {
    if (canal.Distance(p) < 0) return kCanalRegion;
    const double cortex = Cortex(p);
    double depth = -bone;
    constexpr double kLowestSlope = 0.7, kHighestSlope = 1.15;
    if (depth > kLowestSlope * cortex && depth < kHighestSlope * cortex) {
      // Deep inside, the field is no longer a distance, so it is divided by its slope.
      constexpr double h = 0.05;
      const Vec3 slope{Bone(p + Vec3{h, 0, 0}) - Bone(p - Vec3{h, 0, 0}),
                       Bone(p + Vec3{0, h, 0}) - Bone(p - Vec3{0, h, 0}),
                       Bone(p + Vec3{0, 0, h}) - Bone(p - Vec3{0, 0, h})};
      depth /= std::clamp(glm::length(slope) / (2 * h), kLowestSlope, kHighestSlope);
    }
    if (depth > cortex) return kCancellousRegion;
  }
  return atlas->RegionAt(p_W);
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

double MandibleShape::Value(const Vec3& p_W) const {
  const Vec3 p = ToLeft(p_W);
  const double bone = parts_->Bone(p);
  return SmoothUnion(bone, parts_->teeth.Distance(p, bone + 0.5), 0.4);
}

BlockClass MandibleShape::Classify(const Vec3& centre_W, double radius_mm) const {
  // The values are steeper than a distance by these factors; the constant allows for joints. Tested by sampling in
  // tests/bone/models/mandible_test.cpp.
  const double bone_reach = 1.2 * radius_mm + 0.15;
  const double tooth_reach = 1.4 * radius_mm + 0.15;
  const Vec3 p = ToLeft(centre_W);
  const double bone = parts_->Bone(p);
  if (bone < -bone_reach) return BlockClass::kInside;
  const double tooth = parts_->teeth.Distance(p, tooth_reach);
  if (tooth < -tooth_reach) return BlockClass::kInside;
  return bone > bone_reach && tooth > tooth_reach ? BlockClass::kOutside : BlockClass::kMixed;
}

int MandibleShape::RegionAt(const Vec3& p_W) const {
  return parts_->Region(ToLeft(p_W), p_W);
}

const MandibleLandmarks& MandibleShape::landmarks() const {
  return parts_->landmarks;
}

Box3 MandibleShape::bounds() const {
  return parts_->bounds;
}

}  // namespace kerf
