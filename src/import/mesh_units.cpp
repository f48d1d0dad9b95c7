#include "import/mesh_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits{{{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"um", 1e-3}}};

/// The largest side of a surface that is taken without asking: a mandible in cm has up to 15, a skull in mm 250.
constexpr double kLeastSide_mm = 16;
constexpr double kMostSide_mm = 1000;

}  // namespace

double CalcMmPerUnit(const std::string& unit) {
  std::string names;
  for (const Unit& known : kUnits) {
    if (unit == known.name) return known.mm;
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  throw Error(fmt::format("'{}' is no unit of length; known are {}", unit, names));
}

void ScaleToMm(TriangleMesh& mesh, const std::string& unit, const std::string& path) {
  if (!unit.empty()) {
    const double mm = CalcMmPerUnit(unit);
    for (Vec3& p : mesh.points) p *= mm;
  }
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  const double side = std::max({box.size().x, box.size().y, box.size().z});
  if (side <= kMostSide_mm && (side >= kLeastSide_mm || !unit.empty())) return;
  std::vector<std::string> choices;
  for (const Unit& other : kUnits) {
    if (side * other.mm < kLeastSide_mm || side * other.mm > kMostSide_mm) continue;
    choices.push_back(fmt::format("--units {} (it is then {:.3g} mm)", other.name, side * other.mm));
  }
  if (side < kLeastSide_mm) choices.emplace_back("--units mm to take them as they are");
  if (!unit.empty() || choices.empty()) {
    throw Error(fmt::format("{}: the largest side of the surface is {:.0f} mm; kerf imports up to {:.0f} mm", path,
                            side, kMostSide_mm));
  }
  throw Error(fmt::format(
      "{}: the largest side of the surface is {}, which is unlikely for a bone in mm; say in which unit "
      "its coordinates are: {}",
      path, side < 1000 ? fmt::format("{:.3g}", side) : fmt::format("{:.0f}", side), fmt::join(choices, " or ")));
}

}  // namespace kerf
