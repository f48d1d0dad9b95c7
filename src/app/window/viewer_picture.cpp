// The picture: view, bone, saw, slices and lines of planes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "app/window/viewer_app.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "bone/grid/removed.h"
#include "bone/grid/set_leaf.h"
#include "cut/tool/edge_motion.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kSlicePeriod_s = 0.25;  // of slices while the bone is cut
constexpr double kLinePeriod_s = 1;      // of the planes' lines on the bone
constexpr std::array<View, 7> kViews{View::kThreeQuarter, View::kFront, View::kLeft,  View::kRight,
                                     View::kTop,          View::kBack,  View::kBottom};

/// Returns whether a view that shows one of two boxes well may show the other one badly.
bool NeedOtherViews(const Box3& a, const Box3& b) {
  constexpr double kSame = 0.1;  // of the diagonal; a coarse preview differs from its bone by much less
  const double diagonal = glm::length(a.size());
  return glm::length(a.lower - b.lower) > kSame * diagonal || glm::length(a.upper - b.upper) > kSame * diagonal;
}

}  // namespace

/// Draws the bone that another thread has made.
void ViewerApp::TakeBone(bool at_once) {
  if (!bone_.Take(at_once)) return;
  // A view that the user has chosen is kept, unless it belongs to another bone: the whole head of a CT is shown until
  // its mandible is ready.
  const Box3 bounds_W = bone_.surface()->bounds_W();
  const bool other = fitted_ && NeedOtherViews(fitted_bounds_W_, bounds_W);
  if (!fitted_) view_->camera().Look(kViews[view_index_]);
  if (other) view_changed_ = false;
  if (!fitted_ || other) view_->FitAll();
  fitted_ = true;
  fitted_bounds_W_ = bounds_W;
  fit_again_ = !view_changed_;
  slices_.Reset(bounds_W);
  lined_planes_.clear();
}

void ViewerApp::FollowBone() {
  TakeBone();
  // The view was fitted to the bone's box; fit it again once all of the surface is shown.
  const bool complete = fit_again_ && !view_changed_ && bone_.surface()->first_done();
  bone_.Update(times_.upload);
  if (!complete) return;
  fit_again_ = false;
  view_->FitAll();
}

void ViewerApp::LookNext(int by) {
  const auto count = static_cast<int>(kViews.size());
  view_index_ = static_cast<std::size_t>((static_cast<int>(view_index_) + by + count) % count);
  view_->camera().Look(kViews[view_index_]);
  view_->FitAll();
  shown_place_.reset();
  view_changed_ = true;
  seen_from_ = fmt::format(fmt::runtime(Tr("Seen from: {}")), Tr(ToString(kViews[view_index_])));
  Say(seen_from_);
}

void ViewerApp::ShowPlace(ShownPlace place) {
  shown_place_ = std::move(place);
  shown_in_ = {};
  view_changed_ = true;
  FollowPlace();
}

void ViewerApp::FollowPlace() {
  if (!shown_place_) return;
  const UiBox free = shown_place_->free(areas_.scene);
  if (free.empty()) return;
  const bool same = free.left == shown_in_.left && free.top == shown_in_.top && free.width == shown_in_.width &&
                    free.height == shown_in_.height;
  std::vector<Vec3> points_W = shown_place_->points_W;
  bool left = false;
  if (is_running() && began_ && activity_->cuts()) {
    const ScreenBox tool = view_->CalcToolBox();
    left = tool.left < free.left || tool.left + tool.width > free.right() || tool.top < free.top ||
           tool.top + tool.height > free.bottom();
    const double reach_mm = CalcReach(MakeTool(session_->scene()));
    for (const Vec3& p_T : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{-1, 0, 0}, Vec3{0, -1, 0}}) {
      // The corners of the square around a disc.
      points_W.push_back(figures_.coupled.X_WT.Point(reach_mm * (p_T + Vec3{-p_T.y, p_T.x, 0})));
    }
  }
  if (same && !left) return;
  shown_in_ = free;
  view_->FitPoints(points_W, {free.left, free.top, free.width, free.height});
}

/// Fits the view to the bone and the saw.
void ViewerApp::ShowSaw() {
  if (!bone_.surface()) return;
  const Box3 bounds_W = bone_.surface()->bounds_W();
  const Pose& X_WT = figures_.coupled.X_WT;
  const double reach_mm = CalcReach(MakeTool(session_->scene()));
  std::vector<Vec3> points_W;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at(corner & 1, corner / 2 & 1, corner / 4);
    points_W.push_back(bounds_W.lower + at * bounds_W.size());
    points_W.push_back(X_WT.Point(reach_mm * (2.0 * at - 1.0)));
  }
  const UiBox& area = areas_.scene;
  view_->FitPoints(points_W, {area.left, area.top, area.width, area.height});
}

