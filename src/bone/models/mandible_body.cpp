#include "bone/models/mandible_body.h"

namespace kerf {
namespace {

double EvaluateCubic(const std::array<double, 4>& y, double t) {
  // Lagrange interpolation through the four levels.
  constexpr double a = kBodyLevels[0], b = kBodyLevels[1], c = kBodyLevels[2], d = kBodyLevels[3];
  return y[0] * (t - b) * (t - c) * (t - d) * (1 / ((a - b) * (a - c) * (a - d))) +
         y[1] * (t - a) * (t - c) * (t - d) * (1 / ((b - a) * (b - c) * (b - d))) +
         y[2] * (t - a) * (t - b) * (t - d) * (1 / ((c - a) * (c - b) * (c - d))) +
         y[3] * (t - a) * (t - b) * (t - c) * (1 / ((d - a) * (d - b) * (d - c)));
}

BodySection MixSections(const BodySection& a, const BodySection& b, double t) {
  BodySection m;
  m.base_z = Mix(a.base_z, b.base_z, t);
  m.crest_z = Mix(a.crest_z, b.crest_z, t);
  for (std::size_t i = 0; i < 4; ++i) {
    m.middle[i] = Mix(a.middle[i], b.middle[i], t);
    m.half_width[i] = Mix(a.half_width[i], b.half_width[i], t);
  }
  m.scale = Mix(a.scale, b.scale, t);
  return m;
}

}  // namespace

double BodySection::Middle(double t) const {
  return EvaluateCubic(middle, t);
}
double BodySection::HalfWidth(double t) const {
  return EvaluateCubic(half_width, t);
}

MandibleBody::MandibleBody(const MandibleLayout& layout) : base_(&layout.base) {
  const MandibleParams& p = layout.params;
  const ArchPlaces& at = layout.on_base;
  const double end = layout.base.length();
  const auto base_line = [&](double s) { return layout.BaseLineZ(layout.base.Point(s).y); };

  // Stations from the front: symphysis, canine, mental foramen, first molar, second molar, behind the teeth, angle,
  // end.
  const double behind = 0.5 * (at.third_molar + at.second_molar) + 3;
  const std::vector<double> s = {
      0, at.canine, at.mental_foramen, at.first_molar, at.second_molar, behind, 0.5 * (behind + end), end};
  const std::vector<double> crest_z = {-10.3, -10.9, -10.5, -7.2, -6.0, -6.6, -12.5, -18};
  const double canine_height = Mix(p.symphysis_height_mm, p.mental_foramen_height_mm, 0.42);
  const std::vector<double> base_z = {
      crest_z[0] - p.symphysis_height_mm,
      crest_z[1] - canine_height,
      crest_z[2] - p.mental_foramen_height_mm,
      crest_z[3] - p.first_molar_height_mm,
      Mix(base_line(s[4]), base_line(s[4]) + crest_z[3] - p.first_molar_height_mm - base_line(s[3]), 0.5),
      base_line(s[5]) + 1.4,
      base_line(s[6]) + 2.6,
      base_line(s[7]) + 3.0};
  // Offset of the middle of the tooth row from the base curve.
  const auto crest_offset = [&](double s_dental) {
    return layout.base.FindClosest(layout.dental.Point(s_dental)).offset;
  };
  const ArchPlaces& d = layout.on_dental;
  const double n_canine = crest_offset(d.canine) - 1.2;
  const double n_foramen = crest_offset(d.mental_foramen);
  const double n_m1 = crest_offset(d.first_molar);
  const double n_m2 = crest_offset(d.second_molar);
  const double w = 0.5 * p.first_molar_width_mm;
  const double k = p.first_molar_width_mm / 13.5;
  const std::array<std::vector<double>, 4> middle = {{
      {1.0, 0.6, 0.3, 0.3, 0.2, 0.0, 0.0, 0.0},
      {0.4, 0.3, 0.2, 0.1, -0.6, -0.6, -0.3, 0.0},
      {1.2, 0.6, 0.3 * n_foramen, 0.55 * n_m1, 0.62 * n_m2, -3.4, -1.2, 0.0},
      {3.4, n_canine, n_foramen, n_m1, n_m2, -6.0, -2.4, 0.0},
  }};
  const std::array<std::vector<double>, 4> half_width = {{
      {5.6, 5.4, 5.0 * k, 5.0 * k, 4.6, 3.8, 2.6, 2.0},
      {5.9, 5.7, 5.9 * k, w, 6.3, 5.0, 2.9, 2.0},
      {4.6, 5.0, 5.5 * k, 6.2 * k, 6.5, 4.8, 2.7, 2.0},
      {3.3, 3.8, 4.2, 5.2, 5.4, 3.6, 2.3, 2.0},
  }};

  const CubicSpline base_spline(s, base_z, true);
  const CubicSpline crest_spline(s, crest_z, true);
  std::array<CubicSpline, 4> middle_spline;
  std::array<CubicSpline, 4> width_spline;
  for (std::size_t i = 0; i < 4; ++i) {
    middle_spline[i] = CubicSpline(s, middle[i], true);
    width_spline[i] = CubicSpline(s, half_width[i], true);
  }
  const auto count = static_cast<std::size_t>(std::ceil(end / step_)) + 2;
  for (std::size_t n = 0; n < count; ++n) {
    const double at_s = std::min(step_ * static_cast<double>(n), end);
    BodySection section;
    section.base_z = base_spline.Value(at_s);
    section.crest_z = crest_spline.Value(at_s);
    for (std::size_t i = 0; i < 4; ++i) {
      section.middle[i] = middle_spline[i].Value(at_s);
      section.half_width[i] = width_spline[i].Value(at_s);
    }
    sections_.push_back(section);
  }

  // Where the section changes along the arch, its values change faster than a distance; the scale corrects this.
  std::vector<double> slope(count, 0.0);
  for (std::size_t n = 0; n + 1 < count; ++n) {
    const BodySection& a = sections_[n];
    const BodySection& b = sections_[n + 1];
    double change = std::max(std::abs(b.base_z - a.base_z), std::abs(b.crest_z - a.crest_z));
    for (std::size_t i = 0; i < 4; ++i) {
      change = std::max(change, std::abs(b.middle[i] - a.middle[i]) + std::abs(b.half_width[i] - a.half_width[i]));
    }
    // On the inner side of the arch 1 mm in space is more than 1 mm along the base curve.
    constexpr double kInnerSide = 1.25;
    slope[n] = kInnerSide * change / step_;
  }
  constexpr std::size_t kWindow = 12;  // stations: 6 mm to each side
  for (std::size_t n = 0; n < count; ++n) {
    double sum = 0;
    double steepest = 0;
    const std::size_t first = n > kWindow ? n - kWindow : 0;
    const std::size_t last = std::min(n + kWindow, count - 1);
    for (std::size_t j = first; j <= last; ++j) {
      steepest = std::max(steepest, slope[j]);
      sum += slope[j];
    }
    const double mean = sum / static_cast<double>(last - first + 1);
    const double typical = 0.5 * (steepest + mean);
    sections_[n].scale = 1 / std::sqrt(1 + typical * typical);
  }
}

BodySection MandibleBody::Section(double s) const {
  const double place = std::clamp(s / step_, 0.0, static_cast<double>(sections_.size() - 2));
  const auto i = static_cast<std::size_t>(place);
  return MixSections(sections_[i], sections_[i + 1], place - static_cast<double>(i));
}

double MandibleBody::Distance(const Vec3& p_W, const CurvePlace& place) const {
  const BodySection section = Section(place.s);
  const double t = std::clamp((p_W.z - section.base_z) / (section.crest_z - section.base_z), 0.0, 1.0);
  const double side = std::abs(place.offset - section.Middle(t)) - section.HalfWidth(t);
  const double lower = RoundedIntersection(side, section.base_z - p_W.z, 0.9 * section.half_width[0]);
  const double f = RoundedIntersection(lower, p_W.z - section.crest_z, 0.75 * section.half_width[3]);
  if (place.beyond <= 0 || place.s <= 0) return f * section.scale;
  // The end, inside the ramus, is rounded.
  return RoundedIntersection(f * section.scale, place.beyond - 3, 2.5);
}

}  // namespace kerf
