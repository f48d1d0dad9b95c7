// VTK prop that draws a DrawList in one pass.
#pragma once

#include <vtkProp.h>

#include <memory>

#include "view/live/draw_list.h"

namespace kerf {

class HudProp : public vtkProp {
 public:
  static HudProp* New();
  vtkTypeMacro(HudProp, vtkProp) HudProp(const HudProp&) = delete;
  HudProp& operator=(const HudProp&) = delete;

  /// Sets the list to draw. `scale`: pixels per point.
  void SetList(DrawList list, double scale);

  int RenderOverlay(vtkViewport* viewport) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  HudProp();
  ~HudProp() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
