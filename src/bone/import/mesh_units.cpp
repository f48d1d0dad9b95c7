#include "bone/import/mesh_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "base/core/number_text.h"
#include "base/core/symmetric_eigen.h"
#include "kerf/error.h"

namespace kerf {
namespace {

struct Unit {
  const char* name;
  double mm;
};
constexpr std::array<Unit, 5> kUnits{{{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"um", 1e-3}}};

/// Range of a surface's largest side in mm that is accepted without a unit: a mandible measures 8 to 15 in cm, and a
/// skull 250 in mm.
constexpr double kMinSide_mm = 16;
constexpr double kMaxSide_mm = 1000;

/// Bones that in cm are as long as a piece of bone in mm: the range of their length, and the fractions of it within
/// which their middle side (at most) and their smallest side (at least) lie.
struct LargeBone {
  const char* name;
  double shortest_cm;
  double longest_cm;
  double middle;
  double smallest;
  double thickest_cm = 1000;  // of its smallest side
};
/// Skulls are 15 to 26 cm long and at least half as thick, which few pieces in mm are. Humerus, tibia, fibula and femur
/// are 28 to 55 cm long and at most 0.3 times as wide; whole teeth are shorter. Radius, clavicle and ribs are 16 to 32
/// cm long and less than 2.5 cm thick; a piece in mm with these numbers would be a sliver. So would the long bones of a
/// child; teeth of that length are wider.
constexpr std::array<LargeBone, 5> kLargeBones{{{"skull", 15, 26, 1, 0.5},
                                                {"pelvis", 26, 32, 0.9, 0.5},
                                                {"long bone", 28, 55, 0.3, 0},
                                                {"long thin bone", 16, 32, 0.35, 0, 2.5},
                                                {"long bone of a child", 16, 28, 0.28, 0}}};

/// Maximum number of voxels within a surface: 2 litres at 0.1 mm, which take one core two minutes. No bone encloses
/// that much.
constexpr double kMaxUnitVoxels = 2e9;
/// The voxels for tissues are at least this large; each costs eight times as much as one of the level set.
constexpr double kTissueVoxel_mm = 0.2;

std::string ShowSide(double side) {
  if (side >= 1e6) return "more than a million";
  return side < 1000 ? fmt::format("{:.3g}", side) : fmt::format("{:.0f}", side);
}

/// Returns the lengths of the surface along its principal axes, in increasing order.
std::array<double, 3> CalcPrincipalSides(const TriangleMesh& mesh) {
  const auto [mean, eigen] = CalcPointSpread(mesh.points);
  std::array<double, 3> sides{};
  for (std::size_t a = 0; a < 3; ++a) {
    double lower = 0;
    double upper = 0;
    for (const Vec3& p : mesh.points) {
      const double at = glm::dot(p - mean, eigen.vectors[a]);
      lower = std::min(lower, at);
      upper = std::max(upper, at);
    }
    sides[a] = upper - lower;
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Returns the name of the bone that the surface may be in cm, or null.
const char* FindLargeBone(const TriangleMesh& mesh) {
  const auto [smallest, middle, length] = CalcPrincipalSides(mesh);
  for (const LargeBone& bone : kLargeBones) {
    const bool fits = length >= bone.shortest_cm && length <= bone.longest_cm && middle <= bone.middle * length &&
                      smallest >= bone.smallest * length;
    if (fits && smallest < bone.thickest_cm) return bone.name;
  }
  return nullptr;
}

double MaxEnclosed_mm3(double voxel_mm) {
  return kMaxUnitVoxels * std::min(std::pow(voxel_mm, 3), std::pow(std::max(voxel_mm, kTissueVoxel_mm), 3) / 8);
}

}  // namespace

double CalcMmPerUnit(const std::string& unit) {
  std::string names;
  for (const Unit& known : kUnits) {
    if (unit == known.name) return known.mm;
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  throw Error(fmt::format("'{}' is not a unit of length; the units are {}", unit, names));
}

void ScaleToMm(TriangleMesh& mesh, const std::string& unit, const std::string& path) {
  if (!unit.empty()) {
    const double mm = CalcMmPerUnit(unit);
    for (Vec3& p : mesh.points) p *= mm;
  }
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  const double side = std::max({box.size().x, box.size().y, box.size().z});
  if (side <= kMaxSide_mm && !unit.empty()) return;
  if (side <= kMaxSide_mm && side >= kMinSide_mm) {
    const char* bone = FindLargeBone(mesh);
    if (bone == nullptr) return;
    const std::string why =
        fmt::format("the largest side of the surface is {}, which may be a piece of {} mm or a {} of {} cm",
                    ShowSide(side), ShowSide(side), bone, ShowSide(side));
    throw UnclearUnit(fmt::format("{}: {}; give the unit of its coordinates: --units mm or --units cm", path, why), why,
                      {{"mm", side}, {"cm", 10 * side}});
  }
  std::vector<std::string> options;
  std::vector<UnclearUnit::Choice> choices;
  for (const Unit& other : kUnits) {
    if (side * other.mm < kMinSide_mm || side * other.mm > kMaxSide_mm) continue;
    options.push_back(fmt::format("--units {} (it is then {:.3g} mm)", other.name, side * other.mm));
    choices.push_back({other.name, side * other.mm});
  }
  if (side < kMinSide_mm) {
    options.emplace_back("--units mm to keep them unchanged");
    choices.push_back({"mm", side});
  }
  if (!unit.empty() || choices.empty()) {
    throw Error(fmt::format("{}: the largest side of the surface is {}; kerf imports up to {}", path,
                            FormatLength(side), FormatLength(kMaxSide_mm)));
  }
  const std::string why =
      fmt::format("the largest side of the surface is {}, which is unlikely for a bone in mm", ShowSide(side));
  throw UnclearUnit(fmt::format("{}: {}; give the unit of its coordinates: {}", path, why, fmt::join(options, " or ")),
                    why, choices);
}

void CheckEnclosed(const TriangleMesh& mesh, double voxel_mm, const std::string& path) {
  double mm3 = 0;
  for (const auto& t : mesh.triangles) {
    mm3 += glm::dot(mesh.points[t[0]], glm::cross(mesh.points[t[1]], mesh.points[t[2]])) / 6;
  }
  mm3 = std::abs(mm3);
  if (mm3 <= MaxEnclosed_mm3(voxel_mm)) return;
  std::string larger;
  for (const double h : {0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0}) {
    if (h <= voxel_mm || mm3 > MaxEnclosed_mm3(h)) continue;
    larger = fmt::format(" or use --voxel {} or more", h);
    break;
  }
  throw Error(
      fmt::format("{}: the surface encloses {:.1f} litres, but with voxels of {:g} mm kerf imports up to {:.1f}: "
                  "check its unit (--units){}",
                  path, mm3 / 1e6, voxel_mm, MaxEnclosed_mm3(voxel_mm) / 1e6, larger));
}

}  // namespace kerf
