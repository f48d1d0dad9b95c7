// Simulations that the caller runs tick by tick, or along many poses in one call.
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "copies.h"
#include "kerf/checkpoints.h"
#include "kerf/coupled.h"
#include "kerf/error.h"
#include "kerf/scene.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"
#include "kerf/tick_warnings.h"
#include "long_work.h"
#include "parameters.h"
#include "rows.h"
#include "text.h"
#include "tools.h"
#include "turn.h"

namespace kerf::python {
namespace {

constexpr std::size_t kTicksBetweenUpdates = 100;  // of the checkpoints
constexpr std::size_t kTicksBetweenWarnings = 1000;

// ---- parameters

/// Throws kerf::Error if `value` is not a text.
std::string ToText(const py::handle& value, const char* what) {
  if (!py::isinstance<py::str>(value)) {
    throw Error(std::string(what) + " must be a text, not " + py::cast<std::string>(py::repr(value)));
  }
  return ToUtf8(value);
}

/// Throws kerf::Error, with the nearest name, if `name` is not one of `known`.
void CheckName(const std::string& name, const std::vector<std::string>& known, const std::string& what) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw Error("there is no " + what + " '" + name + "'" + SuggestName(name, known));
}

py::dict ToDict(const py::object& value, const std::string& what) {
  if (!py::isinstance<py::dict>(value)) throw Error(what + " must be a dict");
  return value;
}

ForceLaw ToLaw(const py::object& given, const py::object& parameters) {
  ForceLaw law;
  if (!given.is_none()) {
    const std::string name = ToText(given, "law");
    std::vector<std::string> laws;
    for (const ForceLawInfo* info : ForceLaws()) laws.emplace_back(info->name);
    CheckName(name, laws, "force law");
    law = ForceLaw(name);
  }
  if (parameters.is_none()) return law;
  std::vector<std::string> known;
  for (const LawParameter& p : law.info().parameters) known.emplace_back(p.key);
  for (const auto& [key, value] : ToDict(parameters, "law_parameters")) {
    const std::string name = ToText(key, "a parameter of a law");
    CheckName(name, known, "parameter of " + std::string(law.name()));
    if (!PyNumber_Check(value.ptr()) || py::isinstance<py::bool_>(value) || py::isinstance<py::str>(value)) {
      throw Error(name + " must be a number");
    }
    law.Set(name, py::cast<double>(py::float_(py::reinterpret_borrow<py::object>(value))));
  }
  return law;
}

EffectValue ToEffectValue(const py::handle& given) {
  const py::object value = ToScalar(given);
  if (py::isinstance<py::bool_>(value)) return py::cast<bool>(value);
  if (py::isinstance<py::str>(value)) return ToUtf8(value);
  if (py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value)) return py::cast<double>(value);
  return ToVec3(value, "an effect's value");
}

/// `given`: a name, names, or a dict from name to a dict of parameters.
EffectChoices ToEffects(const py::object& given) {
  std::vector<std::string> known;
  for (const EffectInfo* info : Effects()) known.emplace_back(info->name);
  py::object effects = given;
  if (py::isinstance<py::str>(given)) effects = py::make_tuple(given);
  if (!py::hasattr(effects, "__iter__")) throw Error("effects must be a list of names, or a dict");
  EffectChoices choices;
  for (const py::handle item : py::iter(effects)) {
    const std::string name = ToText(item, "an effect");
    CheckName(name, known, "effect");
    EffectChoice choice(name);
    if (py::isinstance<py::dict>(effects)) {
      std::vector<std::string> keys;
      for (const EffectParameter& p : choice.info().parameters) keys.emplace_back(p.key);
      for (const auto& [key, value] : ToDict(effects[item], "the parameters of an effect")) {
        const std::string parameter = ToText(key, "a parameter of an effect");
        CheckName(parameter, keys, "parameter of " + name);
        choice.Set(parameter, ToEffectValue(value));
      }
    }
    choices.push_back(std::move(choice));
  }
  CheckEffects(choices);
  return choices;
}

template <typename Params>
Params ToParams(const py::object& tool, const py::object& law, const py::object& law_parameters,
                const py::object& effects) {
  Params params;
  params.tool = ToTool(tool);
  params.law = ToLaw(law, law_parameters);
  if (!effects.is_none()) params.effects = ToEffects(effects);
  return params;
}

// ---- a tool on a path

