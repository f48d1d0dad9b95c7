// Slices of a CT in the right column while its bone is made.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "bone/import/volume.h"
#include "view/picture/image.h"
#include "view/ui/panels.h"

namespace kerf {

class CtPreview {
 public:
  /// `volume`: null if there is none yet.
  void Draw(Ui& ui, const UiBox& area, const std::shared_ptr<const Volume>& volume);

 private:
  std::array<std::pair<Image, std::uint64_t>, 3> views_;  // image and version
  std::array<double, 3> at_mm_{};                         // position of each slice
  std::shared_ptr<const Volume> drawn_;
};

}  // namespace kerf
