// Effects: what a scene may ask for beyond contact and removal. Each is one file or folder of src/cut/effects with a
// line in src/cut/effects/effects.h; scenes, `kerf effects`, the docs and the tests all walk the list of them. What a
// scene does not name is not simulated: no time, no memory, no state.
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
struct EffectSetup;

/// A value of an effect's parameter: a number, a switch, a vector, or a text.
using EffectValue = std::variant<double, bool, Vec3, std::string>;

/// What a text that names a file stands for. Who reads scenes reads these too: effects see no files.
enum class EffectFileKind { kNone, kSurface, kMarkups };

/// What was read from such a file. World frame, mm.
struct EffectFile {
  struct Curve {
    std::vector<Vec3> points;
    bool joined = false;  // to a line; else each stands by itself
  };
  std::string place;          // in front of a message about it: "scene.toml:12:1: "; may be empty
  std::string name;           // of the file
  TriangleMesh mesh;          // kSurface: closed
  std::vector<Curve> curves;  // kMarkups
};

/// A parameter of an effect: a key of [effects.NAME] in a scene, its unit in the name.
struct EffectParameter {
  const char* key;
  EffectValue preset;  // what a scene that doesn't say gets; gives the parameter its kind
  double lower = 0;    // of the valid range of a number, and of each component of a vector
  double upper = 0;
  const char* meaning = "";
  std::vector<const char*> words = {};          // that a text may be; none: any text
  EffectFileKind file = EffectFileKind::kNone;  // else: a text that names a file, relative to the scene's
};

/// A figure that an effect gives after every tick: a column of a log.
struct EffectChannel {
  const char* name;  // with its unit: "rpm", "peak_C"
  const char* meaning;
};

/// When an effect is asked, in the order of a tick. An effect is called at those that it names, and nowhere else.
enum EffectHook : unsigned {
  kEffectBegin = 1u << 0,   // before the tick looks at anything: may change the spindle's speed
  kEffectHolds = 1u << 1,   // the tool flies through air: may say that it must go step by step
  kEffectEngage = 1u << 2,  // a step is set up: adds forces to it
  kEffectSolved = 1u << 3,  // a step has been made: sees motion, teeth and forces
  kEffectEnd = 1u << 4,     // the tick is over
  kEffectPush = 1u << 5,    // and then adds to the force on the hand, beside the coupling
};

/// Whom an effect needs: a tool that a hand holds, or any.
enum class EffectTool { kAny, kInHand };

/// All that there is to know of an effect.
struct EffectInfo {
  const char* name;     // as scenes name it
  const char* summary;  // one line
  const char* source;   // of model and figures
  const char* reads;    // of a tick
  const char* writes;   // force, torque, grids, events
  const char* state;    // what it keeps between ticks
  const char* sleeps;   // when it has nothing to do
  EffectTool tool = EffectTool::kAny;
  std::vector<const char*> needs = {};  // other effects, by name
  unsigned hooks = 0;                   // EffectHook
  std::vector<EffectParameter> parameters = {};
  std::vector<EffectChannel> channels = {};
  /// What is wrong with values that are in range each by itself, as a sentence; empty: nothing. Null: nothing ever is.
  std::string (*find_fault)(std::span<const EffectValue> values) = nullptr;
  /// `values` in the order of `parameters`, each in its range. Allocates. Throws Error for values that do not go
  /// together.
  std::unique_ptr<Effect> (*make)(std::span<const EffectValue> values, const EffectSetup& setup) = nullptr;

  /// Throws Error when there is no such parameter.
  std::size_t FindParameter(std::string_view key) const;
};

/// All effects, in the order in which a tick calls them.
const std::vector<const EffectInfo*>& Effects();
/// Null when there is none of that name.
const EffectInfo* FindEffect(std::string_view name);

/// An effect that a scene asks for, with its parameters.
class EffectChoice {
 public:
  /// With the presets. Throws Error for a name that no effect has.
  explicit EffectChoice(std::string_view name);

  const EffectInfo& info() const { return *info_; }
  const char* name() const { return info_->name; }
  /// In the order of info().parameters.
  const std::vector<EffectValue>& values() const { return values_; }
  std::vector<EffectValue>& values() { return values_; }
  /// In the same order; null where none was read.
  const std::vector<std::shared_ptr<const EffectFile>>& files() const { return files_; }
  /// Throw Error when the effect has no such parameter, or one of another kind.
  double GetNumber(std::string_view key) const;
  EffectChoice& Set(std::string_view key, EffectValue value);
  /// What stands in the file that the parameter names. Throws Error when it is no such parameter.
  EffectChoice& SetFile(std::string_view key, EffectFile file);

 private:
  const EffectInfo* info_;
  std::vector<EffectValue> values_;
  std::vector<std::shared_ptr<const EffectFile>> files_;
};

using EffectChoices = std::vector<EffectChoice>;

/// Null when it is not chosen.
const EffectChoice* FindChoice(const EffectChoices& choices, std::string_view name);
/// Sets a parameter of an effect, which is chosen thereby.
void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, EffectValue value);
void SetEffect(EffectChoices& choices, std::string_view name, std::string_view key, double value);
/// Leaves it out.
void RemoveEffect(EffectChoices& choices, std::string_view name);

/// Throws Error that names each value out of range, each effect chosen twice, and each that needs another which is
/// missing.
void CheckEffects(const EffectChoices& choices);

}  // namespace kerf
