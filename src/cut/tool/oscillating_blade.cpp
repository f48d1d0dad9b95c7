#include "cut/tool/oscillating_blade.h"

#include <fmt/format.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMaxWidth = 1.2;  // of the toothed end, in radii: an arc of 74 degrees

}  // namespace

void OscillatingBlade::Validate() const {
  CheckParameters(*this);
  if (width_mm > kMaxWidth * radius_mm) {
    throw Error(fmt::format("width_mm = {:g} is above {:g} times radius_mm = {:g}: the teeth would lie on the sides",
                            width_mm, kMaxWidth, radius_mm));
  }
}

PlanarBlade ToolKind<OscillatingBlade>::Make(const OscillatingBlade& blade) {
  PlanarBlade planar;
  planar.edge_mm = blade.edge_mm();
  planar.swing_radius_mm = blade.radius_mm;
  planar.back_low = {-blade.radius_mm, -0.5 * blade.taper * blade.width_mm};
  planar.back_high = {-blade.radius_mm, 0.5 * blade.taper * blade.width_mm};
  planar.thickness_mm = blade.thickness_mm;
  planar.kerf_mm = blade.kerf_mm();
  planar.pitch_mm = blade.pitch_mm;
  planar.stroke_mm = blade.stroke_mm();
  return planar;
}

std::string ToolKind<OscillatingBlade>::Name(const OscillatingBlade& blade) {
  return fmt::format("oscillating blade {:g} x {:g} x {:g} mm, teeth {:g} mm apart, swing {:g} degrees",
                     blade.radius_mm, blade.width_mm, blade.thickness_mm, blade.pitch_mm, blade.swing_deg);
}

std::string ToolKind<OscillatingBlade>::ShortName(const OscillatingBlade& blade) {
  return fmt::format("{:g} mm wide oscillating blade", blade.width_mm);
}

}  // namespace kerf