void ViewerApp::ShowUncut() {
  const std::shared_ptr<const Bone> start = bone_at_start();
  if (!start || !bone_.surface()) return;
  const std::shared_ptr<CutWatch> watch = cut_watch();
  for (const std::array<int, 3>& index : FindChangedLeaves(bone_.surface()->CopyBone(), *start)) {
    LeafMessage leaf{.index = index};
    GetCut(*start, index, leaf.values);
    bone_.surface()->Offer(leaf);
    if (watch) watch->Offer(index, leaf.values);
  }
}

void ViewerApp::UpdateToolInPicture(double dt_s) {
  if (!session_ || !began_) return;
  spin_rad_ = std::fmod(spin_rad_ + figures_.in.rpm / 60 * 2 * std::numbers::pi * dt_s, 2 * std::numbers::pi);
  const Pose& X_WT = figures_.coupled.X_WT;
  view_->SetToolPose(X_WT, figures_.in.rpm, spin_rad_, figures_.coupled.displacement_mm);
  if (!X_holder_ || X_holder_->p_AB != X_WT.p_AB || X_holder_->R_AB != X_WT.R_AB) {
    X_holder_ = X_WT;
    const bool hub_was_in_bone = holder_.hub_in_bone();
    if (const std::shared_ptr<const Bone> bone = bone_at_start()) holder_.Update(*bone, X_WT);
    view_->SetHandpieceInBone(holder_.handpiece_in_bone());
    if (holder_.hub_in_bone() != hub_was_in_bone) trace_.Write("hub", {{"in_bone", holder_.hub_in_bone()}});
    // It stays long enough to be read, also if the saw is soon through.
    const std::string holder = DescribeHolder();
    const bool begins = !std::exchange(holds_in_bone_, !holder.empty()) && holds_in_bone_;
    if (begins && !is_warning(holder)) Warn(holder);
  }
  if (options_.watch && spindle_on() && TouchesBone(figures_.coupled)) holder_.NoteCut();
  const Tool tool = MakeTool(session_->scene());
  UpdateCutInPicture(tool, dt_s);
  const bool leads =
      options_.ghost && !options_.scripted && glm::length(controls_->wanted().p_AB - figures_.coupled.X_WT.p_AB) > 1;
  view_->SetGhost(leads ? std::optional(controls_->wanted()) : std::nullopt);
  const double force_N = glm::length(figures_.coupled.f_H_W_N);
  view_->SetForce(force_N > 0.05 && activity_->cuts()
                      ? std::optional(ForceArrow{
                            .p_W = figures_.coupled.X_WT.p_AB,
                            .f_W_N = figures_.coupled.f_H_W_N,
                            .label = fmt::format(fmt::runtime(Tr("{} N on your hand")), ShowNumber(force_N, 1))})
                      : std::nullopt);
  if (!bone_.surface() || !slices_shown_) return;
  const bool renew = figures_.changes != sliced_changes_ && now_s_ > sliced_s_ + kSlicePeriod_s;
  if (renew) {
    sliced_changes_ = figures_.changes;
    sliced_s_ = now_s_;
  }
  // The slices go through the place of contact or, without contact, through the rim's point that faces the bone.
  Vec3 focus_W = X_WT.p_AB;
  if (cut_place_.p_W()) {
    focus_W = *cut_place_.p_W();
  } else if (CalcStroke(tool) == 0) {  // the origin of a blade with a stroke is on its edge
    const Vec3 spindle_W = X_WT.Vector({0, 0, 1});
    const Vec3 to_bone_W = bone_.surface()->bounds_W().centre() - X_WT.p_AB;
    if (const auto in_plane_W = CalcDirection(to_bone_W - glm::dot(to_bone_W, spindle_W) * spindle_W)) {
      focus_W += CalcReach(tool) * *in_plane_W;
    }
  }
  slices_.Update(*bone_.surface(), MakeSliceScene(), activity_->slice_focus().value_or(focus_W),
                 activity_->slice_point(), renew);
}

void ViewerApp::ShowCt(CtSource ct) {
  bone_.set_ct(std::move(ct));
  sliced_changes_.reset();  // all slices are computed again
}

void ViewerApp::UpdateCutInPicture(const Tool& tool, double dt_s) {
  if (!activity_->cuts()) {  // the tool is not shown
    view_->SetContact(std::nullopt);
    view_->SetAlarms({});
    view_->AdvanceDust(dt_s);
    return;
  }
  const Pose& X_WT = figures_.coupled.X_WT;
  cut_place_.Update(tool, X_WT, figures_.coupled.f_cut_W_N + figures_.coupled.f_face_W_N, dt_s, bone_at_start().get());
  view_->SetContact(cut_place_.p_W());
  const double removed_mm3 = figures_.removed_mm3 - std::exchange(shown_removed_mm3_, figures_.removed_mm3);
  if (cut_place_.p_W()) {
    const double turns_per_s = figures_.in.rpm / 60;
    const Vec3 spin_W = turns_per_s * 2 * std::numbers::pi * X_WT.Vector({0, 0, 1});
    Vec3 v_W = glm::cross(spin_W, *cut_place_.p_W() - X_WT.p_AB);
    if (const double stroke_mm = CalcStroke(tool); stroke_mm > 0) {
      const double way = figures_.coupled.displacement_mm < 0 ? -1 : 1;
      const Vec3 p_T = X_WT.InversePoint(*cut_place_.p_W());
      v_W = X_WT.Vector(EdgeMotion(CalcSwingRadius(tool)).CalcVelocity(p_T, way * 2 * stroke_mm * turns_per_s));
    }
    view_->AddDust(*cut_place_.p_W(), v_W, removed_mm3);
  }
  view_->AdvanceDust(dt_s);
  std::vector<AlarmOverlay> alarms;
  activity_->AddAlarms(alarms);
  view_->SetAlarms(alarms);
  if (!bone_.surface()) return;
  if (const auto lines = bone_.surface()->FetchPlaneLines()) view_->SetPlaneLines(*lines);
}

