#include "view/live/lamps.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "view/picture/vtk_scene.h"

namespace kerf {

std::string MakeLampCode() {
  std::string lamps, powers;
  for (std::size_t i = 0; i < kLampPowers.size(); ++i) {
    const Vec3 lamp = glm::normalize(kCameraLights[i]);
    lamps += fmt::format("{}vec3({:.6f}, {:.6f}, {:.6f})", i > 0 ? ", " : "", lamp.x, lamp.y, lamp.z);
    powers += fmt::format("{}{:.6f}", i > 0 ? ", " : "", kLampPowers[i]);
  }
  return fmt::format("const vec3 kLamps[4] = vec3[]({});\nconst float kPower[4] = float[]({});\n", lamps, powers);
}

}  // namespace kerf
