// Distances and angles that the user measures between pieces.
#include <fmt/format.h>

#include <utility>

#include "app/window/pieces_mode.h"
#include "view/ui/translate.h"

namespace kerf {

void PiecesMode::TakePoint(const ScreenPoint& at) {
  const Ray ray = viewer_.view().camera().CalcRay(at);
  const std::optional<PiecePick> hit = pieces_->Pick(ray.origin_W, ray.direction_W);
  if (!hit) return viewer_.Say(Tr("There is no piece under the mouse"));
  points_.push_back(MakePiecePoint(*pieces_, *hit));
  const std::size_t wanted = asking_ == Asking::kDistance ? 2 : 3;
  if (points_.size() == wanted) {
    const std::optional<PieceMeasure> now = MeasurePieces(*pieces_, points_);
    const double value = now ? now->value : 0;
    viewer_.trace().Write("measure",
                          {{"label", fmt::format("{:.1f}{}", value, asking_ == Asking::kDistance ? " mm" : "°")}});
    measurements_.push_back(std::exchange(points_, {}));
    measured_ = DescribeLast();
    unsaved_ = true;
    asking_ = Asking::kNothing;
  }
  Show();
}

std::string PiecesMode::DescribeLast() const {
  if (measurements_.empty()) return measured_;
  const std::optional<PieceMeasure> now = MeasurePieces(*pieces_, measurements_.back());
  if (!now) return measured_;
  const std::string value = ShowNumber(now->value, 1);
  return now->points_W.size() == 2 ? fmt::format(fmt::runtime(Tr("The distance is {} mm.")), value)
                                   : fmt::format(fmt::runtime(Tr("The angle is {}°.")), value);
}

void PiecesMode::EndMeasuring() {
  asking_ = Asking::kNothing;
  points_.clear();
  measured_.clear();
  Show();
}

std::string PiecesMode::MakeLabel(const PieceMeasure& measure) {
  const std::string value = ShowNumber(measure.value, 1);
  return measure.points_W.size() == 2 ? fmt::format("{} mm", value) : fmt::format("{}°", value);
}

void PiecesMode::ShowMeasures() {
  std::vector<MeasureOverlay> measures;
  for (const MeasuredPoints& points : measurements_) {
    const std::optional<PieceMeasure> now = MeasurePieces(*pieces_, points);
    if (now) measures.push_back({.points_W = now->points_W, .label = MakeLabel(*now)});
  }
  MeasureOverlay begun;
  for (const PiecePoint& point : points_) {
    if (const std::optional<Vec3> p_W = CalcPlace(*pieces_, point)) begun.points_W.push_back(*p_W);
  }
  if (!begun.points_W.empty()) measures.push_back(std::move(begun));
  viewer_.view().SetMeasures(measures);
}

}  // namespace kerf