/// What the simulations have in common. The time and the removed volume are counted for the tables.
template <typename Sim>
struct Runner {
  template <typename... Arguments>
  explicit Runner(Arguments&&... arguments) : simulation(std::forward<Arguments>(arguments)...) {}

  Sim simulation;
  std::unique_ptr<Checkpoints> checkpoints;  // of a tool in a hand, if it has an undo
  std::optional<TickWarnings> warnings;      // not of a slab
  std::set<std::string> warned;              // what Python has been warned of
  std::vector<std::string> channels;         // names
  std::vector<double> values;                // the effects' after a tick
  double time_s = 0;
  double removed_mm3 = 0;
  double rpm = 0;            // of ticks that state none
  double max_rpm = kMaxRpm;  // in size; more strokes are valid for a piezo insert
  std::size_t ticks = 0;
  std::atomic<bool> busy = false;
};

using PathRunner = Runner<Simulation>;
using HandRunner = Runner<CoupledSimulation>;

/// A slab simulation, and what its warnings need.
struct SlabRunner : Runner<SlabSimulation> {
  SlabRunner(const SceneFile& the_scene, SlabProfile profile, const Pose& X_WT_start)
      : Runner(std::move(profile), the_scene.MakeSlabParams(), X_WT_start),
        scene(the_scene),
        start(simulation.state()) {
    rpm = scene.rpm();
  }
  SceneFile scene;
  SlabState start;
};

template <typename AnyRunner>
void FindChannels(AnyRunner& runner) {
  runner.channels = runner.simulation.ListChannels();
  runner.values.resize(runner.channels.size());
}

/// Spindle speed of a tool outside a scene, if a tick states none.
double CalcDefaultRpm(const Tool& tool) {
  return SenseOf(tool) * CalcOrdinaryRate(tool);
}

std::unique_ptr<PathRunner> MakePathRunner(const Bone& bone, const SimulationParams& params, const Pose& X_WT_start,
                                           double rpm) {
  auto runner = std::make_unique<PathRunner>(bone, params, X_WT_start);
  runner->rpm = rpm;
  runner->max_rpm = std::max(kMaxRpm, CalcRateRange(params.tool).upper);
  FindChannels(*runner);
  runner->warnings.emplace(params, bone, X_WT_start, runner->channels);
  return runner;
}

std::unique_ptr<PathRunner> MakePathRunnerOf(const Bone& bone, const py::object& start, const py::object& tool,
                                             const py::object& law, const py::object& law_parameters,
                                             const py::object& effects, const py::kwargs& arguments) {
  const auto params = ReadParameters<SimulationParams>(arguments, "Simulation",
                                                       ToParams<SimulationParams>(tool, law, law_parameters, effects));
  const Pose X = ToPose(start, "start");
  const Unlocked unlocked;
  return MakePathRunner(bone, params, X, CalcDefaultRpm(params.tool));
}

/// Returns the given bone, or makes that of the scene in `made`.
const Bone& OrSceneBone(const SceneFile& scene, const Bone* given, Bone& made) {
  if (given != nullptr) return *given;
  made = RunLong(py::none(), "bone",
                 [&](Watch& watch) { return scene.MakeBone([&](double fraction) { return watch(fraction); }); });
  return made;
}

/// Pose at which the scene's path begins.
Pose StartOf(const SceneFile& scene) {
  const std::vector<PathStep> steps = scene.ListPathSteps();
  return steps.empty() ? Pose{} : steps.front().X_WT;
}

std::unique_ptr<PathRunner> MakePathRunnerOfScene(const SceneFile& scene, const Bone* bone) {
  Bone made;
  return MakePathRunner(OrSceneBone(scene, bone, made), scene.MakeSimulationParams(), StartOf(scene), scene.rpm());
}

/// Runs a tick; `in` is a TickInput or a CoupledInput.
template <typename AnyRunner, typename Input>
auto RunTick(AnyRunner& runner, const Input& in) {
  constexpr bool kCutsBone = !std::is_same_v<AnyRunner, SlabRunner>;
  if constexpr (kCutsBone) {
    runner.simulation.Refill();
    if (runner.checkpoints && (runner.ticks + 1) % kTicksBetweenUpdates == 0) runner.checkpoints->Update();
  }
  const auto out = runner.simulation.Tick(in);
  if constexpr (kCutsBone) {
    if (!runner.channels.empty()) runner.simulation.ReadChannels(runner.values);
    runner.warnings->Add(in, out, runner.values);
  }
  ++runner.ticks;
  if (in.dt_s >= kMinTick_s) runner.time_s += in.dt_s;
  runner.removed_mm3 += out.removed_mm3;
  return out;
}

