// VTK prop that draws the last frame of Dear ImGui, and owns its textures.
#pragma once

#include <imgui.h>
#include <vtkProp.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <string>

#include "view/picture/image.h"

namespace kerf {

class UiProp : public vtkProp {
 public:
  static UiProp* New();
  vtkTypeMacro(UiProp, vtkProp) UiProp(const UiProp&) = delete;
  UiProp& operator=(const UiProp&) = delete;

  /// Must be called when the fonts have changed.
  void RenewFonts();
  /// Returns the texture of a slot. Uploads the image in the next picture if `version` has changed.
  ImTextureID Texture(const std::string& slot, const Image& image, std::uint64_t version);

  int RenderOverlay(vtkViewport* viewport) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  UiProp();
  ~UiProp() override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
