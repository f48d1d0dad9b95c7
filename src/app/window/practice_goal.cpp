// What an exercise shows of its wanted cuts or holes in the picture and in the slices.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/window/practice.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Width of the planned plane around the wanted cut.
constexpr double kPlaneRim_mm = 10;
/// Height that is left to the exercise's card and to that of the replay, points, and its largest share of the scene.
constexpr double kCard = 110;
constexpr double kReplayCard = 66;
constexpr double kMaxCardShare = 0.38;
/// Length of a hole's axis that is shown above the surface.
constexpr double kAxis_mm = 8;

/// Colours of what is wanted: what is made, what comes next, and the rest; light, because slices are grey.
Rgb8 ColourOfCut(bool made, bool current) {
  return made ? Rgb8{0, 158, 115} : current ? Rgb8{230, 159, 0} : Rgb8{86, 180, 233};
}

/// Returns the rectangle of a cut, from its surface to its depth, widened by a rim.
PlaneOverlay MakePlane(const WantedCut& cut, double rim_mm) {
  return {.p_W = cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}),
          .normal_W = cut.across_W,
          .width_mm = cut.length_mm + 2 * rim_mm,
          .height_mm = cut.depth_mm + 2 * rim_mm,
          .up_W = -cut.into_W};
}

/// Returns a hole as a tube as wide and as deep as wanted.
MarkOverlay MakeHoleMark(const WantedCut& hole, const Rgb8& colour, bool current, const std::string& name) {
  return {.points_W = {hole.start_W, hole.ToWorld({0, hole.depth_mm, 0})},
          .radius_mm = hole.radius_mm,
          .colour = colour,
          .label = name,
          .selected = current,
          .shows_through = true};
}

}  // namespace

/// Shows the wanted cut and the saw above it where neither the panels nor the card of the exercise cover them.
void Practice::ShowCutAndSaw() {
  const double rim_mm = IsPlanned() ? kPlaneRim_mm : 0;
  std::vector<Vec3> corners_W;
  for (const WantedCut& cut : cuts_) {
    const double side_mm = std::max(cut.radius_mm, rim_mm);
    const double above_mm = 2 * std::max(cut.radius_mm, 0.5 * cut.reach_mm);
    for (const double s_mm : {-side_mm, cut.length_mm + side_mm}) {
      for (const double t_mm : {-above_mm, cut.depth_mm + rim_mm}) corners_W.push_back(cut.ToWorld({s_mm, t_mm, 0}));
    }
  }
  viewer_->ShowPlace({.points_W = std::move(corners_W), .free = [this](const UiBox& scene) {
                        UiBox free = scene;
                        const double points = state_ == State::kReplaying ? kReplayCard : kCard;
                        const double card =
                            std::min(points * static_cast<double>(viewer_->ui().scale()), kMaxCardShare * scene.height);
                        free.top += card;
                        free.height -= card;
                        if (state_ != State::kReplaying || replay_box_.empty()) return free;
                        if (replay_box_.width < 0.5 * scene.width) {  // beside it, otherwise above it
                          free.left = replay_box_.right();
                          free.width = scene.right() - free.left;
                        } else {
                          free.height = replay_box_.top - free.top;
                        }
                        return free;
                      }});
}

/// Shows all wanted cuts or holes: those that are made, the one that the advice is about, and the others.
void Practice::ShowGoal() {
  std::vector<GuideOverlay> lines;
  std::vector<PlaneOverlay> planes;
  std::vector<MarkOverlay> holes;
  plan_label_ = DescribePlan();
  for (std::size_t i = 0; i < gauges_.size(); ++i) {
    const WantedCut& cut = cuts_[i];
    const bool current = i == current_;
    const Rgb8 colour = ColourOfCut(IsMade(i), current);
    if (DrillsHoles()) {
      lines.push_back({{cut.ToWorld({0, -kAxis_mm, 0}), cut.ToWorld({0, cut.depth_mm, 0})}, colour});
      holes.push_back(MakeHoleMark(cut, colour, current, NameCut(i)));
      continue;
    }
    lines.push_back({.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})}});
    if (HasSeveralCuts()) lines.back().colour = colour;
    if (!IsPlanned()) continue;
    PlaneOverlay plane = MakePlane(cut, kPlaneRim_mm);
    plane.name = current ? plan_label_ : NameCut(i);
    if (HasSeveralCuts()) {
      plane.colour = colour;
      plane.selected = current;
      plane.faint = !current;
    }
    planes.push_back(std::move(plane));
  }
  viewer_->view().SetGuides(lines);
  viewer_->view().SetPlanes(planes);
  viewer_->view().SetMarks(holes);
}