/// `removed_mm3`: the volume cut so far.
template <typename AnyRunner>
std::vector<std::string> FindWarnings(const AnyRunner& runner, double removed_mm3) {
  if constexpr (std::is_same_v<AnyRunner, SlabRunner>) {
    return FindSlabWarnings(runner.scene, runner.start, runner.time_s > 0 ? &runner.simulation.state() : nullptr);
  } else {
    return runner.warnings->Find(removed_mm3);
  }
}

/// Warns about the settings and the ticks so far. CalcRemovedByRegion() is not called, because it cuts what is due
/// later.
template <typename AnyRunner>
void Warn(AnyRunner& runner) {
  WarnOnce(FindWarnings(runner, runner.removed_mm3), runner.warned);
}

/// Throws kerf::Error if a spindle speed is out of range; a tick of the library would be refused without a word.
double CheckRpm(double rpm, double max_rpm) {
  if (!(std::abs(rpm) <= max_rpm)) {
    throw Error(py::str("rpm = {!r} is out of range; valid range {:g} to {:g}")
                    .format(rpm, -max_rpm, max_rpm)
                    .cast<std::string>());
  }
  return rpm;
}

/// Runs a tick on its own. Warns at the first one about the settings and later, once in a while, about the cut.
template <typename AnyRunner, typename Input>
auto RunSingleTick(AnyRunner& runner, const Input& in) {
  const Turn turn(runner.busy, "simulation");
  if (runner.ticks == 0 || (runner.ticks % kTicksBetweenWarnings == 0 && runner.removed_mm3 > 0)) Warn(runner);
  const Unlocked unlocked;
  return RunTick(runner, in);
}

template <typename AnyRunner>
TickOutput TickOnPath(AnyRunner& runner, const py::object& pose, double dt, std::optional<double> rpm) {
  return RunSingleTick(
      runner,
      TickInput{.X_WT = ToPose(pose, "pose"), .dt_s = dt, .rpm = CheckRpm(rpm.value_or(runner.rpm), runner.max_rpm)});
}

template <typename V>
void VisitValues(const std::vector<std::string>& names, const std::vector<double>& values, V&& visit) {
  for (std::size_t i = 0; i < names.size(); ++i) visit(names[i], values[i]);
}

/// Poses with the duration and the spindle speed of each tick.
struct Inputs {
  /// The runner's speed applies if `speeds` is None.
  template <typename AnyRunner>
  Inputs(const AnyRunner& runner, const py::object& poses, const char* name, const py::object& dt,
         const py::object& speeds)
      : X(ToPoses(poses, name)),
        dt_s(ToNumbers(dt, X.size(), "dt")),
        rpm(speeds.is_none() ? std::vector<double>(X.size(), runner.rpm) : ToNumbers(speeds, X.size(), "rpm")) {
    for (const double speed : rpm) CheckRpm(speed, runner.max_rpm);
  }
  std::vector<Pose> X;
  std::vector<double> dt_s;
  std::vector<double> rpm;
};

// Visit the columns of a tick's row without those of the effects.
template <typename V>
void VisitRow(const PathRunner& runner, const Pose& X, const TickOutput& out, V&& visit) {
  VisitTick(runner.time_s, X, out, runner.removed_mm3, visit);
}
template <typename V>
void VisitRow(const HandRunner& runner, const Pose& X, const CoupledOutput& out, V&& visit) {
  VisitHandTick(runner.time_s, X, out, runner.removed_mm3, visit);
}
template <typename V>
void VisitRow(const SlabRunner& runner, const Pose& X, const TickOutput& out, V&& visit) {
  VisitSlabTick(runner.time_s, X, out, runner.simulation.state(), visit);
}

