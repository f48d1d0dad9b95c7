#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/core/vectors.h"
#include "cut/tool/looks.h"
#include "kerf/error.h"
#include "view/picture/layout.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

struct NamedView {
  View view;
  const char* name;
  Vec3 toward_eye_W;
  Vec3 up_W;
};

const std::array<NamedView, 7>& NamedViews() {
  static const std::array<NamedView, 7> views{{
      {View::kFront, "front", {0, -1, 0}, {0, 0, 1}},
      {View::kBack, "back", {0, 1, 0}, {0, 0, 1}},
      {View::kLeft, "left", {1, 0, 0}, {0, 0, 1}},
      {View::kRight, "right", {-1, 0, 0}, {0, 0, 1}},
      {View::kTop, "top", {0, 0, 1}, {0, -1, 0}},
      {View::kBottom, "bottom", {0, 0, -1}, {0, -1, 0}},
      {View::kThreeQuarter, "three-quarter", {0.75, -1, 0.55}, {0, 0, 1}},
  }};
  return views;
}

// Extent of the points of a spec along the picture's right and up directions.
class Span {
 public:
  Span(const Vec3& right, const Vec3& up) : right_(right), up_(up) {}
  void Include(const Vec3& p) { box_.Include({glm::dot(right_, p), glm::dot(up_, p), 0}); }
  const Box3& box() const { return box_; }

 private:
  Vec3 right_;
  Vec3 up_;
  Box3 box_;
};

void IncludeEverything(const PictureSpec& spec, Span& span) {
  if (spec.axes) {
    const Box3 box_W = CalcShapeBox(spec);
    for (int corner = 0; corner < 8 && !box_W.empty(); ++corner) span.Include(CornerOf(box_W, corner));
  }
  for (const Shape& shape : spec.shapes) {
    for (const auto& t : shape.mesh_W.triangles) {
      for (const auto id : t) span.Include(shape.mesh_W.points[id]);
    }
  }
  if (!spec.fit_to_tool) return;
  for (const ToolInPicture& at : spec.tools) {
    for (const Vec3& p_T : MakeToolLooks(at.tool).whole.points) span.Include(at.X_WT.Point(p_T));
  }
  for (const Arrow& arrow : spec.arrows) {
    span.Include(arrow.tail_W);
    span.Include(arrow.tip_W);
  }
}

}  // namespace

const char* ToString(View view) {
  for (const NamedView& named : NamedViews()) {
    if (named.view == view) return named.name;
  }
  return "";
}

std::optional<View> ViewFromString(const std::string& name) {
  for (const NamedView& named : NamedViews()) {
    if (named.name == name) return named.view;
  }
  return std::nullopt;
}

Camera MakeCamera(View view) {
  for (const NamedView& named : NamedViews()) {
    if (named.view == view) return {named.toward_eye_W, named.up_W, std::nullopt, 0};
  }
  return {};
}

Camera MakeCamera(const Vec3& toward_eye_W, const Vec3& up_W, const Vec3& target_W, double height_mm) {
  return {toward_eye_W, up_W, target_W, height_mm};
}

Camera MakeCutCamera(const Vec3& out_W, const Vec3& normal_W, const Vec3& target_W, double height_mm) {
  constexpr double kAside = 0.2;
  Vec3 along_W = glm::cross(out_W, normal_W);
  if (along_W.z < 0) along_W = -along_W;  // from above rather than from below
  const bool is_from_top = std::abs(out_W.z) > 0.9;
  return {out_W + kAside * along_W, is_from_top ? along_W : Vec3(0, 0, 1), target_W, height_mm};
}

Vec3 CornerOf(const Box3& box, int corner) {
  return {(corner & 1) != 0 ? box.upper.x : box.lower.x, (corner & 2) != 0 ? box.upper.y : box.lower.y,
          (corner & 4) != 0 ? box.upper.z : box.lower.z};
}

Box3 CalcShapeBox(const PictureSpec& spec) {
  Box3 box_W;
  for (const Shape& shape : spec.shapes) {
    for (const Vec3& p : shape.mesh_W.points) box_W.Include(p);
  }
  return box_W;
}

ViewFrame::Pixel ViewFrame::Project(const Vec3& p_W) const {
  const Vec3 d = p_W - centre_W;
  return {0.5 * width + pixels_per_mm * glm::dot(right_W, d), 0.5 * height - pixels_per_mm * glm::dot(up_W, d)};
}

ViewFrame CalcViewFrame(const PictureSpec& spec) {
  return CalcViewFrame(spec, Layout(spec));
}

ViewFrame CalcViewFrame(const PictureSpec& spec, const Layout& layout) {
  if (!kPictureSideRange.Contains(spec.width) || !kPictureSideRange.Contains(spec.height)) {
    throw Error(fmt::format("a picture of {} x {} pixels can't be drawn; each side must be {}", spec.width, spec.height,
                            ShowRange(kPictureSideRange, "")));
  }
  const Camera& camera = spec.camera;
  const Vec3 right = glm::cross(camera.up_W, camera.toward_eye_W);
  if (!IsFinite(right) || glm::length(right) < 1e-9) {
    throw Error("the camera's up direction must differ from its line of sight");
  }
  ViewFrame frame{};
  frame.width = spec.width;
  frame.height = spec.height;
  frame.toward_eye_W = glm::normalize(camera.toward_eye_W);
  frame.right_W = glm::normalize(right);
  frame.up_W = glm::cross(frame.toward_eye_W, frame.right_W);
  if (camera.target_W) {
    if (!IsFinite(*camera.target_W) || !(camera.height_mm > 0) || !std::isfinite(camera.height_mm)) {
      throw Error(fmt::format("a camera with a target needs a view height above 0 mm, but got {}", camera.height_mm));
    }
    // The title and the caption hide a band at the top.
    const double band = layout.has_words() ? layout.top_margin : 0;
    frame.pixels_per_mm = (spec.height - band) / camera.height_mm;
    frame.centre_W = *camera.target_W + 0.5 * band / frame.pixels_per_mm * frame.up_W;
    return frame;
  }
  Span span(frame.right_W, frame.up_W);
  IncludeEverything(spec, span);
  if (span.box().empty()) throw Error("there is nothing to draw: the picture has no surface");
  // The contents are fitted below the title and above the scale bar, with a margin.
  const double free_width = spec.width - layout.left_margin - layout.right_margin;
  const double free_height = spec.height - layout.top_margin - layout.bottom_margin;
  const Vec3 size = glm::max(span.box().size(), Vec3{1e-6});
  frame.pixels_per_mm = std::min(free_width / size.x, free_height / size.y);
  const Vec3 middle = span.box().centre();
  // Centres the contents in the free area.
  const double shift_right = 0.5 * (layout.right_margin - layout.left_margin) / frame.pixels_per_mm;
  const double shift_up = 0.5 * (layout.top_margin - layout.bottom_margin) / frame.pixels_per_mm;
  Box3 depth;
  for (const Shape& shape : spec.shapes) {
    for (const Vec3& p : shape.mesh_W.points) depth.Include({glm::dot(frame.toward_eye_W, p), 0, 0});
  }
  const double middle_depth = depth.empty() ? 0 : depth.centre().x;
  frame.centre_W =
      (middle.x + shift_right) * frame.right_W + (middle.y + shift_up) * frame.up_W + middle_depth * frame.toward_eye_W;
  return frame;
}

}  // namespace kerf
