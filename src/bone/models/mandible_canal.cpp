#include "bone/models/mandible_canal.h"

namespace kerf {
namespace {

constexpr std::size_t kChunk = 8;
constexpr double kReach_mm = 3;  // range around a chunk's box within which the chunk is evaluated

}  // namespace

MandibleCanal::MandibleCanal(const MandibleLayout& layout, const MandibleBody& body, const MandibleRamus& ramus) {
  const MandibleParams& p = layout.params;
  radius_ = 0.5 * p.canal_diameter_mm;

  // Returns a point of the body: s along the base curve, height above the lower border, and offset outward from the
  // middle.
  const auto body_point = [&](double s, double above_base, double outward) {
    const BodySection section = body.Section(s);
    const double t = above_base / (section.crest_z - section.base_z);
    const double n = section.Middle(t) + outward;
    const Vec2 xy = layout.base.Point(s) + n * layout.base.Normal(s);
    return Vec3{xy.x, xy.y, section.base_z + above_base};
  };
  const auto half_width = [&](double s, double above_base) {
    const BodySection section = body.Section(s);
    return section.HalfWidth(above_base / (section.crest_z - section.base_z));
  };
  const auto ramus_point = [&](double u, double v, double outward) {
    const Vec2 yz = layout.FromRamus({u, v});
    return Vec3{layout.RamusX(u, v) + outward, yz.x, yz.y};
  };

  // Lingula, and the foramen behind and below it, on the inner face of the ramus.
  const double u_lingula = p.lingula_from_back * p.ramus_width_mm;
  const double v_lingula = layout.RamusV(u_lingula, p.lingula_from_below * p.ramus_height_mm);
  const double inner = -ramus.HalfThickness({u_lingula, v_lingula});
  lingula_ = ramus_point(u_lingula, v_lingula, inner - 1.6);
  tongue_.Add(ramus_point(u_lingula + 2.4, v_lingula - 5.5, inner + 1.2),
              ramus_point(u_lingula + 0.3, v_lingula - 0.6, inner - 1.2), 2.0, 0.8);
  const double u_foramen = u_lingula - 2.4;
  const double v_foramen = v_lingula - 3.4;
  const Vec3 foramen = ramus_point(u_foramen, v_foramen, inner + 0.2);

  const ArchPlaces& at = layout.on_base;
  const double s1 = at.first_molar;
  const double above1 = p.canal_to_base_mm + radius_;
  const double out1 = half_width(s1, above1) - p.canal_to_buccal_mm - radius_;
  first_molar_ = body_point(s1, above1, out1);
  const double sf = at.mental_foramen;
  const double above_f = p.foramen_to_base_mm + 0.5 * p.foramen_diameter_mm;
  const double out_f = half_width(sf, above_f);
  mental_foramen_ = body_point(sf, above_f, out_f);
  const double before = sf - 1.0;  // the canal runs slightly past its foramen and turns back to it

  std::vector<Vec3> knots = {foramen, ramus_point(u_foramen + 2.4, v_foramen - 4, inner + 2.4),
                             ramus_point(u_foramen + 6.5, v_foramen - 10, -0.8),
                             ramus_point(u_foramen + 11.5, v_foramen - 16.5, -0.9)};
  const double s2 = at.second_molar;
  knots.push_back(body_point(Mix(s2, at.third_molar, 0.35), above1 + 1.2, -1.2));
  knots.push_back(body_point(Mix(s1, s2, 0.5), above1 + 0.3, 0.6 * out1 - 0.6));
  knots.push_back(first_molar_);
  knots.push_back(body_point(Mix(sf, s1, 0.45), Mix(above1, above_f, 0.12), Mix(out1, out_f, 0.12)));
  knots.push_back(body_point(before + 1.0, Mix(above1, above_f, 0.55), Mix(out1, out_f, 0.40)));
  knots.push_back(body_point(sf - 0.2, above_f - 0.8, out_f - 2.2));
  knots.push_back(mental_foramen_ + 0.6 * (mental_foramen_ - body_point(sf - 0.2, above_f - 0.8, out_f - 2.2)));

  std::vector<double> s(knots.size(), 0.0), x, y, z;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (i > 0) s[i] = s[i - 1] + glm::distance(knots[i], knots[i - 1]);
    x.push_back(knots[i].x), y.push_back(knots[i].y), z.push_back(knots[i].z);
  }
  const CubicSpline sx(s, x), sy(s, y), sz(s, z);
  constexpr int kPieces = 96;
  for (int i = 0; i <= kPieces; ++i) {
    const double at_s = s.back() * i / kPieces;
    path_.push_back({sx.Value(at_s), sy.Value(at_s), sz.Value(at_s)});
  }
  for (std::size_t first = 0; first + 1 < path_.size(); first += kChunk) {
    Chunk chunk;
    chunk.first = first;
    chunk.last = std::min(first + kChunk, path_.size() - 1);
    for (std::size_t i = chunk.first; i <= chunk.last; ++i) chunk.box.Include(path_[i]);
    chunk.box = chunk.box.Grown(radius_ + kReach_mm);
    chunks_.push_back(chunk);
  }

  const Vec3 into = glm::normalize(path_[7] - path_[0]);
  mandibular_opening_.Add(foramen - 1.0 * into + Vec3{-1.0, 0, 0}, foramen + 3.0 * into, radius_ + 0.3, 0.7 * radius_);
  const Vec3 outward = glm::normalize(path_[kPieces] - path_[kPieces - 5]);
  const double rf = 0.5 * p.foramen_diameter_mm;
  mental_opening_.Add(mental_foramen_ + 0.6 * outward, mental_foramen_ - 2.6 * outward, rf, 0.6 * rf);
}

double MandibleCanal::Distance(const Vec3& p_W) const {
  double best2 = (radius_ + kReach_mm) * (radius_ + kReach_mm);
  for (const Chunk& chunk : chunks_) {
    if (glm::any(glm::lessThan(p_W, chunk.box.lower)) || glm::any(glm::greaterThan(p_W, chunk.box.upper))) continue;
    for (std::size_t i = chunk.first; i < chunk.last; ++i) {
      const Vec3 e = path_[i + 1] - path_[i];
      const Vec3 d = p_W - path_[i];
      const double t = std::clamp(glm::dot(d, e) / glm::dot(e, e), 0.0, 1.0);
      const Vec3 r = d - t * e;
      best2 = std::min(best2, glm::dot(r, r));
    }
  }
  return std::sqrt(best2) - radius_;
}

double MandibleCanal::OpeningDistance(const Vec3& p_W, double limit) const {
  return std::min(mandibular_opening_.Distance(p_W, limit), mental_opening_.Distance(p_W, limit));
}

}  // namespace kerf