/// Runs a tick for each pose, and returns a table with a row for each. `tick(i)` runs tick i.
template <typename AnyRunner, typename TickOf>
py::array RunRows(AnyRunner& runner, const std::vector<Pose>& X, const py::object& progress, const TickOf& tick) {
  const Turn turn(runner.busy, "simulation");
  Table table([&](auto&& visit) {
    VisitRow(runner, Pose{}, decltype(tick(0)){}, visit);
    VisitValues(runner.channels, runner.values, visit);
  });
  RunLong(progress, "run", [&](Watch& watch) {
    table.Reserve(X.size());
    for (std::size_t i = 0; i < X.size(); ++i) {
      const auto out = tick(i);
      VisitRow(runner, X[i], out, table);
      if constexpr (!std::is_same_v<AnyRunner, SlabRunner>) {
        VisitValues(runner.channels, runner.values, table);
      }
      if (i % 16 == 0 && !watch(static_cast<double>(i) / static_cast<double>(X.size()))) break;
    }
    return true;
  });
  Warn(runner);
  return table.Take();
}

template <typename AnyRunner>
py::array RunOnPath(AnyRunner& runner, const py::object& poses, const py::object& dt, const py::object& rpm,
                    const py::object& progress) {
  const Inputs in(runner, poses, "poses", dt, rpm);
  return RunRows(runner, in.X, progress, [&](std::size_t i) {
    return RunTick(runner, TickInput{.X_WT = in.X[i], .dt_s = in.dt_s[i], .rpm = in.rpm[i]});
  });
}

// ---- a tool in a hand

/// Throws kerf::Error in the words of Python's parameter; 0 means that there are no checkpoints.
void CheckUndo(double undo_MB) {
  if (undo_MB == 0 || (undo_MB >= 0.2 && undo_MB <= 1e6)) return;
  throw Error("undo_MB = " + py::str(py::float_(undo_MB)).cast<std::string>() +
              " is out of range; valid range 0.2 to 1000000, or 0 for no checkpoints");
}

std::unique_ptr<HandRunner> MakeHandRunner(const Bone& bone, const CoupledParams& params, const Pose& X_WT_start,
                                           double undo_MB, double rpm) {
  auto runner = std::make_unique<HandRunner>(bone, params, X_WT_start);
  runner->rpm = rpm;
  runner->max_rpm = std::max(kMaxRpm, CalcRateRange(params.tool).upper);
  if (undo_MB != 0) runner->checkpoints = std::make_unique<Checkpoints>(runner->simulation, undo_MB);
  FindChannels(*runner);
  runner->warnings.emplace(params, bone, runner->channels);
  return runner;
}

std::unique_ptr<HandRunner> MakeHandRunnerOf(const Bone& bone, const py::object& start, const py::object& tool,
                                             const py::object& law, const py::object& law_parameters,
                                             const py::object& effects, double undo_MB, const py::kwargs& arguments) {
  CheckUndo(undo_MB);
  auto params = ToParams<CoupledParams>(tool, law, law_parameters, effects);
  py::dict rest(arguments);
  ParameterSetter setter(rest);
  Describe(params, setter);
  Describe(params.coupling, setter);
  setter.CheckRest("HandSimulation");
  CheckParameters(params, "HandSimulation");
  CheckParameters(params.coupling, "HandSimulation");
  const Pose X = ToPose(start, "start");
  const Unlocked unlocked;
  return MakeHandRunner(bone, params, X, undo_MB, CalcDefaultRpm(params.tool));
}

std::unique_ptr<HandRunner> MakeHandRunnerOfScene(const SceneFile& scene, const Bone* bone, const py::object& start,
                                                  double undo_MB) {
  CheckUndo(undo_MB);
  Bone made;
  const Pose X = start.is_none() ? StartOf(scene) : ToPose(start, "start");
  return MakeHandRunner(OrSceneBone(scene, bone, made), scene.MakeCoupledParams(), X, undo_MB, scene.rpm());
}

CoupledOutput TickInHand(HandRunner& runner, const py::object& handle, double dt, std::optional<double> rpm,
                         const py::object& velocity, const py::object& angular_velocity) {
  CoupledInput in{
      .X_WH = ToPose(handle, "handle"), .dt_s = dt, .rpm = CheckRpm(rpm.value_or(runner.rpm), runner.max_rpm)};
  if (!velocity.is_none()) in.v_H_W_mm_per_s = ToVec3(velocity, "velocity");
  if (!angular_velocity.is_none()) in.w_H_W_rad_per_s = ToVec3(angular_velocity, "angular_velocity");
  return RunSingleTick(runner, in);
}

