#include "cli/assess_picture.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>

#include "files/files.h"
#include "kerf/error.h"
#include "render/picture.h"

namespace kerf::cli {
namespace {

constexpr Rgb8 kPlanned{0, 114, 178};  // blue and vermilion: told apart by the colour-blind too
constexpr Rgb8 kAchieved{213, 94, 0};
constexpr double kPlaneMargin_mm = 4;

/// Light tones, one a piece.
constexpr std::array<Rgb8, 6> kPieceColours{
    {{232, 220, 196}, {196, 214, 232}, {204, 226, 203}, {230, 206, 222}, {226, 214, 180}, {206, 206, 218}}};

/// Of a plane, as wide as the kerf and a little more; a thin plate so that it is seen from both sides.
Shape MakePlate(const CutPlane& plane, const Vec3& middle, const Vec3& u, const Vec3& v, double half_u, double half_v,
                const Rgb8& colour) {
  Shape shape;
  const Vec3 p = middle - glm::dot(plane.normal_W, middle - plane.p_W) * plane.normal_W;
  for (const double side : {-0.05, 0.05}) {
    for (const int corner : {0, 1, 2, 3}) {
      const double a = corner == 0 || corner == 3 ? -half_u : half_u;
      const double b = corner < 2 ? -half_v : half_v;
      shape.mesh_W.points.push_back(p + a * u + b * v + side * plane.normal_W);
    }
  }
  shape.mesh_W.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}};
  shape.colour = colour;
  shape.opacity = 0.45;
  return shape;
}

std::string ReadPng(const PictureSpec& spec) {
  // Beside nothing of the user's.
  const std::filesystem::path place =
      std::filesystem::temp_directory_path() / ("kerf_assess_" + std::to_string(static_cast<long>(getpid())) + ".png");
  WritePicture(spec, place.string());
  std::string png = ReadTextFile(place.string());
  std::error_code ignored;
  std::filesystem::remove(place, ignored);
  return png;
}

}  // namespace

std::vector<TakenPicture> DrawAssessment(const std::string& title, const Assessment& assessment,
                                         const PieceSet& pieces) {
  PictureSpec spec;
  spec.title = title;
  for (int i = 0; i < pieces.size(); ++i) {
    const PieceState& state = pieces.state(i);
    if (state.deleted || state.hidden) continue;
    Shape shape;
    shape.mesh_W = pieces.piece(i).mesh;
    for (Vec3& p : shape.mesh_W.points) p = state.X_WP.Point(p);
    shape.colour = kPieceColours[static_cast<std::size_t>(i) % kPieceColours.size()];
    spec.shapes.push_back(std::move(shape));
  }
  if (spec.shapes.empty()) return {};
  std::optional<Vec3> target;
  double height_mm = 0;
  Vec3 aside(0);
  for (const PlaneResult& result : assessment.planes) {
    if (!result.cut) continue;
    const FittedPlane& cut = *result.cut;
    const Vec3 u = glm::cross(cut.normal_W, cut.depth_W);
    const double half_u = 0.5 * cut.length_mm + kPlaneMargin_mm;
    const double half_v = 0.5 * cut.depth_mm + kPlaneMargin_mm;
    spec.shapes.push_back(MakePlate(result.planned.plane, cut.p_W_mm, u, cut.depth_W, half_u, half_v, kPlanned));
    spec.shapes.push_back(MakePlate({cut.p_W_mm, cut.normal_W}, cut.p_W_mm, u, cut.depth_W, half_u, half_v, kAchieved));
    if (target) continue;
    target = cut.p_W_mm;
    height_mm = 2.6 * std::max(half_u, half_v);
    // Along the plane, across the depth: both planes are seen as lines.
    aside = u - 0.25 * cut.depth_W;
  }
  if (target) spec.legend = {{"planned", kPlanned}, {"achieved", kAchieved}};
  std::vector<TakenPicture> pictures;
  pictures.push_back(
      {.name = "overview", .caption = "The pieces with the planned and the achieved planes", .png = ReadPng(spec)});
  if (target) {
    const Vec3 up = std::abs(glm::normalize(aside).z) < 0.95 ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
    spec.camera = MakeCamera(aside, up, *target, height_mm);
    pictures.push_back({.name = "cut", .caption = "The cut from near, along the first plane", .png = ReadPng(spec)});
  }
  return pictures;
}

}  // namespace kerf::cli
