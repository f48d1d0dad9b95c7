// Force laws: the force on one tooth from its bite and the material it cuts. Each law is one file in src/cut/force.
// Scenes, `kerf check`, the warnings and the tests all use the list of laws.
#pragma once

#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// Values of a law's parameters, in the order of ForceLawInfo::parameters, or its coefficients for one tool.
using LawValues = std::array<double, 4>;

/// Force law prepared for one tool, so that the tick needs no lookups.
struct ToothForce {
  /// Force for a bite above 0, N.
  double (*law)(const LawValues& coefficients, double bite_mm, double E_star_MPa);
  LawValues coefficients{};  // defined in the law's file

  /// Returns the radial (thrust) force on a tooth that cuts `bite_mm` deep into material of reduced modulus
  /// `E_star_MPa`: N, >= 0, and 0 for a bite of 0 or less. Tick-safe.
  double operator()(double bite_mm, double E_star_MPa) const;
};

/// Parameter of a law: a key of [force] in a scene. The name includes the unit.
struct LawParameter {
  const char* key;
  double default_value;
  double lower;  // lower end of the valid range
  double upper;
  const char* meaning;
};

/// Range of bites that a law's measurements cover. `below` and `beyond` complete the warning for bites outside it.
struct LawValidity {
  double from_mm = 0;
  double to_mm = std::numeric_limits<double>::infinity();
  const char* below = "";
  const char* beyond = "";
};

/// Description of a force law.
struct ForceLawInfo {
  const char* name;     // name in scenes
  const char* summary;  // one line
  const char* source;   // sources of formula and constants
  LawValidity validity;
  std::vector<LawParameter> parameters;  // at most as many as LawValues holds
  /// `values` must be in the order of `parameters`, each in its range.
  ToothForce (*make)(const LawValues& values, const Tooth& tooth);
};

/// Returns all laws, the default first. To add one, add a file to src/cut/force and a line to src/cut/force/laws.h.
const std::vector<const ForceLawInfo*>& ForceLaws();

/// Force law chosen by name, with its parameters.
class ForceLaw {
 public:
  /// The default law.
  ForceLaw();
  /// Sets all parameters to their defaults. Throws kerf::Error if there is no law of that name.
  explicit ForceLaw(std::string_view name);

  const ForceLawInfo& info() const { return *info_; }
  const char* name() const { return info_->name; }
  /// Values in the order of info().parameters.
  const LawValues& values() const { return values_; }
  LawValues& values() { return values_; }
  /// Both throw kerf::Error if the law has no such parameter.
  double Get(std::string_view key) const { return values_[FindParameter(key)]; }
  void Set(std::string_view key, double value) { values_[FindParameter(key)] = value; }

 private:
  std::size_t FindParameter(std::string_view key) const;

  const ForceLawInfo* info_;
  LawValues values_{};
};

/// Prepares a law for a tool. Throws kerf::Error if a parameter is out of range.
ToothForce MakeToothForce(const ForceLaw& law, const Tool& tool);

}  // namespace kerf