void ViewerApp::RequestPlaneLines(const std::vector<PlaneOverlay>& planes) {
  if (!bone_.surface()) return;
  const bool changed = figures_.changes != lined_changes_ && now_s_ > lined_s_ + kLinePeriod_s;
  if (planes == lined_planes_ && !changed) return;
  lined_planes_ = planes;
  lined_changes_ = figures_.changes;
  lined_s_ = now_s_;
  bone_.surface()->RequestPlaneLines(planes);
}

void ViewerApp::HidePlaneLines() {
  lined_planes_.clear();
  view_->SetPlaneLines({});
}

SliceScene ViewerApp::MakeSliceScene() const {
  SliceScene scene;
  if (session_ && began_) {
    scene.tool = MakeTool(session_->scene());
    scene.X_WT = figures_.coupled.X_WT;
    scene.displacement_mm = figures_.coupled.displacement_mm;
  }
  activity_->FillSlices(scene);
  return scene;
}

ViewBasis ViewerApp::MakeBasis() const {
  const ViewCamera& camera = view_->camera();
  return {.right_W = camera.right_W(),
          .up_W = camera.up_W(),
          .forward_W = camera.forward_W(),
          .mm_per_pixel = camera.WorldPerPixel(figures_.coupled.X_WT.p_AB)};
}

/// Writes the pictures of the window that were asked for to the folder. In the first frames, the panels are not
/// complete yet.
void ViewerApp::TakePictures() {
  constexpr int kFirstFrames = 4;
  drawn_frames_ = std::min(drawn_frames_ + 1, kFirstFrames);
  if (pictures_asked_ == 0 || drawn_frames_ < kFirstFrames) return;
  try {
    for (; pictures_asked_ > 0; --pictures_asked_) {
      std::string path;
      do {
        path = fmt::format("{}/picture-{:03d}.png", options_.folder, ++pictures_);
      } while (std::filesystem::exists(path));
      window_.BeginFrame();
      view_->Render();
      redraws_ = true;
      WritePng(view_->Grab(), path);
      trace_.Write("picture", {{"file", path}, {"frames", times_.frame.total()}});
      Say(fmt::format(fmt::runtime(Tr("Picture: {}")), path));
    }
  } catch (const Error& e) {
    pictures_asked_ = 0;
    Say(e.what());
  }
}

std::string ViewerApp::GrabScene(const std::vector<Vec3>& clear_W) {
  const ViewCamera camera = view_->camera();
  const Theme theme = view_->theme();
  view_->set_theme(Theme::kLight);
  ui_.set_theme(Theme::kLight);
  // The cube with the patient's sides is at the lower right.
  const double cube = 96 * ui_.scale();
  const double rim = 8 * ui_.scale();
  const ScreenBox cube_box{ui_.width() - cube - rim, ui_.height() - cube - rim, cube, cube};
  view_->SetAreas({0, 0, ui_.width(), ui_.height()}, cube_box);
  view_->FitAll();
  // A frame of the panels that has labels and scale bar only.
  ui_.BeginFrame(1.0 / 60);
  PictureMarks marks = MakePictureMarks();
  marks.avoids_panels = false;
  constexpr double kClear_mm = 12;  // around a place
  for (const Vec3& p_W : clear_W) {
    const std::optional<ScreenPoint> at = view_->camera().Project(p_W);
    const double r = kClear_mm / std::max(marks.mm_per_pixel, 1e-9);
    if (at) marks.kept_clear.push_back({at->x - r, at->y - r, 2 * r, 2 * r});
  }
  marks.kept_clear.push_back({cube_box.left, cube_box.top, cube, cube});
  DrawPictureMarks(ui_, marks, {0, 0, ui_.width(), ui_.height()});
  ui_.EndFrame();
  window_.BeginFrame();
  view_->Render();
  redraws_ = true;
  const Image image = view_->Grab();
  view_->set_theme(theme);
  ui_.set_theme(theme);
  view_->camera() = camera;  // the next frame sets the areas again
  const TemporaryFolder folder("kerf_scene");
  const std::string path = folder.path() + "/picture.png";
  WritePng(image, path);
  return ReadTextFile(path);
}

}  // namespace kerf
