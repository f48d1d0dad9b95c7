// VTK prop that draws bone dust as soft points.
#pragma once

#include <vtkProp.h>

#include <memory>
#include <vector>

#include "view/live/dust.h"

namespace kerf {

/// Must be drawn after everything that can hide it. Does not write depth.
class DustProp : public vtkProp {
 public:
  static DustProp* New();
  vtkTypeMacro(DustProp, vtkProp) DustProp(const DustProp&) = delete;
  DustProp& operator=(const DustProp&) = delete;

  /// `scale`: pixels per point.
  void SetGrains(std::vector<DustGrain> grains, double scale);

  int RenderOpaqueGeometry(vtkViewport* viewport) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  DustProp();
  ~DustProp() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
