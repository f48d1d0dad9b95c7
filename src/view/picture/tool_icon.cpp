#include "view/picture/tool_icon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "cut/tool/looks.h"

namespace kerf {
namespace {

constexpr Rgb8 kGround{240, 243, 246};
constexpr int kSamples = 4;       // per pixel and axis
constexpr double kMargin = 0.06;  // of the height
const Vec3 kLight = glm::normalize(Vec3(-0.35, 0.5, 0.8));

/// Returns the frame of the picture in that of the tool: x to the right, y up, z to the eye.
Pose FindFrame(const Tool& tool, const Box3& box) {
  if (!IsBlade(tool)) return {glm::quat_cast(glm::dmat3(Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, 1, 0))), Vec3(0)};
  if (box.size().x >= box.size().y) return {};
  return {glm::quat_cast(glm::dmat3(Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1))), Vec3(0)};
}

/// Samples with the nearest surface, of which each keeps how bright it is.
struct Canvas {
  int width, height;
  std::vector<double> depth = std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                                                  -std::numeric_limits<double>::infinity());
  std::vector<double> light = std::vector<double>(depth.size(), 0);

  /// Draws a triangle with corners in samples.
  void Draw(const Vec3& a, const Vec3& b, const Vec3& c, double brightness) {
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(std::abs(area) > 1e-12)) return;
    const auto range = [](double p, double q, double r, int size) {
      return std::pair(std::clamp(static_cast<int>(std::floor(std::min({p, q, r}) - 0.5)), 0, size),
                       std::clamp(static_cast<int>(std::ceil(std::max({p, q, r}) + 0.5)), 0, size));
    };
    const auto [left, right] = range(a.x, b.x, c.x, width);
    const auto [top, bottom] = range(a.y, b.y, c.y, height);
    for (int row = top; row < bottom; ++row) {
      for (int column = left; column < right; ++column) {
        const double x = column + 0.5, y = row + 0.5;
        const double at_b = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
        const double at_c = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
        if (at_b < 0 || at_c < 0 || at_b + at_c > 1) continue;
        const std::size_t i =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
        const double z = a.z + at_b * (b.z - a.z) + at_c * (c.z - a.z);
        if (z <= depth[i]) continue;
        depth[i] = z;
        light[i] = brightness;
      }
    }
  }
};

}  // namespace

Image DrawToolIcon(const Tool& tool, int width, int height) {
  TriangleMesh mesh = MakeToolLooks(tool).whole;
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  const Pose X_TP = FindFrame(tool, box);
  Box3 seen;
  for (Vec3& p : mesh.points) {
    p = X_TP.InversePoint(p);
    seen.Include(p);
  }
  Canvas canvas{kSamples * width, kSamples * height};
  const double margin = kMargin * canvas.height;
  const double scale =
      std::min((canvas.width - 2 * margin) / seen.size().x, (canvas.height - 2 * margin) / seen.size().y);
  const Vec3 middle = seen.centre();
  const auto place = [&](const Vec3& p) {
    return Vec3(0.5 * canvas.width + scale * (p.x - middle.x), 0.5 * canvas.height - scale * (p.y - middle.y), p.z);
  };
  for (const auto& triangle : mesh.triangles) {
    const Vec3 &a = mesh.points[triangle[0]], &b = mesh.points[triangle[1]], &c = mesh.points[triangle[2]];
    const Vec3 across = glm::cross(b - a, c - a);
    const double length = glm::length(across);
    if (!(length > 0)) continue;
    canvas.Draw(place(a), place(b), place(c), std::abs(glm::dot(across / length, kLight)));
  }
  Image image{width, height, {}};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      double sum[3] = {0, 0, 0};
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const std::size_t i =
            static_cast<std::size_t>(row * kSamples + k / kSamples) * static_cast<std::size_t>(canvas.width) +
            static_cast<std::size_t>(column * kSamples + k % kSamples);
        const bool ground = std::isinf(canvas.depth[i]);
        for (int j = 0; j < 3; ++j)
          sum[j] += ground ? kGround[static_cast<std::size_t>(j)] : 45 + j * 6 + 135 * canvas.light[i];
      }
      Rgb8 pixel{};
      for (std::size_t j = 0; j < 3; ++j) pixel[j] = static_cast<std::uint8_t>(sum[j] / (kSamples * kSamples));
      image.pixels.push_back(pixel);
    }
  }
  return image;
}

}  // namespace kerf