py::array RunInHand(HandRunner& runner, const py::object& handles, const py::object& dt, const py::object& rpm,
                    const py::object& velocities, const py::object& progress) {
  const Inputs in(runner, handles, "handles", dt, rpm);
  std::vector<Vec3> v;
  if (!velocities.is_none()) {
    v = ToPoints(velocities, "velocities");
    if (v.size() != in.X.size()) throw Error("velocities must have one row for each pose");
  }
  return RunRows(runner, in.X, progress, [&](std::size_t i) {
    CoupledInput input{.X_WH = in.X[i], .dt_s = in.dt_s[i], .rpm = in.rpm[i]};
    if (!v.empty()) input.v_H_W_mm_per_s = v[i];
    return RunTick(runner, input);
  });
}

Checkpoints& CheckpointsOf(HandRunner& runner) {
  if (!runner.checkpoints) throw Error("this simulation keeps no checkpoints; make it with undo_MB = 256, for example");
  return *runner.checkpoints;
}

void Undo(HandRunner& runner, const Text& name, const py::object& pose) {
  const Turn turn(runner.busy, "simulation");
  Checkpoints& checkpoints = CheckpointsOf(runner);
  runner.warnings->BoneRestored();
  checkpoints.Update();
  if (pose.is_none()) return checkpoints.Undo(name.utf8);
  const Pose X = ToPose(pose, "pose");
  checkpoints.Undo(name.utf8, &X);
}

void Redo(HandRunner& runner, const py::object& pose) {
  const Turn turn(runner.busy, "simulation");
  if (pose.is_none()) return CheckpointsOf(runner).Redo();
  const Pose X = ToPose(pose, "pose");
  CheckpointsOf(runner).Redo(&X);
}

// ---- slab mode

std::unique_ptr<SlabRunner> MakeSlabRunner(const SceneFile& scene, const Bone* bone) {
  Bone made;
  return std::make_unique<SlabRunner>(scene, scene.MakeSlabProfile(OrSceneBone(scene, bone, made)), StartOf(scene));
}

py::dict StateOf(SlabRunner& runner) {
  const Turn turn(runner.busy, "simulation");
  py::dict values;
  struct Setter {
    py::dict& values;
    void operator()(const char* name, double value) { values[name] = value; }
    void operator()(const char* name, std::int64_t value) { values[name] = value; }
  };
  Setter setter{values};
  VisitSlabState(runner.simulation.state(), setter);
  return values;
}

// ---- results

template <typename AnyRunner>
std::shared_ptr<Bone> CopyBone(AnyRunner& runner) {
  const Turn turn(runner.busy, "simulation");
  const Unlocked unlocked;
  return std::make_shared<Bone>(runner.simulation.UpdateBone());
}

template <typename AnyRunner>
py::dict RemovedByRegion(AnyRunner& runner) {
  const Turn turn(runner.busy, "simulation");
  const std::array<double, 256> mm3 = runner.simulation.CalcRemovedByRegion();
  py::dict regions;
  for (std::size_t id = 0; id < mm3.size(); ++id) {
    if (mm3[id] != 0) regions[py::cast(id)] = mm3[id];
  }
  return regions;
}

template <typename AnyRunner>
void SetDown(AnyRunner& runner, const py::object& pose) {
  const Pose X = ToPose(pose, "pose");
  const Turn turn(runner.busy, "simulation");
  if (!runner.simulation.SetDown(X))
    throw Error("pose is not valid: its numbers are not finite, too large, or not a unit quaternion");
  runner.warnings->SetDown(X);
}

template <typename AnyRunner>
py::dict ReadEffects(AnyRunner& runner) {
  const Turn turn(runner.busy, "simulation");
  runner.simulation.ReadChannels(runner.values);
  py::dict values;
  for (std::size_t i = 0; i < runner.channels.size(); ++i) values[py::cast(runner.channels[i])] = runner.values[i];
  return values;
}

template <typename AnyRunner>
py::list FindWarningsOf(AnyRunner& runner) {
  const Turn turn(runner.busy, "simulation");
  double removed_mm3 = 0;
  if constexpr (!std::is_same_v<AnyRunner, SlabRunner>) {
    for (const double mm3 : runner.simulation.CalcRemovedByRegion()) removed_mm3 += mm3;
  }
  return ShowTexts(FindWarnings(runner, removed_mm3));
}

// ---- classes

