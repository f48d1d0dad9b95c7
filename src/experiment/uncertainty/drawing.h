// The quantities of a scene that are drawn from their stated intervals.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/force.h"
#include "session/scene/scene.h"

namespace kerf {

/// A parameter of the force law, or E of some regions, which share one fraction of their intervals.
struct DrawnQuantity {
  std::string name;               // with its unit: the key of [force], or "E_GPa of estimated cortical regions"
  double lower = 0;               // in the unit of the name; of several regions, the lowest
  double upper = 0;               // likewise, the highest
  std::optional<double> nominal;  // value of the nominal run; none if the regions differ
  std::string basis;              // of the interval
  std::vector<int> regions;       // empty for a parameter of the law
  std::uint64_t stream = 0;       // distinguishes its random numbers from those of other quantities

  bool operator==(const DrawnQuantity&) const = default;
};

/// Interval of a parameter of the law that replaces the stated one.
struct FitInterval {
  std::string key;
  double lower = 0;
  double upper = 0;
  std::string basis;
};

/// A quantity that is used as the scene sets it.
struct FixedQuantity {
  std::string name;
  std::string why;

  bool operator==(const FixedQuantity&) const = default;
};

struct Drawing {
  std::vector<DrawnQuantity> drawn;
  std::vector<FixedQuantity> fixed;  // quantities that have an interval and yet are not drawn

  bool operator==(const Drawing&) const = default;
};

/// Returns what is drawn for a scene and its bone: the parameters of the law that have an interval and their default
/// value, and E of the regions that have an interval, occur in the bone and take E from the region table. A parameter
/// with another value was set by the user and is not drawn, nor is a quantity on which no force in this bone depends.
/// `ct_regions`: those with E from the CT. A parameter with an interval in `fit` is drawn from it, whatever its value.
Drawing FindDrawing(const Scene& scene, const Bone& bone, const std::vector<int>& ct_regions,
                    const std::vector<FitInterval>& fit = {});

/// Returns a number that is uniform in [0, 1), which depends on the arguments only.
double DrawFraction(std::uint64_t seed, int sample, std::uint64_t stream);
/// Returns the fractions of all quantities for one sample.
std::vector<double> DrawFractions(const Drawing& drawing, std::uint64_t seed, int sample);

/// Return the law and the materials with each drawn quantity at its fraction of the way from the lower to the upper end
/// of its interval.
ForceLaw ApplyToLaw(const Drawing& drawing, const std::vector<double>& fractions, const ForceLaw& law);
MaterialTable ApplyToMaterials(const Drawing& drawing, const std::vector<double>& fractions,
                               const MaterialTable& materials);

}  // namespace kerf