void Practice::HideGoal() {
  viewer_->view().SetGuides({});
  viewer_->view().SetPlanes({});
  viewer_->view().SetMarks({});
}

bool Practice::has_slices() const {
  // Slices show the depth, as the gauge does. One cut is seen well enough without them.
  return state_ == State::kCutting && scene_.exercise.gauge && (HasSeveralCuts() || DrillsHoles());
}

std::optional<Vec3> Practice::slice_focus() const {
  if (cuts_.empty() || !viewer_->is_running()) return {};
  // The place of the current cut that is nearest to the tool.
  const Vec3 p = cut().ToCut(cut().FindLowest(viewer_->figures().coupled.X_WT));
  return cut().ToWorld({std::clamp(p.x, 0.0, cut().length_mm), std::clamp(p.y, 0.0, cut().depth_mm), 0});
}

void Practice::FillSlices(SliceScene& scene) const {
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    const Rgb8 colour = ColourOfCut(IsMade(i), i == current_);
    if (DrillsHoles()) {
      scene.marks.push_back(MakeHoleMark(cuts_[i], colour, i == current_, NameCut(i)));
    } else {
      PlaneOverlay plane = MakePlane(cuts_[i], 0);
      plane.name = NameCut(i);
      plane.colour = colour;
      plane.selected = i == current_;
      scene.planes.push_back(std::move(plane));
    }
  }
}

/// Returns the name of a cut or hole in the picture.
std::string Practice::NameCut(std::size_t i) const {
  if (!HasSeveralCuts()) return DrillsHoles() ? "" : Tr("plan");
  const char* const text = DrillsHoles() ? IsMade(i) ? Tr("hole {}: drilled") : Tr("hole {}")
                           : IsMade(i) ? Tr("cut {}: made")
                                         : Tr("cut {}");
  return fmt::format(fmt::runtime(text), i + 1);
}

/// Returns the text beside the plane of the current cut, with the depth if the exercise shows it and the saw is in the
/// plane.
std::string Practice::DescribePlan() const {
  const std::optional<DepthReading> reading =
      state_ == State::kCutting && scene_.exercise.gauge ? Read() : std::nullopt;
  if (!reading || reading->depth_mm <= 0) return NameCut(current_);
  // Beside the plan, the depth is that of another cut.
  const ToolDeviation deviation = CalcDeviation(cut(), viewer_->figures().coupled.X_WT);
  if (std::abs(deviation.beside_mm) > cut().margin_mm) return NameCut(current_);
  return fmt::format(fmt::runtime(Tr("{0}: {1} of {2} mm deep")), NameCut(current_), ShowNumber(reading->depth_mm, 1),
                     ShowNumber(cut().depth_mm, 0));
}

void Practice::Relabel() {
  if (state_ == State::kCutting && !gauges_.empty()) ShowGoal();
}

std::vector<Vec3> Practice::kept_clear_W() const {
  if (state_ != State::kCutting && state_ != State::kReplaying) return {};
  std::vector<Vec3> points_W;
  for (const WantedCut& cut : cuts_) {
    points_W.insert(points_W.end(), {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})});
    if (IsPlanned()) points_W.push_back(cut.ToWorld({0.5 * cut.length_mm, cut.depth_mm, 0}));
  }
  return points_W;
}

}  // namespace kerf
