#include "core/volume_text.h"

#include <fmt/format.h>

namespace kerf {

std::string FormatVolume(double mm3) {
  // From 999.5 on three digits would be rounded to 1e+03.
  return mm3 < 999.5 ? fmt::format("{:.3g} mm3", mm3) : fmt::format("{:.2f} cm3", mm3 / 1000);
}

}  // namespace kerf