template <typename Class>
void BindTeeth(Class& c) {
  using Output = typename Class::type;
  c.def("__repr__", [](const Output& out) {
    char text[120];
    std::snprintf(text, sizeof text, ", thrust %.4g N, %.3g teeth, %.3g mm3, status %u>", out.thrust_sum_N,
                  out.engaged_teeth, out.removed_mm3, out.status);
    return std::string(std::is_same_v<Output, TickOutput> ? "<kerf.Tick" : "<kerf.HandTick") + text;
  });
  c.def_readonly("thrust_sum_N", &TeethOutput::thrust_sum_N, "Sum of the magnitudes of the teeth's thrust.")
      .def_readonly("thrust_W", &TeethOutput::thrust_W, "Sum of thrust times speed of the teeth along their motion.")
      .def_readonly("cutting_sum_N", &TeethOutput::cutting_sum_N,
                    "Sum of their cutting forces, mean over their way; 0 unless the law states one.")
      .def_readonly("cutting_W", &TeethOutput::cutting_W, "Power of the cutting forces.")
      .def_readonly("engaged_teeth", &TeethOutput::engaged_teeth, "Engaged arc / tooth pitch.")
      .def_readonly("mean_E_MPa", &TeethOutput::mean_E_MPa, "Over the engaged teeth; 0 if there are none.")
      .def_readonly("mean_bite_mm", &TeethOutput::mean_bite_mm, "Over the engaged teeth; 0 if there are none.")
      .def_readonly("main_region", &TeethOutput::main_region, "Region with the largest part of the thrust; 0 if none.")
      .def_readonly("removed_mm3", &TeethOutput::removed_mm3, "Volume removed in this tick, by occupancy of voxels.")
      .def_readonly("status", &TeethOutput::status, "Bits, as in forces.csv; 0: nothing to report.");
}

/// What simulations of a bone have.
template <typename AnyRunner, typename Class>
void BindBoneOf(Class& c) {
  c.def("set_down", &SetDown<AnyRunner>, py::arg("pose"), "Moves the tool to a pose without cutting on the way.")
      .def("bone", &CopyBone<AnyRunner>, "Returns a copy of the current bone.")
      .def("removed_by_region_mm3", &RemovedByRegion<AnyRunner>,
           "Dict of exact volumes cut since the start, by region.")
      .def_property_readonly(
          "channels", [](const AnyRunner& runner) { return runner.channels; },
          "Names of the effects' results, such as 'heat.peak_C' (docs/effects.md).")
      .def("effects", &ReadEffects<AnyRunner>, "Dict of the effects' results after the last tick.");
}

template <typename AnyRunner, typename Class>
void BindClock(Class& c) {
  c.def("__repr__", [](const py::object& self) {
    char text[60];
    std::snprintf(text, sizeof text, ", %.6g s>", py::cast<const AnyRunner&>(self).time_s);
    return "<kerf." + py::cast<std::string>(py::type::of(self).attr("__name__")) + text;
  });
  c.def_property_readonly(
       "time_s", [](const AnyRunner& runner) { return runner.time_s; }, "Sum of the ticks' dt.")
      .def_property_readonly(
          "warnings", &FindWarningsOf<AnyRunner>,
          "List of sentences about the settings and the ticks so far: what `kerf run`, or `kerf "
          "loop` for a tool in a hand, warns about, such as voxels that are too coarse for the blade "
          "or a bite that is too large for the force law. Python's warnings.warn() shows each once.");
}

void BindLists(py::module_& m) {
  m.def(
      "force_laws",
      [] {
        py::dict laws;
        for (const ForceLawInfo* info : ForceLaws()) {
          py::dict parameters;
          for (const LawParameter& p : info->parameters) parameters[p.key] = p.default_value;
          laws[info->name] = py::make_tuple(info->summary, parameters);
        }
        return laws;
      },
      "Dict of the force laws: (summary, dict of parameters with their defaults) by name; the first is the default.");
  m.def(
      "effects",
      [] {
        py::dict effects;
        for (const EffectInfo* info : Effects()) effects[info->name] = info->summary;
        return effects;
      },
      "Dict of the effects' summaries by name; `kerf effects` and docs/effects.md describe their parameters.");
}

}  // namespace

