// Colours in the types of Dear ImGui.
#pragma once

#include <imgui.h>

#include "view/picture/colours.h"

namespace kerf {

inline ImU32 ToImU32(const Rgb8& colour, double alpha = 1) {
  return IM_COL32(colour[0], colour[1], colour[2], static_cast<int>(255 * alpha + 0.5));
}
inline ImVec4 ToImVec4(const Rgb8& colour, double alpha = 1) {
  return ImGui::ColorConvertU32ToFloat4(ToImU32(colour, alpha));
}

}  // namespace kerf
