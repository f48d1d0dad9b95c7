// The lamps of the live picture, for VTK and for shaders.
#pragma once

#include <array>
#include <string>

namespace kerf {

/// Powers for AddCameraLights(): less than in still pictures, which are darkened by ambient occlusion.
inline constexpr std::array kLampPowers = {0.62, 0.30, 0.20, 0.10};

/// Returns GLSL that defines the lamps: `kLamps[4]`, unit vectors towards them in view space, and `kPower[4]`.
std::string MakeLampCode();

}  // namespace kerf