void BindSimulations(py::module_& m) {
  BindTools(m);
  BindLists(m);
  py::class_<TickOutput> tick(m, "Tick",
                              "Result of a tick. World frame; forces act on the tool and are means over the tick.");
  tick.def_property_readonly(
          "force_N", [](const TickOutput& out) { return FromVec3(out.f_T_W_N); }, "Array (3,).")
      .def_property_readonly(
          "torque_Nmm", [](const TickOutput& out) { return FromVec3(out.tau_TG_W_Nmm); },
          "About the grip; array (3,).");
  BindTeeth(tick);
  py::class_<CoupledOutput> hand(m, "HandTick",
                                 "Result of a tick of a tool in a hand. World frame; means over the tick.");
  hand.def_property_readonly(
          "pose", [](const CoupledOutput& out) { return FromPose(out.X_WT); }, "Of the tool: x, y, z, mm; w, x, y, z.")
      .def_property_readonly(
          "hand_force_N", [](const CoupledOutput& out) { return FromVec3(out.f_H_W_N); }, "On the hand; array (3,).")
      .def_property_readonly(
          "hand_torque_Nmm", [](const CoupledOutput& out) { return FromVec3(out.tau_H_W_Nmm); },
          "On the hand, about the coupling point; array (3,).")
      .def_property_readonly(
          "cut_N", [](const CoupledOutput& out) { return FromVec3(out.f_cut_W_N); },
          "On the tool, from the edge; array (3,).")
      .def_property_readonly(
          "face_N", [](const CoupledOutput& out) { return FromVec3(out.f_face_W_N); },
          "On the tool, normal to its flats; array (3,).")
      .def_property_readonly(
          "friction_N", [](const CoupledOutput& out) { return FromVec3(out.f_friction_W_N); },
          "On the tool; array (3,).")
      .def_readonly("hand_mJ", &CoupledOutput::hand_mJ, "Work of the hand in this tick.")
      .def_readonly("spindle_mJ", &CoupledOutput::spindle_mJ)
      .def_readonly("stored_mJ", &CoupledOutput::stored_mJ)
      .def_readonly("cut_mJ", &CoupledOutput::cut_mJ)
      .def_readonly("friction_mJ", &CoupledOutput::friction_mJ)
      .def_readonly("damping_mJ", &CoupledOutput::damping_mJ)
      .def_readonly("numerical_mJ", &CoupledOutput::numerical_mJ)
      .def_readonly("substeps", &CoupledOutput::substeps)
      .def_readonly("iterations", &CoupledOutput::iterations)
      .def_property_readonly(
          "fidelity", [](const CoupledOutput& out) { return ToString(out.fidelity); }, "'full', 'coarse' or 'slab'.")
      .def("has_cut", &CoupledOutput::HasCut, py::arg("region"), "True if a tooth cut this region in this tick.");
  BindTeeth(hand);

  const auto dt = py::arg("dt") = 0.001;
  const auto rpm = py::arg("rpm") = py::none();
  const auto progress = py::arg("progress") = py::none();
  const auto bone = py::arg("bone") = py::none();
  static const std::string on_path = R"(A bone and a tool that follows a prescribed path.

bone: is copied. start: pose of the tool. tool: )" +
                                     ListToolClasses() +
                                     R"(; None: the default disc. law: name of a force law, with
law_parameters, a dict. effects: a name, a list of names, or a dict from name to a dict of
parameters; None: only kerf_friction.

Poses are arrays of 3 numbers (position, mm), 7 numbers (position and unit quaternion w, x, y, z) or 4 x 4. rpm: spindle
speed, its sign is the sense about z of the tool; None: that of the scene, or without a scene an ordinary speed of the
kind of tool, in the sense in which it cuts. A simulation can be used by one thread at a time; several simulations run
in parallel.

Parameters, each by name:
)" + ListParameters<SimulationParams>();
  py::class_<PathRunner> path(m, "Simulation", on_path.c_str());
  path.def(py::init(&MakePathRunnerOf), py::arg("bone"), py::arg("start"), py::kw_only(), py::arg("tool") = py::none(),
           py::arg("law") = py::none(), py::arg("law_parameters") = py::none(), py::arg("effects") = py::none())
      .def_static(
          "from_scene", &MakePathRunnerOfScene, py::arg("scene"), bone,
          "Makes a simulation with the parameters of a scene, at the start of its path; `bone` replaces the scene's.")
      .def("tick", &TickOnPath<PathRunner>, py::arg("pose"), dt, rpm,
           "Moves the tool to a pose within dt (s) and returns a Tick. A stopped spindle (|rpm| < 1) cuts nothing.")
      .def("run", &RunOnPath<PathRunner>, py::arg("poses"), dt, rpm, progress,
           R"(Runs a tick for each row of poses, in C++, and returns a structured array with a row for each.

poses: (n, 3), (n, 7) or (n, 4, 4). dt (s), rpm: a number, or n. Columns: time_s, x_mm, ..., qw, ..., force_x_N, ...,
torque_x_Nmm, ..., thrust_sum_N, and so on, as in forces.csv (docs/formats.md), then those of the effects.)");
  BindBoneOf<PathRunner>(path);
  BindClock<PathRunner>(path);

  static const std::string in_hand = R"(A bone and a tool that a spring and a damper connect to a handle.

