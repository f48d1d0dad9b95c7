#include "bone/import/surface_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <utility>

namespace kerf {

namespace {

constexpr std::size_t kPoints = 4000;
constexpr double kTurn_HU = 50;         // noise margin: a profile has passed its peak or foot once it reverses by more
constexpr double kFaintEdge_HU = 200;   // an edge of less contrast is not measured
constexpr double kFinelySampled = 1.1;  // times the finest spacing

// A step with blur `blur`, sampled at spacing 1 and interpolated by cubic splines, has the slope of a step with blur
// `apparent`, in the median over the positions of the samples.
struct Apparent {
  double blur, apparent;
};
constexpr std::array<Apparent, 8> kApparent = {
    {{0.1, 0.413}, {0.2, 0.434}, {0.3, 0.472}, {0.4, 0.529}, {0.5, 0.591}, {0.6, 0.657}, {0.8, 0.824}, {1.0, 1.011}}};

struct Edge {
  double weight;  // area of surface that the point represents
  double offset_mm;
  double half_height_hu;
  double apparent_blur_mm;  // along the normal
  double spacing_mm;        // along the normal
};

// Returns the centres of the voxel faces between the solid and the soft tissue around it.
std::vector<Vec3> FindFaces(const Isolation& isolation, const std::vector<std::uint8_t>& cavities) {
  const Volume& ct = isolation.ct;
  std::vector<Vec3> faces_W;
  for (int k = 1; k + 1 < ct.size[2]; ++k) {
    for (int j = 1; j + 1 < ct.size[1]; ++j) {
      for (int i = 1; i + 1 < ct.size[0]; ++i) {
        if (isolation.bone[ct.Index(i, j, k)] == 0) continue;
        for (int side = 0; side < 6; ++side) {
          std::array<int, 3> at = {i, j, k};
          at[side / 2] += side % 2 == 0 ? 1 : -1;
          const std::size_t w = ct.Index(at[0], at[1], at[2]);
          if (isolation.bone[w] != 0 || cavities[w] != 0 || isolation.keep[w] == 0) continue;
          faces_W.push_back(ct.WorldFromVoxel(0.5 * Vec3(i + at[0], j + at[1], k + at[2])));
        }
      }
    }
  }
  return faces_W;
}

Vec3 CalcGradient(const CtSolid& solid, const Vec3& p_W) {
  constexpr double kStep_mm = 0.05;
  Vec3 gradient;
  for (int a = 0; a < 3; ++a) {
    Vec3 step(0);
    step[a] = kStep_mm;
    gradient[a] = (solid.SurfaceHu(p_W + step) - solid.SurfaceHu(p_W - step)) / (2 * kStep_mm);
  }
  return gradient;
}

// Moves a point onto the surface. Returns false if it does not converge.
bool Project(const CtSolid& solid, double reach_mm, Vec3& p_W) {
  const Vec3 start_W = p_W;
  for (int n = 0; n < 20; ++n) {
    const double height = solid.SurfaceHu(p_W) - solid.iso_hu();
    if (std::abs(height) < 1) return solid.Value(p_W) < 2e-3;  // false on the border to other bone
    const Vec3 gradient = CalcGradient(solid, p_W);
    const double slope = glm::length(gradient);
    if (slope < 1) return false;
    p_W -= gradient / slope * std::clamp(height / slope, -0.5, 0.5);
    if (glm::length(p_W - start_W) > reach_mm) return false;
  }
  return false;
}

// Follows the HU from the surface at t = 0 along the normal while they rise (`sign` +1, inward) or fall (-1, outward).
std::pair<double, double> FindTurn(const std::vector<double>& hu, int middle, int direction, double sign) {
  int best = middle;
  for (int n = middle; n >= 0 && n < static_cast<int>(hu.size()); n += direction) {
    if (sign * hu[n] > sign * hu[best]) best = n;
    if (sign * (hu[best] - hu[n]) > kTurn_HU) break;
  }
  return {best, hu[best]};
}

std::optional<Edge> MeasureEdge(const CtSolid& solid, const Volume& ct, const Vec3& p_W) {
  const Vec3& h = ct.spacing_mm;
  const Vec3 outward_W = -glm::normalize(CalcGradient(solid, p_W));
  const double step_mm = 0.1 * std::min({h.x, h.y, h.z});
  const double reach_mm = 1 + 1.5 * std::max({h.x, h.y, h.z});
  const int middle = static_cast<int>(std::ceil(reach_mm / step_mm));
  std::vector<double> hu;
  for (int n = -middle; n <= middle; ++n) hu.push_back(solid.Hu(p_W + n * step_mm * outward_W));
  const auto [peak_at, peak] = FindTurn(hu, middle, -1, +1);
  const auto [foot_at, foot] = FindTurn(hu, middle, +1, -1);
  if (peak - foot < kFaintEdge_HU) return std::nullopt;
  const double half = 0.5 * (peak + foot);
  int n = static_cast<int>(peak_at);
  while (n < static_cast<int>(foot_at) && hu[n + 1] > half) ++n;
  const double slope = (hu[n] - hu[n + 1]) / step_mm;
  if (slope <= 0) return std::nullopt;
  Edge edge{};
  edge.offset_mm = -(n - middle) * step_mm - (hu[n] - half) / slope;
  edge.half_height_hu = half;
  edge.apparent_blur_mm = (peak - foot) / (slope * std::sqrt(2 * std::numbers::pi));
  const Vec3 n_V = glm::inverse(ct.axes_W) * outward_W;
  edge.spacing_mm = glm::length(n_V * h);
  // A face across axis a has an area proportional to 1 / h_a: directions with fine sampling have more faces.
  edge.weight = 1 / glm::dot(glm::abs(n_V), h);
  return edge;
}

// Returns the weighted median of `value` over the edges; sorts them.
template <typename Value>
double CalcMedian(std::vector<Edge>& edges, Value&& value) {
  std::sort(edges.begin(), edges.end(), [&](const Edge& a, const Edge& b) { return value(a) < value(b); });
  double half = 0;
  for (const Edge& e : edges) half += 0.5 * e.weight;
  for (const Edge& e : edges) {
    half -= e.weight;
    if (half <= 0) return value(e);
  }
  return 0;
}

// Returns the blur of a step whose apparent blur is `apparent_mm`; 0 if the samples are too far apart to determine it.
double CalcBlur(double apparent_mm, double spacing_mm) {
  const double apparent = apparent_mm / spacing_mm;
  if (apparent <= kApparent.front().apparent) return 0;
  if (apparent >= kApparent.back().apparent) return apparent_mm;
  std::size_t n = 1;
  while (kApparent[n].apparent < apparent) ++n;
  const auto& [blur0, apparent0] = kApparent[n - 1];
  const auto& [blur1, apparent1] = kApparent[n];
  return spacing_mm * (blur0 + (blur1 - blur0) * (apparent - apparent0) / (apparent1 - apparent0));
}

// Returns the standard deviation of the position of a flat edge with this blur over the positions of the samples:
// spacing / sqrt(12) without blur. The exponential fits the crossings of the cubic spline at 20 % and 50 % of the
// height to 0.01 spacings.
double CalcScatter(double blur_mm, double spacing_mm) {
  return spacing_mm / std::sqrt(12.0) * std::exp(-3.6 * blur_mm / spacing_mm);
}

}  // namespace

SurfaceError CalcSurfaceError(const CtSolid& solid, const Isolation& isolation,
                              const std::vector<std::uint8_t>& cavities) {
  const Vec3& h = isolation.fine().spacing_mm;
  const Vec3& block_mm = isolation.ct.spacing_mm;  // between the faces
  const double finest = std::min({h.x, h.y, h.z});
  std::vector<Vec3> faces_W = FindFaces(isolation, cavities);
  const std::size_t every = std::max<std::size_t>(1, faces_W.size() / kPoints);
  std::vector<Edge> edges;
  for (std::size_t f = 0; f < faces_W.size(); f += every) {
    if (!Project(solid, std::max({block_mm.x, block_mm.y, block_mm.z}), faces_W[f])) continue;
    if (const std::optional<Edge> edge = MeasureEdge(solid, isolation.fine(), faces_W[f])) edges.push_back(*edge);
  }
  SurfaceError error;
  error.points = static_cast<int>(edges.size());
  if (edges.empty()) return error;
  error.offset_mm = CalcMedian(edges, [](const Edge& e) { return e.offset_mm; });
  error.half_height_hu = CalcMedian(edges, [](const Edge& e) { return e.half_height_hu; });
  std::vector<Edge> fine;
  for (const Edge& e : edges) {
    if (e.spacing_mm <= kFinelySampled * finest) fine.push_back(e);
  }
  const double apparent_mm = CalcMedian(fine.empty() ? edges : fine, [](const Edge& e) { return e.apparent_blur_mm; });
  error.blur_mm = CalcBlur(apparent_mm, finest);
  double sum = 0, area = 0;
  for (const Edge& e : edges) {
    const double scatter = CalcScatter(error.blur_mm, e.spacing_mm);
    sum += e.weight * scatter * scatter;
    area += e.weight;
  }
  error.scatter_mm = std::sqrt(sum / area);
  return error;
}

}  // namespace kerf
