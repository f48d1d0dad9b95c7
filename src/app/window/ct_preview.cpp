#include "app/window/ct_preview.h"

#include "app/window/slices_panel.h"
#include "bone/import/ct_view.h"

namespace kerf {

void CtPreview::Draw(Ui& ui, const UiBox& area, const std::shared_ptr<const Volume>& volume) {
  if (!volume || !BeginPanel(ui, "ct", area, true, false)) return;
  const Box3 box = CalcScanBox(*volume);
  constexpr std::array kAxes{CtAxis::kZ, CtAxis::kY, CtAxis::kX};
  bool uses_wheel = false;
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    const int axis = kAxes[i] == CtAxis::kX ? 0 : kAxes[i] == CtAxis::kY ? 1 : 2;
    double& at_mm = at_mm_[i];
    if (volume != drawn_) at_mm = box.centre()[axis];
    const double shown_mm = DrawCtView(ui, i, views_[i], box.lower[axis], box.upper[axis], at_mm, uses_wheel);
    if (volume != drawn_ || shown_mm != at_mm) {
      at_mm = shown_mm;
      const CtView view = SliceVolume(*volume, kAxes[i], at_mm, {});
      views_[i] = {Image{view.columns, view.rows, view.pixels}, views_[i].second + 1};
    }
  }
  drawn_ = volume;
  ScrollColumn(uses_wheel);
  EndPanel();
}

}  // namespace kerf
