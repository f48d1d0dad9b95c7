#include "bone/import/scan_edge.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

namespace kerf {

namespace {

constexpr double kMinPadding_mm2 = 10;
constexpr int kAirTo_HU = -900;

enum class Beyond { kInside, kBorder, kPadding, kOneValue };

// Returns what lies beyond the face of a voxel. Air of one value from there to the border may be padding.
Beyond LookBeyond(const Volume& ct, std::array<int, 3> at, std::size_t axis, int way) {
  at[axis] += way;
  if (!ct.Contains(at)) return Beyond::kBorder;
  const std::int16_t hu = ct.hu[ct.Index(at[0], at[1], at[2])];
  if (hu > kAirTo_HU) return Beyond::kInside;
  bool is_padding = !ct.padding.empty(), is_one_value = true;
  for (; ct.Contains(at) && (is_padding || is_one_value); at[axis] += way) {
    const std::size_t v = ct.Index(at[0], at[1], at[2]);
    is_padding = is_padding && ct.padding[v];
    is_one_value = is_one_value && ct.hu[v] == hu;
  }
  return is_padding ? Beyond::kPadding : is_one_value ? Beyond::kOneValue : Beyond::kInside;
}

// A face in the plane of i and j beside which air has one value up to the border.
struct SharpFace {
  glm::dvec2 at_mm{0};  // from the first voxel
  double mm2 = 0;
  int k = 0;
};

struct Edges {
  double border_mm2 = 0, padding_mm2 = 0;
  std::vector<SharpFace> sharp;
  void Add(const Volume& ct, const std::array<int, 3>& at);
};

// Adds the faces of a voxel.
void Edges::Add(const Volume& ct, const std::array<int, 3>& at) {
  const Vec3& h = ct.spacing_mm;
  for (std::size_t a = 0; a < 3; ++a) {
    const double mm2 = h.x * h.y * h.z / h[static_cast<int>(a)];
    for (const int way : {-1, 1}) {
      const Beyond beyond = LookBeyond(ct, at, a, way);
      if (beyond == Beyond::kBorder) border_mm2 += mm2;
      if (beyond == Beyond::kPadding) padding_mm2 += mm2;
      if (beyond != Beyond::kOneValue || a == 2) continue;
      SharpFace face{{at[0] * h.x, at[1] * h.y}, mm2, at[2]};
      face.at_mm[static_cast<int>(a)] += 0.5 * way * h[static_cast<int>(a)];
      sharp.push_back(face);
    }
  }
}

struct Circle {
  glm::dvec2 centre_mm{0};
  double radius_mm = 0;
  // Keeps the faces that lie on the circle.
  void Select(double slack_mm, std::vector<SharpFace>& faces) const {
    std::erase_if(faces, [&](const SharpFace& face) {
      return std::abs(glm::length(face.at_mm - centre_mm) - radius_mm) > slack_mm;
    });
  }
};

// Returns the circle for which the sum of the squares of (d^2 - r^2) is least (Kasa), where d are the distances of the
// faces from its centre.
Circle FitCircle(const std::vector<SharpFace>& faces) {
  const auto n = static_cast<double>(faces.size());
  glm::dvec2 mean(0);
  for (const SharpFace& face : faces) mean += face.at_mm / n;
  double xx = 0, xy = 0, yy = 0;
  glm::dvec2 third(0);
  for (const SharpFace& face : faces) {
    const glm::dvec2 p = face.at_mm - mean;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
    third += 0.5 * glm::dot(p, p) * p;
  }
  const double determinant = std::max(xx * yy - xy * xy, 1e-9);
  const glm::dvec2 centre = glm::dvec2(yy * third.x - xy * third.y, xx * third.y - xy * third.x) / determinant;
  return {mean + centre, std::sqrt(glm::dot(centre, centre) + (xx + yy) / n)};
}

// Returns whether a slice of the scan shows a wide circle outside which all is air of one value, and inside, along a
// quarter of it, something else.
bool IsEdgeOfScan(const Volume& ct, const Circle& circle, int k) {
  constexpr double kWide = 0.6;  // of the shorter side; a smaller circle is what the scan shows
  const double side_mm = std::min(ct.size[0] * ct.spacing_mm.x, ct.size[1] * ct.spacing_mm.y);
  if (2 * circle.radius_mm < kWide * side_mm) return false;
  constexpr int kAngles = 360;
  const double slack_mm = 1.5 * std::max(ct.spacing_mm.x, ct.spacing_mm.y);
  int inside = 0, different = 0, outside = 0, air = 0;
  for (int n = 0; n < kAngles; ++n) {
    const double angle = 2 * std::numbers::pi * n / kAngles;
    for (const double r : {circle.radius_mm - slack_mm, circle.radius_mm + slack_mm}) {
      const glm::dvec2 p = circle.centre_mm + r * glm::dvec2(std::cos(angle), std::sin(angle));
      const std::array<int, 3> at = {static_cast<int>(std::lround(p.x / ct.spacing_mm.x)),
                                     static_cast<int>(std::lround(p.y / ct.spacing_mm.y)), k};
      if (!ct.Contains(at)) continue;
      const bool is_air = ct.hu[ct.Index(at[0], at[1], at[2])] <= kAirTo_HU;
      if (r < circle.radius_mm) {
        ++inside;
        different += is_air ? 0 : 1;
      } else {
        ++outside;
        air += is_air ? 1 : 0;
      }
    }
  }
  return outside > 0 && air == outside && 4 * different >= inside;
}

double SumAreas(const std::vector<SharpFace>& faces) {
  double mm2 = 0;
  for (const SharpFace& face : faces) mm2 += face.mm2;
  return mm2;
}

// Returns the faces of all that is no air in a slice.
std::vector<SharpFace> FindEdgeOfSlice(const Volume& ct, int k) {
  constexpr int kNoAir_HU = -500;
  Edges edges;
  for (int j = 0; j < ct.size[1]; ++j) {
    for (int i = 0; i < ct.size[0]; ++i) {
      if (ct.hu[ct.Index(i, j, k)] > kNoAir_HU) edges.Add(ct, {i, j, k});
    }
  }
  return edges.sharp;
}

// Returns the area of those faces of a bone that lie at the edge of a round field of view; 0 if most do not.
double CalcCircleArea(const Volume& ct, std::vector<SharpFace> faces) {
  const double all_mm2 = SumAreas(faces);
  if (all_mm2 < kMinPadding_mm2) return 0;
  const int k = faces[faces.size() / 2].k;
  const double voxel_mm = std::max(ct.spacing_mm.x, ct.spacing_mm.y);
  std::vector<SharpFace> edge = FindEdgeOfSlice(ct, k);
  Circle circle;
  for (const double slack_vox : {3.0, 1.5, 1.0}) {
    constexpr std::size_t kMinFaces = 16;
    if (edge.size() < kMinFaces) return 0;
    circle = FitCircle(edge);
    circle.Select(slack_vox * voxel_mm, edge);
  }
  circle.Select(voxel_mm, faces);
  const double mm2 = SumAreas(faces);
  return 2 * mm2 > all_mm2 && mm2 >= kMinPadding_mm2 && IsEdgeOfScan(ct, circle, k) ? mm2 : 0;
}

}  // namespace

double CalcCutArea(const Volume& ct, const Isolation& isolation, double iso_hu) {
  const Volume& fine = isolation.fine();
  const Vec3 first = ct.VoxelFromWorld(fine.origin_W);
  const std::array<int, 3> shift = {static_cast<int>(std::lround(first.x)), static_cast<int>(std::lround(first.y)),
                                    static_cast<int>(std::lround(first.z))};
  std::vector<Edges> of_slices(static_cast<std::size_t>(fine.size[2]));
  tbb::parallel_for(0, fine.size[2], [&](int k) {
    std::size_t v = fine.Index(0, 0, k);
    for (int j = 0; j < fine.size[1]; ++j) {
      for (int i = 0; i < fine.size[0]; ++i, ++v) {
        if (fine.hu[v] < iso_hu || isolation.keep[isolation.Find(i, j, k)] == 0) continue;
        of_slices[static_cast<std::size_t>(k)].Add(ct, {shift[0] + i, shift[1] + j, shift[2] + k});
      }
    }
  });
  Edges all;
  for (const Edges& edges : of_slices) {
    all.border_mm2 += edges.border_mm2;
    all.padding_mm2 += edges.padding_mm2;
    all.sharp.insert(all.sharp.end(), edges.sharp.begin(), edges.sharp.end());
  }
  return all.border_mm2 + (all.padding_mm2 < kMinPadding_mm2 ? 0 : all.padding_mm2) + CalcCircleArea(ct, all.sharp);
}

}  // namespace kerf
