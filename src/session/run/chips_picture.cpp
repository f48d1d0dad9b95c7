#include "session/run/chips_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kerf/surface.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

constexpr Rgb8 kYoung{213, 94, 0};
constexpr Rgb8 kOld{0, 70, 160};
constexpr double kDrawnPixels = 3.5;  // diameter of a drawn chip; at true scale, chips would be invisible
constexpr double kMargin = 1.06;

/// Adds a coarse sphere.
void AddChip(Shape& shape, const Vec3& p_W, double radius_mm, const Rgb8& colour) {
  const auto first = static_cast<std::uint32_t>(shape.mesh_W.points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-radius_mm, radius_mm}) {
      Vec3 p = p_W;
      p[axis] += side;
      shape.mesh_W.points.push_back(p);
      shape.point_colours.push_back(colour);
    }
  }
  constexpr std::uint32_t kFaces[8][3] = {{1, 3, 5}, {3, 0, 5}, {0, 2, 5}, {2, 1, 5},
                                          {3, 1, 4}, {0, 3, 4}, {2, 0, 4}, {1, 2, 4}};
  for (const auto& f : kFaces) shape.mesh_W.triangles.push_back({first + f[0], first + f[1], first + f[2]});
}

Rgb8 Mix(double fraction) {
  Rgb8 mixed;
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = static_cast<std::uint8_t>(std::lround(kYoung[i] + fraction * (kOld[i] - kYoung[i])));
  }
  return mixed;
}

}  // namespace

ChipsTrack::ChipsTrack(const EffectPlan& plan) : effect_(dynamic_cast<const ChipsEffect*>(plan.Find("chips"))) {
  if (effect_ == nullptr) return;
  params_ = effect_->params();
  p_WF_mm_ = effect_->p_WF_mm();
}

void ChipsTrack::Take(double time_s, const Pose& X_WT) {
  if (effect_ == nullptr || effect_->pool().size() <= (peak_ ? peak_->pool.size() : 0)) return;
  const Moment moment{time_s, X_WT, effect_->pool(), effect_->thrown_mm3(), effect_->dropped_mm3()};
  peak_ = moment;
}

bool WriteChipsPicture(const ChipsTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path) {
  if (!track.peak()) return false;
  const ChipsTrack::Moment& moment = *track.peak();
  const ChipsParams& params = track.params();

  PictureSpec spec;
  spec.title = name + ": the chips";
  spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
  Shape bone_shape;
  bone_shape.mesh_W = ExtractSurface(bone);
  spec.shapes.push_back(std::move(bone_shape));
  spec.tools.push_back(ToolInPicture{tool, moment.X_WT});

  std::vector<Vec3> chips_W;
  for (std::size_t i = 0; i < moment.pool.size(); ++i) {
    chips_W.push_back(moment.pool.CalcChip(i).p_F_mm + track.p_WF_mm());
  }

  // View of the disc's plane, slightly from the side and above, with gravity down.
  const Vec3 g = params.gravity_W_m_per_s2;
  const Vec3 down = glm::length(g) > 0 ? glm::normalize(g) : Vec3(0, 0, -1);
  Vec3 eye = moment.X_WT.Vector({0, 0, 1});
  eye -= glm::dot(eye, down) * down;
  if (glm::length(eye) < 0.1) eye = glm::cross(down, std::abs(down.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0));
  eye = glm::normalize(eye);
  if (glm::dot(eye, Vec3(1, -1, 1)) < 0) eye = -eye;
  eye = glm::normalize(eye - 0.3 * down + 0.25 * glm::cross(down, eye));
  const Vec3 right = glm::normalize(glm::cross(eye, down));
  const Vec3 up = glm::cross(eye, right);
  // Fit the bone, the tool and all chips into the picture.
  Box3 box;  // in the view's axes: right, up and towards the eye
  const auto include = [&](const Vec3& p_W) { box.Include({glm::dot(p_W, right), glm::dot(p_W, up), 0}); };
  for (const Vec3& p_W : spec.shapes[0].mesh_W.points) include(p_W);
  for (const Vec3& p_W : chips_W) include(p_W);
  include(moment.X_WT.p_AB);
  const double height_mm = kMargin * std::max(box.size().y, box.size().x / spec.width * spec.height);
  const Vec3 middle = box.centre();
  spec.camera =
      MakeCamera(eye, up, middle.x * right + middle.y * up + glm::dot(moment.X_WT.p_AB, eye) * eye, height_mm);

  const double drawn_mm = std::max(kDrawnPixels * height_mm / spec.height, params.size_mm);
  Shape chips;
  for (std::size_t i = 0; i < chips_W.size(); ++i) {
    const double age_s = moment.pool.CalcChip(i).age_s;
    AddChip(chips, chips_W[i], 0.5 * drawn_mm, Mix(std::min(1.0, age_s / params.life_s)));
  }
  spec.shapes.push_back(std::move(chips));
  spec.legend.push_back({"just thrown", kYoung});
  spec.legend.push_back({fmt::format("{:g} s ago", params.life_s), kOld});

  const double chip_mm3 = std::numbers::pi / 6 * std::pow(params.size_mm, 3);
  spec.caption = fmt::format(
      "{} chips in the air after {:.2f} s, {:.2f} mm³ of the {:.1f} mm³ thrown so far; {:.1f} mm³ dropped;\n"
      "each {:g} mm across, drawn as {:.1f} mm; bone after the cut",
      moment.pool.size(), moment.time_s, static_cast<double>(moment.pool.size()) * chip_mm3, moment.emitted_mm3,
      moment.dropped_mm3, params.size_mm, drawn_mm);
  WritePicture(spec, path);
  return true;
}

}  // namespace kerf
