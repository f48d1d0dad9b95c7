#include "app/window/slices_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "session/marks/structures.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr std::array kKinds{SliceKind::kAxial, SliceKind::kCoronal, SliceKind::kSagittal, SliceKind::kBlade};
constexpr double kScroll_mm = 0.5;    // per notch of the wheel
constexpr double kWindowDrag_HU = 4;  // per point of a right drag

/// Returns the slice and its position as shown, for example "axial, 35.1 mm up".
std::string DescribeSlice(const SliceSpec& spec) {
  if (spec.kind == SliceKind::kBlade) {
    if (spec.offset_mm == 0) return NameOf(spec.kind);
    return fmt::format(fmt::runtime(Tr("{} mm beside the blade")), ShowNumber(spec.offset_mm, 1));
  }
  const int axis = spec.kind == SliceKind::kSagittal ? 0 : spec.kind == SliceKind::kCoronal ? 1 : 2;
  return DescribeSliceAt(spec.kind, axis, spec.centre_W[axis] + spec.offset_mm);
}

/// Returns the point whose circle is under the mouse; those in the slice come first.
std::optional<std::size_t> FindPointAt(const SliceFrame& frame, const SliceScene& contents, const OverlayPoint& under,
                                       double pixels_per_point) {
  constexpr double kInSlice_mm = 1;  // as they are drawn
  std::optional<std::size_t> found;
  double best = 1e9;
  for (std::size_t k = 0; k < contents.points.size(); ++k) {
    const OverlayPoint at = frame.PixelOf(contents.points[k].p_W);
    const bool in_slice = std::abs(frame.DistanceOf(contents.points[k].p_W)) <= kInSlice_mm;
    const double away = std::hypot(at.column - under.column, at.row - under.row) / pixels_per_point;
    if (away > (in_slice ? 9 : 6)) continue;
    const double rank = away + (in_slice ? 0 : 100);
    if (rank >= best) continue;
    best = rank;
    found = k;
  }
  return found;
}

}  // namespace

std::string DescribeSliceAt(SliceKind kind, int axis, double at_mm) {
  return fmt::format("{}, {}", NameOf(kind), Translate(DescribePlaceAlong(axis, at_mm)));
}

void DragGreys(float right, float down, double& level_HU, double& width_HU) {
  level_HU -= kWindowDrag_HU * static_cast<double>(down);
  width_HU = SlicesPanel::kWindowRange_HU.Clamp(width_HU + kWindowDrag_HU * static_cast<double>(right));
}

std::optional<double> CalcSliceBar(double width_mm, double side_px, float scale) {
  const double bar_px = kSliceBar_mm * side_px / width_mm;
  if (bar_px < 8 * static_cast<double>(scale) || bar_px > 0.6 * side_px) return std::nullopt;
  return bar_px;
}

const char* NameOf(SliceKind kind) {
  switch (kind) {
    case SliceKind::kAxial:
      return Tr("axial");
    case SliceKind::kCoronal:
      return Tr("coronal");
    case SliceKind::kSagittal:
      return Tr("sagittal");
    case SliceKind::kBlade:
      break;
  }
  return Tr("in the blade's plane");
}

void SlicesPanel::Reset(const Box3& bounds_W) {
  const Vec3 size = bounds_W.size();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    views_[i] = {};
    views_[i].spec.kind = kKinds[i];
    views_[i].spec.centre_W = bounds_W.centre();
    views_[i].spec.width_mm = std::clamp(0.6 * std::max({size.x, size.y, size.z}), 40.0, 80.0);
  }
  enlarged_.reset();
  cursor_W_.reset();
}

void SlicesPanel::Update(SurfaceWorker& surface, const SliceScene& contents, const Vec3& focus_W,
                         const std::optional<Vec3>& point_W, bool renew) {
  if (!contents.tool && enlarged_ && views_[*enlarged_].spec.kind == SliceKind::kBlade) Shrink();
  if (point_W_ != point_W && !std::exchange(keeps_offsets_, false)) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      SliceView& view = views_[i];
      if (view.spec.kind == SliceKind::kBlade) continue;
      // Without a point, all go back to the saw, except one that stays enlarged.
      if (point_W ? !view.still_W : enlarged_ != i) view.spec.offset_mm = 0;
    }
  }
  point_W_ = point_W;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    SliceView& view = views_[i];
    SliceSpec& spec = view.spec;
    const double side = enlarged_ == i ? large_side_px_ : side_px_;
    spec.width_px = spec.height_px = static_cast<int>(kSliceSide_px.Clamp(std::round(side)));
    spec.window = window_;
    spec.X_WT = contents.X_WT;
    if (spec.kind == SliceKind::kBlade) {
      spec.centre_W = contents.X_WT.p_AB;
    } else {
      if (!point_W && !cursor_W_ && enlarged_ != i) view.still_W.reset();
      spec.centre_W = view.still_W.value_or(point_W.value_or(cursor_W_.value_or(focus_W)));
    }
    if (!renew && view.requested && *view.requested == spec) continue;
    surface.RequestSlice(static_cast<int>(i), spec);
    view.requested = spec;
  }
  for (auto& [i, image] : surface.FetchSliceImages()) {
    SliceView& view = views_[static_cast<std::size_t>(i)];
    view.image = std::move(image);
    ++view.version;
  }
}

