// Window with the settings.
#pragma once

#include <vector>

#include "app/window/settings.h"
#include "view/ui/translate.h"
#include "view/ui/ui.h"

namespace kerf {

/// `scene`: area that contains the window. `shown` becomes false if the user closes it. Returns true if a setting was
/// changed.
bool DrawSettings(Ui& ui, const UiBox& scene, const std::vector<Language>& languages, WindowSettings& settings,
                  bool& shown);

}  // namespace kerf
