// Effects: optional physics that a scene enables, in addition to contact and removal. Each effect is one file or folder
// in src/cut/effects and one line of the list in src/cut/effects/effects.h. Scenes, `kerf effects`, the docs and the
// tests use that list. An effect that a scene does not enable takes no time and no memory and has no state.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

class Effect;
class OwnEffect;
struct EffectSetup;
struct OwnEffectSetup;

/// Value of an effect's parameter: a number, a boolean, a vector, or a string.
using EffectValue = std::variant<double, bool, Vec3, std::string>;

/// Kind of file that a text parameter refers to. The scene reader reads these files; effects have no access to files.
enum class EffectFileKind { kNone, kSurface, kMarkups };

/// Content of such a file. World frame, mm.
struct EffectFile {
  struct Curve {
    std::vector<Vec3> points;
    bool joined = false;  // true: a polyline; false: separate points
  };
  std::string place;          // prefix of messages about the file, such as "scene.toml:12:1: "; optional
  std::string name;           // file name
  TriangleMesh mesh;          // kSurface: a closed surface
  std::vector<Curve> curves;  // kMarkups: the curves and points
};

/// Parameter of an effect: a key of [effects.NAME] in a scene. The name includes the unit.
struct EffectParameter {
  const char* key;
  EffectValue default_value;  // its type is the parameter's type
  double lower = 0;           // lower end of the valid range of a number or of each component of a vector
  double upper = 0;
  const char* meaning = "";
  std::vector<std::string_view> words = {};     // valid values of a string; empty: any string
  EffectFileKind file = EffectFileKind::kNone;  // not kNone: the text is a file name, relative to the scene folder
  bool whole = false;                           // the value must be a whole number
};

/// Result of an effect in each tick: a column of a log.
struct EffectChannel {
  const char* name;  // includes the unit: "rpm", "peak_C"
  const char* meaning;
};

/// Points of a tick at which an effect is called, in order. An effect is called only at those that it lists.
enum EffectHook : unsigned {
  kEffectBegin = 1u << 0,   // at the start of a tick: may change the spindle speed
  kEffectHolds = 1u << 1,   // before a move through air: may require that the tool be moved in steps
  kEffectEngage = 1u << 2,  // when a substep is set up: adds forces to it
  kEffectSolved = 1u << 3,  // after a substep: reads motion, teeth and forces
  kEffectEnd = 1u << 4,     // at the end of a tick
  kEffectPush = 1u << 5,    // at the end of a tick: adds a force on the hand to that of the coupling
};

/// Tool that an effect requires: one that is coupled to a handle, or any.
enum class EffectTool { kAny, kInHand };

/// Description of an effect.
struct EffectInfo {
  const char* name;     // name in scenes
  const char* summary;  // one line
  const char* source;   // sources of model and constants
  const char* reads;    // quantities of the tick that it reads
  const char* writes;   // outputs: force, torque, grids, events
  const char* state;    // data kept between ticks
  const char* sleeps;   // condition under which it does nothing
  EffectTool tool = EffectTool::kAny;
  std::vector<const char*> needs = {};  // names of other effects that it requires
  unsigned hooks = 0;                   // bits of EffectHook
  std::vector<EffectParameter> parameters = {};
  std::vector<EffectChannel> channels = {};
  /// Returns an error message if the values are each in range but invalid in combination; otherwise an empty string.
  /// Optional.
  std::string (*find_fault)(std::span<const EffectValue> values) = nullptr;
  /// `values` must be in the order of `parameters`, each in its range. Allocates. Throws kerf::Error if the values are
  /// invalid in combination.
  std::unique_ptr<Effect> (*make)(std::span<const EffectValue> values, const EffectSetup& setup) = nullptr;
  /// For an effect of another program, instead of `make` (kerf/own_effect.h).
  std::unique_ptr<OwnEffect> (*make_own)(std::span<const EffectValue> values, const OwnEffectSetup& setup) = nullptr;

  /// Returns the index of a parameter. Throws kerf::Error if it does not exist.
  std::size_t FindParameter(std::string_view key) const;
};

/// Returns all effects, in the order in which a tick calls them.
const std::vector<const EffectInfo*>& Effects();
/// Adds an effect of the calling program, which has `make_own`, behind all others. From then on it can be chosen by
/// name like kerf's own effects, also in scenes. Throws kerf::Error if the name is taken or not made of lower-case
/// letters, digits and "_", if it has no `make_own`, or if it lists a hook other than kEffectBegin, kEffectSolved,
/// kEffectEnd and kEffectPush. Call it before scenes are read and simulations are made; not thread-safe.
void RegisterEffect(EffectInfo info);
/// Returns nullptr if there is no effect of that name.
const EffectInfo* FindEffect(std::string_view name);

/// An effect chosen by a scene, with its parameters.
class EffectChoice {
 public:
  /// Sets all parameters to their defaults. Throws kerf::Error if there is no effect of that name.
  explicit EffectChoice(std::string_view name);

  const EffectInfo& info() const { return *info_; }
  const char* name() const { return info_->name; }
  /// Values in the order of info().parameters.
  const std::vector<EffectValue>& values() const { return values_; }
  std::vector<EffectValue>& values() { return values_; }
  /// Files in the same order; nullptr where none was read.
  const std::vector<std::shared_ptr<const EffectFile>>& files() const { return files_; }
  /// Both throw kerf::Error if the effect has no such parameter or the parameter has another type.
  double GetNumber(std::string_view key) const;
  EffectChoice& Set(std::string_view key, EffectValue value);
  /// Sets the content of the file that the parameter names. Throws kerf::Error if there is no such parameter or it does
  /// not name a file.
  EffectChoice& SetFile(std::string_view key, EffectFile file);

 private:
  const EffectInfo* info_;
  std::vector<EffectValue> values_;
  std::vector<std::shared_ptr<const EffectFile>> files_;
};

using EffectChoices = std::vector<EffectChoice>;

/// Returns nullptr if the effect is not chosen.
const EffectChoice* FindChoice(const EffectChoices& choices, std::string_view name);
/// Sets a parameter of an effect, and adds the effect if it is not chosen yet. Throws kerf::Error as EffectChoice does.
void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, EffectValue value);
void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, double value);
/// Removes an effect from the choices.
void RemoveEffect(EffectChoices& choices, std::string_view name);

/// Throws kerf::Error if a value is invalid, an effect is chosen twice, or an effect that another one requires is
/// missing. The message lists every fault.
void CheckEffects(const EffectChoices& choices);

}  // namespace kerf