SlicesPanel::BeforeClick SlicesPanel::NoteBeforeClick() const {
  BeforeClick before{cursor_W_, {}};
  for (std::size_t i = 0; i < views_.size(); ++i) before.views[i] = {views_[i].spec.offset_mm, views_[i].still_W};
  return before;
}

void SlicesPanel::GoBackTo(const BeforeClick& before) {
  cursor_W_ = before.cursor_W;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    std::tie(views_[i].spec.offset_mm, views_[i].still_W) = before.views[i];
  }
  keeps_offsets_ = true;
}

/// Keeps a slice as it is while the others follow the point or the cursor that was set in it.
void SlicesPanel::HoldOnly(std::size_t i) {
  const Vec3 middle_W = views_[i].spec.centre_W;
  for (SliceView& view : views_) view.still_W.reset();
  if (views_[i].spec.kind != SliceKind::kBlade) views_[i].still_W = middle_W;
}

/// Sets, moves and takes back points, sets the cursor, and enlarges. `under`: pixel of the slice under the mouse.
void SlicesPanel::TakeMouse(std::size_t i, const OverlayPoint& under, double pixels_per_point, bool large,
                            const SliceScene& contents, const SlicePoints& points) {
  SliceView& view = views_[i];
  const SliceFrame& frame = view.image->frame;
  const ImGuiIO& io = ImGui::GetIO();
  if (drag_) {
    if (!ImGui::IsMouseDown(0) || drag_->point >= contents.points.size()) return drag_.reset();
    if (io.MouseDelta.x == 0 && io.MouseDelta.y == 0) return;
    // Along the slice, at the distance from it that the point has.
    const double away_mm = frame.DistanceOf(contents.points[drag_->point].p_W);
    points.move(drag_->point, frame.PointOf(under) + away_mm * frame.X_WS.Vector({0, 0, 1}),
                !std::exchange(drag_->moved, true));
    return;
  }
  if (ImGui::IsMouseDoubleClicked(0)) {
    // Its first click was not meant as a point, and what it changed is taken back.
    if (std::exchange(took_point_, false)) points.take_back();
    GoBackTo(before_click_);
    enlarged_ = enlarged_ == i ? std::nullopt : std::optional(i);
    if (enlarged_ && (point_W_ || cursor_W_) && view.spec.kind != SliceKind::kBlade) view.still_W = view.spec.centre_W;
    return;
  }
  if (!ImGui::IsMouseClicked(0)) return;
  before_click_ = NoteBeforeClick();
  took_point_ = false;
  if (const std::optional<std::size_t> point = FindPointAt(frame, contents, under, pixels_per_point)) {
    drag_ = Drag{.view = i, .large = large, .point = *point};
    HoldOnly(i);
  } else if (points.wanted) {
    took_point_ = true;
    HoldOnly(i);
    points.take(frame.PointOf(under));
  } else if (view.spec.kind != SliceKind::kBlade) {
    HoldOnly(i);
    cursor_W_ = frame.PointOf(under);
    for (SliceView& other : views_) {
      if (!other.still_W) other.spec.offset_mm = 0;
    }
  }
}

