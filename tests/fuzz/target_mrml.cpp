#include <filesystem>

#include "session/plan/plan.h"
#include "target.h"

namespace kerf::fuzz {

/// A scene of 3D Slicer beside a file with a plane, then a folder with the input as a markups file.
KERF_FUZZ_TARGET(mrml) {
  constexpr const char* kPlane =
      R"({"markups": [{"type": "Plane", "coordinateSystem": "LPS", "controlPoints": [{"position": [0, 0, 0]}],
       "center": [0, 0, 0], "normal": [0, 0, 1]}]})";
  static const MemoryFolder folder;
  static const std::string sub = folder.path() + "/folder";
  std::filesystem::create_directories(sub);
  folder.Write("plane.mrk.json", kPlane);
  const std::string scene = folder.Write("f.mrml", bytes);
  folder.Write("folder/f.mrk.json", bytes);
  for (const std::string& path : {scene, sub}) {
    Accepts([&] {
      if (ReadPlannedPlanes(path).empty()) Finding("no plane and no message");
    });
  }
}

}  // namespace kerf::fuzz
