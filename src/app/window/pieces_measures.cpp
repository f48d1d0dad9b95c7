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
    Measure measure{.points = std::exchange(points_, {}), .now = {}};
    measure.now = MeasurePieces(*pieces_, measure.points);
    const double value = measure.now ? measure.now->value : 0;
    viewer_.trace().Write("measure",
                          {{"label", fmt::format("{:.1f}{}", value, asking_ == Asking::kDistance ? " mm" : "°")}});
    measured_ = asking_ == Asking::kDistance
                    ? fmt::format(fmt::runtime(Tr("The distance is {} mm.")), ShowNumber(value, 1))
                    : fmt::format(fmt::runtime(Tr("The angle is {}°.")), ShowNumber(value, 1));
    measures_.push_back(std::move(measure));
    asking_ = Asking::kNothing;
  }
  Show();
}

void PiecesMode::EndMeasuring() {
  asking_ = Asking::kNothing;
  points_.clear();
  measured_.clear();
  Show();
}

void PiecesMode::ShowMeasures() {
  std::vector<MeasureOverlay> measures;
  for (const Measure& m : measures_) {
    if (!m.now) continue;
    const std::string value = ShowNumber(m.now->value, 1);
    measures.push_back({.points_W = m.now->points_W,
                        .label = m.points.size() == 2 ? fmt::format("{} mm", value) : fmt::format("{}°", value)});
  }
  MeasureOverlay begun;
  for (const PiecePoint& point : points_) {
    if (const std::optional<Vec3> p_W = CalcPlace(*pieces_, point)) begun.points_W.push_back(*p_W);
  }
  if (!begun.points_W.empty()) measures.push_back(std::move(begun));
  viewer_.view().SetMeasures(measures);
}

std::vector<ExportMeasure> PiecesMode::measures() const {
  std::vector<ExportMeasure> taken;
  for (const Measure& m : uses_earlier() ? earlier_measures_ : measures_) {
    if (!m.now) continue;
    const bool distance = m.points.size() == 2;
    taken.push_back({.name = fmt::format("{} {}", distance ? "distance" : "angle", taken.size() + 1),
                     .unit = distance ? "mm" : "deg",
                     .value = m.now->value,
                     .points_W_mm = m.now->points_W});
  }
  return taken;
}

}  // namespace kerf
