// Force laws: the force on one tooth from its bite and the material it cuts. Each law is one file of src/cut/force; the
// scene's choices, `kerf check`, the warnings and the tests all walk the list of them.
#pragma once

#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// A law's own parameters, in the order in which it names them; and its coefficients when made ready for a tool.
using LawValues = std::array<double, 4>;

/// A force law made ready for one tool: no lookups left in the tick.
struct ToothForce {
  /// The law for bites above 0.
  double (*law)(const LawValues& coefficients, double bite_mm, double E_star_MPa);
  LawValues coefficients{};  // what each is, the law's file says

  /// Radial (thrust) force on a tooth that bites `bite_mm` deep into material of reduced modulus `E_star_MPa`, N, >= 0;
  /// 0 for a bite of 0 or less. Tick-safe.
  double operator()(double bite_mm, double E_star_MPa) const;
};

/// A parameter of a law: a key of [force] in a scene, its unit in the name.
struct LawParameter {
  const char* key;
  double preset;  // what a scene that doesn't say gets
  double lower;   // of the valid range
  double upper;
  const char* meaning;
};

/// The bites that a law's figures cover. Outside, `below` and `beyond` finish the sentence of a warning.
struct LawValidity {
  double from_mm = 0;
  double to_mm = std::numeric_limits<double>::infinity();
  const char* below = "";
  const char* beyond = "";
};

/// All that there is to know of a law.
struct ForceLawInfo {
  const char* name;     // as scenes name it
  const char* summary;  // one line
  const char* source;   // of formula and figures
  LawValidity validity;
  std::vector<LawParameter> parameters;  // at most as many as LawValues holds
  /// `values` in the order of `parameters`, each in its range.
  ToothForce (*make)(const LawValues& values, const Tooth& tooth);
};

/// All laws, the default first. To add one: a file in src/cut/force and a line in src/cut/force/laws.h.
const std::vector<const ForceLawInfo*>& ForceLaws();

/// A law chosen by name, with its parameters.
class ForceLaw {
 public:
  /// The default law.
  ForceLaw();
  /// With the presets. Throws Error for a name that no law has.
  explicit ForceLaw(std::string_view name);

  const ForceLawInfo& info() const { return *info_; }
  const char* name() const { return info_->name; }
  /// In the order of info().parameters.
  const LawValues& values() const { return values_; }
  LawValues& values() { return values_; }
  /// Throw Error when the law has no such parameter.
  double Get(std::string_view key) const { return values_[FindParameter(key)]; }
  void Set(std::string_view key, double value) { values_[FindParameter(key)] = value; }

 private:
  std::size_t FindParameter(std::string_view key) const;

  const ForceLawInfo* info_;
  LawValues values_{};
};

/// Throws Error when a parameter is out of range.
ToothForce MakeToothForce(const ForceLaw& law, const Tool& tool);

}  // namespace kerf