void SlicesPanel::DrawOne(Ui& ui, std::size_t i, float side, const SliceScene& contents, const SlicePoints& points) {
  SliceView& view = views_[i];
  const float s = ui.scale();
  ImGui::PushID(static_cast<int>(i));
  ImGui::PushFont(ui.small());
  const char* const back = Tr("reset");
  const bool scrolled = view.spec.offset_mm != 0;
  const float back_px = scrolled ? ImGui::CalcTextSize(back).x + 12 * s : 0;
  FittedText(ui, DescribeSlice(view.spec), side - back_px);
  Tooltip(ui, Tr(ExplainPlaces()));
  if (scrolled) {
    ImGui::SameLine();
    ImGui::SetCursorPosX(ImGui::GetCursorStartPos().x + side - back_px + 6 * s);
    if (ImGui::SmallButton(back)) view.spec.offset_mm = 0;
    ui.Note(fmt::format("slice {} back", i + 1));
    Tooltip(ui, fmt::format(fmt::runtime(Tr("The wheel has moved this slice by {} mm. This brings it back.")),
                            ShowNumber(std::abs(view.spec.offset_mm), 1)));
  }
  ImGui::PopFont();
  if (!view.image) {
    ImGui::Dummy({side, side});
    ImGui::PopID();
    return;
  }
  const SliceImage& image = *view.image;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::Image(ui.Texture(fmt::format("slice {}", i), image.image, view.version), {side, side});
  const bool hovered = ImGui::IsItemHovered();
  has_wheel_ = has_wheel_ || hovered;
  ui.Note(fmt::format("slice {}", i + 1));
  const double zoom = static_cast<double>(side) / image.frame.width;
  ImGuiIO& io = ImGui::GetIO();

  // Lines of the bone, planes, marks, the tool and the cursor.
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRect(at, {at.x + side, at.y + side}, true);
  SliceScene all = contents;
  all.cursor_W = cursor_W_;
  const std::vector<SliceLine> drawn = CalcSliceLines(image.frame, all);
  const auto draw = [&](const SliceLine& line) {
    std::vector<ImVec2> drawn_points;
    for (const OverlayPoint& p : line.points) {
      drawn_points.push_back({at.x + static_cast<float>(zoom * p.column), at.y + static_cast<float>(zoom * p.row)});
    }
    const float width = static_cast<float>(line.width_points) * s;
    const ImU32 colour = ToImU32(line.colour);
    if (!line.dashed) {
      list.AddPolyline(drawn_points.data(), static_cast<int>(drawn_points.size()), colour, 0, width);
      return;
    }
    for (std::size_t k = 0; k + 1 < drawn_points.size(); k += 2) {
      list.AddLine(drawn_points[k], drawn_points[k + 1], colour, width);
    }
  };
  for (const SliceLine& line : image.lines) draw(line);
  for (const SliceLine& line : drawn) {
    draw(line);
    if (line.kind != SliceLineKind::kPoint) continue;
    // The number of a point is on its right.
    const OverlayPoint& p = line.points.front();
    AddCasedText(list, {at.x + static_cast<float>(zoom * p.column) + 2 * s, at.y + static_cast<float>(zoom * p.row)},
                 ToImU32(line.colour), line.name);
  }
  const auto letter = [&](const std::string& text, float x, float y) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    list.AddRectFilled({x - 0.5F * size.x - 3, y}, {x + 0.5F * size.x + 3, y + size.y}, IM_COL32(0, 0, 0, 140));
    list.AddText({x - 0.5F * size.x, y}, IM_COL32_WHITE, text.c_str());
  };
  letter(image.right_letter, at.x + side - 12 * s, at.y + 0.5F * side - 8 * s);
  letter(image.left_letter, at.x + 12 * s, at.y + 0.5F * side - 8 * s);
  letter(image.up_letter, at.x + 0.5F * side, at.y + 2 * s);
  list.PopClipRect();

  const OverlayPoint under{static_cast<double>(io.MousePos.x - at.x) / zoom,
                           static_cast<double>(io.MousePos.y - at.y) / zoom};
  const bool large = side == large_side_px_ && enlarged_ == i;
  const bool drags = drag_ && drag_->view == i && drag_->large == large;
  if (hovered || drags) TakeMouse(i, under, static_cast<double>(s) / zoom, large, contents, points);
  if (hovered) {
    if (io.MouseWheel != 0) {
      if (io.KeyCtrl) {
        view.spec.width_mm =
            std::clamp(view.spec.width_mm * std::pow(0.85, static_cast<double>(io.MouseWheel)), 5.0, 500.0);
      } else {
        view.spec.offset_mm += kScroll_mm * static_cast<double>(io.MouseWheel);
      }
    }
    if (ImGui::IsMouseDragging(1, 0)) {
      DragGreys(io.MouseDelta.x / s, io.MouseDelta.y / s, window_.level_HU, window_.width_HU);
    }
  }
  ImGui::PushFont(ui.small());
  const auto note = [&](const std::string& text, float x) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const float y = at.y + side - 16 * s;
    list.AddRectFilled({x - 3 * s, y - s}, {x + size.x + 3 * s, y + size.y + s}, IM_COL32(0, 0, 0, 170));
    list.AddText({x, y}, IM_COL32_WHITE, text.c_str());
    return size.x;
  };
  float used = 0;
  if (scrolled && view.spec.kind != SliceKind::kBlade) {
    const std::string text =
        fmt::format(fmt::runtime(Tr("scrolled by {} mm")), ShowNumber(std::abs(view.spec.offset_mm), 1));
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const ImVec2 from{at.x + 4 * s, at.y + 4 * s};
    list.AddRectFilled({from.x - 3 * s, from.y - s}, {from.x + size.x + 3 * s, from.y + size.y + s},
                       IM_COL32(0, 0, 0, 170));
    list.AddText(from, IM_COL32_WHITE, text.c_str());
  }
  if (image.has_ct) {
    used = note(fmt::format(fmt::runtime(Tr("level {} / width {} HU")), ShowNumber(window_.level_HU, 0),
                            ShowNumber(window_.width_HU, 0)),
                at.x + 4 * s);
  }
  const std::string width = fmt::format(fmt::runtime(Tr("{} mm wide")), ShowNumber(view.spec.width_mm, 0));
  const float width_px = ImGui::CalcTextSize(width.c_str()).x;
  if (used + width_px + 16 * s < side) note(width, at.x + side - width_px - 4 * s);
  if (const std::optional<double> bar_px = CalcSliceBar(view.spec.width_mm, static_cast<double>(side), s)) {
    // At the right, above the notes.
    const float right = at.x + side - 6 * s;
    const float left = right - static_cast<float>(*bar_px);
    const float y = at.y + side - 24 * s;
    const std::string label = fmt::format("{} mm", ShowNumber(kSliceBar_mm, 0));
    const ImVec2 size = ImGui::CalcTextSize(label.c_str());
    const float text_left = std::min(0.5F * (left + right - size.x), right - size.x);
    list.AddRectFilled({std::min(left, text_left) - 3 * s, y - size.y - 4 * s}, {right + 3 * s, y + 4 * s},
                       IM_COL32(0, 0, 0, 170));
    list.AddLine({left, y}, {right, y}, IM_COL32_WHITE, 2 * s);
    for (const float x : {left, right}) list.AddLine({x, y - 3 * s}, {x, y + 3 * s}, IM_COL32_WHITE, s);
    list.AddText({text_left, y - size.y - 3 * s}, IM_COL32_WHITE, label.c_str());
  }
  ImGui::PopFont();
  const char* const does =
      points.wanted
          ? Tr("wheel: scroll   Ctrl + wheel: zoom   click: set a point   drag a point to move it   right drag: grey "
               "levels   double click: enlarge")
          : Tr("wheel: scroll   Ctrl + wheel: zoom   click: cursor   right drag: grey levels   double click: enlarge");
  TooltipBeside(ui, enlarged_ ? "" : does);
  ImGui::PopID();
}

