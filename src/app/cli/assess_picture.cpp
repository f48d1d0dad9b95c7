#include "app/cli/assess_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/files/files.h"
#include "base/files/temporary.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

constexpr Rgb8 kPlanned{0, 114, 178};  // blue and vermilion: distinguishable for colour-blind people
constexpr Rgb8 kAchieved{213, 94, 0};
constexpr double kPlaneMargin_mm = 4;
constexpr double kPlannedFrame_mm = 2.5;  // by which a planned plane is larger than the achieved one that may hide it

/// Light colours of the pieces; none is a light blue or orange, the colours of the planes.
constexpr std::array<Rgb8, 6> kSheetColours{
    {{232, 220, 196}, {204, 226, 203}, {230, 206, 222}, {212, 212, 212}, {226, 224, 160}, {190, 180, 172}}};

/// A plane that is drawn as a plate.
struct Plate {
  CutPlane plane;
  Vec3 middle;  // projected onto the plane
  Vec3 u;       // directions of its sides
  Vec3 v;
  double half_u;
  double half_v;
  Rgb8 colour;
};

Shape MakePlate(const Plate& plate, double half_thickness_mm, double opacity) {
  const CutPlane& plane = plate.plane;
  const Vec3 p = plate.middle - glm::dot(plane.normal_W, plate.middle - plane.p_W) * plane.normal_W;
  Shape shape;
  for (int corner = 0; corner < 8; ++corner) {
    shape.mesh_W.points.push_back(p + (corner & 1 ? plate.half_u : -plate.half_u) * plate.u +
                                  (corner & 2 ? plate.half_v : -plate.half_v) * plate.v +
                                  (corner & 4 ? half_thickness_mm : -half_thickness_mm) * plane.normal_W);
  }
  shape.mesh_W.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  shape.colour = plate.colour;
  shape.opacity = opacity;
  return shape;
}

/// Returns the mesh slightly enlarged, so that it is visible in front of another one of the same size.
TriangleMesh Stretched(TriangleMesh mesh, const Vec3& about) {
  for (Vec3& p : mesh.points) p = about + 1.02 * (p - about);
  return mesh;
}

std::string ReadPng(const PictureSpec& spec) {
  const TemporaryFolder folder("kerf_assess");
  const std::string place = folder.path() + "/picture.png";
  WritePicture(spec, place);
  return ReadTextFile(place);
}

}  // namespace

std::vector<ExportPicture> DrawAssessment(const std::string& title, const Assessment& assessment,
                                          const PieceSet& pieces, bool of_patient) {
  PictureSpec spec;
  spec.title = title;
  spec.orientation = of_patient ? Orientation::kPatient : Orientation::kAxes;
  for (int i = 0; i < pieces.size(); ++i) {
    const PieceState& state = pieces.state(i);
    if (state.deleted || state.hidden) continue;
    Shape shape;
    shape.mesh_W = pieces.piece(i).mesh;
    for (Vec3& p : shape.mesh_W.points) p = state.X_WP.Point(p);
    shape.colour = kSheetColours[static_cast<std::size_t>(i) % kSheetColours.size()];
    spec.shapes.push_back(std::move(shape));
  }
  if (spec.shapes.empty()) return {};
  std::vector<Plate> plates;
  const PlannedPlane* first_planned = nullptr;
  for (const PlaneResult& result : assessment.planes) {
    if (!result.cut) continue;
    if (first_planned == nullptr) first_planned = &result.planned;
    const FittedPlane& cut = *result.cut;
    const Vec3 u = glm::cross(cut.normal_W, cut.depth_W);
    const Plate planned{.plane = result.planned.plane,
                        .middle = cut.p_W_mm,
                        .u = u,
                        .v = cut.depth_W,
                        .half_u = 0.5 * cut.length_mm + kPlaneMargin_mm,
                        .half_v = 0.5 * cut.depth_mm + kPlaneMargin_mm,
                        .colour = kPlanned};
    plates.push_back(planned);
    plates.back().half_u += kPlannedFrame_mm;
    plates.back().half_v += kPlannedFrame_mm;
    plates.push_back(planned);
    plates.back().plane = {cut.p_W_mm, cut.normal_W};
    plates.back().colour = kAchieved;
  }
  if (!plates.empty()) spec.legend = {{"planned", kPlanned}, {"achieved", kAchieved}};
  const std::size_t bone_shapes = spec.shapes.size();
  for (const Plate& plate : plates) spec.shapes.push_back(MakePlate(plate, 0.02, 0.35));
  std::vector<ExportPicture> pictures;
  pictures.push_back(
      {.name = "overview", .caption = "The pieces with the planned and the achieved planes", .png = ReadPng(spec)});
  if (plates.empty()) return pictures;
  // The view is into the first cut and along its plane, so that the planned and the achieved plane appear as lines.
  const Plate& first = plates[1];
  const PlaneAxes axes = CalcPlaneAxes(*first_planned);
  spec.camera = MakeCutCamera(axes.up_W, axes.normal_W, first.middle, 1);
  const Vec3 right = glm::normalize(glm::cross(spec.camera.up_W, spec.camera.toward_eye_W));
  const Vec3 upwards = glm::normalize(glm::cross(spec.camera.toward_eye_W, right));
  const auto calc_extent_mm = [&](const Vec3& direction) {
    return 2.2 * (first.half_u * std::abs(glm::dot(direction, first.u)) +
                  first.half_v * std::abs(glm::dot(direction, first.v)));
  };
  const double height_mm =
      std::max(calc_extent_mm(upwards), calc_extent_mm(right) * static_cast<double>(spec.height) / spec.width);
  spec.camera.height_mm = height_mm;
  spec.shapes.resize(bone_shapes);
  // The planned plane is drawn as the wider line, so that both lines are visible where they coincide.
  for (std::size_t i = 0; i < plates.size(); ++i) {
    spec.shapes.push_back(MakePlate(plates[i], height_mm / (i % 2 == 0 ? 250 : 600), 1));
    if (i % 2 == 1) spec.shapes.back().mesh_W = Stretched(spec.shapes.back().mesh_W, first.middle);
  }
  pictures.push_back({.name = "cut", .caption = "Close-up of the first cut, seen into the bone", .png = ReadPng(spec)});
  return pictures;
}

}  // namespace kerf::cli