As Simulation, but the input is the pose of the handle, and the bone resists the tool. undo_MB: memory for checkpoints; 0:
none.

Parameters, each by name:
)" + ListParameters<CoupledParams>() +
                                     ListParameters<CouplingParams>();
  py::class_<HandRunner> held(m, "HandSimulation", in_hand.c_str());
  held.def(py::init(&MakeHandRunnerOf), py::arg("bone"), py::arg("start"), py::kw_only(), py::arg("tool") = py::none(),
           py::arg("law") = py::none(), py::arg("law_parameters") = py::none(), py::arg("effects") = py::none(),
           py::arg("undo_MB") = 0.0)
      .def_static("from_scene", &MakeHandRunnerOfScene, py::arg("scene"), bone, py::arg("start") = py::none(),
                  py::arg("undo_MB") = 0.0,
                  "Makes a simulation with the parameters of a scene. start: default is the start of its path.")
      .def("tick", &TickInHand, py::arg("handle"), dt, rpm, py::arg("velocity") = py::none(),
           py::arg("angular_velocity") = py::none(),
           "Runs a tick with the handle at a pose and returns a HandTick. velocity (mm/s), angular_velocity (rad/s): "
           "of the "
           "handle, world frame; only damping uses them.")
      .def("run", &RunInHand, py::arg("handles"), dt, rpm, py::arg("velocities") = py::none(), progress,
           R"(Runs a tick for each row of handles, in C++, and returns a structured array with a row for each.

handles: poses, (n, 3), (n, 7) or (n, 4, 4). dt (s), rpm: a number, or n. velocities: (n, 3). Columns: time_s,
handle_x_mm, ..., tool_x_mm, ..., hand_x_N (force on the hand), ..., and so on, then those of the effects.)")
      .def(
          "checkpoint",
          [](HandRunner& runner, const Text& name) {
            const Turn turn(runner.busy, "simulation");
            CheckpointsOf(runner).Update();
            CheckpointsOf(runner).Make(name.utf8);
          },
          py::arg("name"), "Makes a checkpoint of the current bone.")
      .def("undo", &Undo, py::arg("name") = "", py::arg("pose") = py::none(),
           "Restores the bone of the newest checkpoint of that name, or of the last one; the first is 'start'. The "
           "tool is "
           "set down where it is, or at `pose`. The time and what effects keep, such as heat in the bone, are not "
           "restored.")
      .def("redo", &Redo, py::arg("pose") = py::none(), "Returns to the state before the last undo.")
      .def(
          "checkpoints",
          [](HandRunner& runner) {
            std::vector<std::string> names;
            for (const UndoCheckpoint& checkpoint : CheckpointsOf(runner).List()) names.push_back(checkpoint.name);
            return names;
          },
          "Names of the checkpoints, oldest first.");
  BindBoneOf<HandRunner>(held);
  BindClock<HandRunner>(held);

  py::class_<SlabRunner> slab(m, "SlabSimulation", "Slab mode: a thin slice on a rail (docs/slab.md).");
  slab.def_static(
          "from_scene", &MakeSlabRunner, py::arg("scene"), bone,
          "Makes the slab of a scene with a [slab] section, at the start of its path; `bone` replaces the scene's.")
      .def("tick", &TickOnPath<SlabRunner>, py::arg("pose"), dt, rpm,
           "Moves the hand to a pose within dt (s) and returns a Tick, with the force on the hand.")
      .def("run", &RunOnPath<SlabRunner>, py::arg("poses"), dt, rpm, progress,
           "Runs a tick for each row of poses, as Simulation.run().")
      .def("state", &StateOf, "Dict of positions (mm) and energies (mJ) after the last tick.");
  BindClock<SlabRunner>(slab);
}

}  // namespace kerf::python
