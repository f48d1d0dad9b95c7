// How a window of Dear ImGui looks that is part of the picture.
#pragma once

#include <imgui.h>

namespace kerf {

/// Of a window without a title that the user can neither move, resize nor fold.
inline constexpr ImGuiWindowFlags kFixedWindow =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav;

}  // namespace kerf
