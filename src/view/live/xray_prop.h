// VTK prop that draws an XrayList: what the depth buffer hides is drawn too, more weakly.
#pragma once

#include <vtkProp.h>

#include <memory>

#include "view/live/xray_list.h"

namespace kerf {

/// Drawn after the scene, with the scene's depth; does not write depth.
class XrayProp : public vtkProp {
 public:
  static XrayProp* New();
  vtkTypeMacro(XrayProp, vtkProp) XrayProp(const XrayProp&) = delete;
  XrayProp& operator=(const XrayProp&) = delete;

  /// `scale`: pixels per point.
  void SetList(XrayList list, double scale);

  int RenderOverlay(vtkViewport* viewport) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  XrayProp();
  ~XrayProp() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
