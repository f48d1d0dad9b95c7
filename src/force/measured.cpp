#include "force/measured.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {
namespace {

// tests/force/measured_test.cpp recomputes the factors.
constexpr std::array<LawCaveat, 3> kCaveats{{
    {"hertz_chip",
     "thrust 1.6 times the measured at a bite of 2.5 um, 9 times at 10 um (22 mm disc); nothing was measured below 2 "
     "um",
     "ignores the blade's thickness and goes with the root of the disc's radius: blades can't be compared by it"},
    {"hertz_constant_bite",
     "thrust 120 to 170 times below the measured at bites of 2.5 to 10 um (24 teeth on a 22 mm disc)",
     "ignores the blade's thickness and goes with the cube of the tooth pitch by the disc's radius: blades can't be "
     "compared by it"},
    {"edge_plus_chip",
     "by default fitted to thrust measured at bites of 2.5 to 10 um; studies differ by a factor of 2 to 3",
     "goes with the blade's thickness, and ignores the disc's radius"},
}};

}  // namespace

const LawCaveat& FindCaveat(const ForceLawInfo& law) {
  const auto* found = std::find_if(kCaveats.begin(), kCaveats.end(),
                                   [&](const LawCaveat& c) { return std::string_view(c.law) == law.name; });
  if (found == kCaveats.end())
    throw Error(fmt::format("nothing is said of how near {} is to measured forces", law.name));
  return *found;
}

}  // namespace kerf