void SlicesPanel::Draw(Ui& ui, const UiBox& column, const UiBox& scene, const SliceScene& contents,
                       const SlicePoints& points) {
  const float s = ui.scale();
  has_wheel_ = false;
  if (BeginPanel(ui, "slices", column, true, false)) {
    const float width = std::min(static_cast<float>(column.width) - 20 * s, ImGui::GetContentRegionAvail().x);
    // Three slices fit; the one in the blade's plane is below them.
    const float height = static_cast<float>(column.height) / 3 - 26 * s;
    side_px_ = std::max(60.0F, std::min(width, height));
    if (!contents.note.empty()) ImGui::TextWrapped("%s", contents.note.c_str());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (contents.tool || views_[i].spec.kind != SliceKind::kBlade) DrawOne(ui, i, side_px_, contents, points);
    }
    if (cursor_W_) {
      if (ImGui::SmallButton(Tr("Follow the saw again"))) {
        cursor_W_.reset();
        for (SliceView& view : views_) view.still_W.reset();
      }
      ui.Note("slices.follow");
    }
    ScrollColumn(has_wheel_);
    EndPanel();
  }
  if (!enlarged_) return;
  const auto side = static_cast<float>(std::min(scene.width, scene.height)) - 56 * s;
  if (side < 100 * s) return;
  large_side_px_ = side;
  ImGui::SetNextWindowPos({static_cast<float>(scene.left + 0.5 * scene.width) - 0.5F * side - 12 * s,
                           static_cast<float>(scene.top) + 6 * s});
  ImGui::SetNextWindowSize({side + 24 * s, side + 44 * s});
  ImGui::Begin("enlarged slice", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
  DrawOne(ui, *enlarged_, side, contents, points);
  ImGui::End();
}

void ScrollColumn(bool wheel_is_used) {
  constexpr float kLines = 5;  // per notch of the wheel, as in other panels
  const ImGuiIO& io = ImGui::GetIO();
  if (wheel_is_used || io.MouseWheel == 0 || io.KeyCtrl || !ImGui::IsWindowHovered()) return;
  ImGui::SetScrollY(ImGui::GetScrollY() - kLines * ImGui::GetFontSize() * io.MouseWheel);
}

}  // namespace kerf
