// Whole runs of a scene, and recordings.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "copies.h"
#include "kerf/error.h"
#include "kerf/recording.h"
#include "kerf/run.h"
#include "long_work.h"
#include "rows.h"
#include "text.h"
#include "turn.h"

namespace kerf::python {
namespace {

/// Values of the effects in a row of channels.
template <typename V>
void VisitChannels(const ChannelRows& channels, std::size_t row, V&& visit) {
  const std::size_t width = channels.names.size();
  for (std::size_t i = 0; i < width; ++i) {
    visit(channels.names[i], row < channels.rows() ? channels.values[row * width + i] : 0.0);
  }
}

template <typename V>
void VisitRow(const TickRecord& tick, double total_mm3, V&& visit) {
  visit("segment", static_cast<std::int64_t>(tick.segment + 1));
  VisitTick(tick.time_s, tick.X_WT, tick.out, total_mm3, visit);
  visit("travel_mm", tick.travel_mm);
}

template <typename V>
void VisitRow(const HandTick& tick, double total_mm3, V&& visit) {
  VisitHandTick(tick.time_s, tick.X_WH, tick.out, total_mm3, visit);
  visit("rpm", tick.rpm);
  visit("device_{}_N", tick.f_device_N);
  visit("device_torque_{}_Nmm", tick.tau_device_Nmm);
  visit("faults", static_cast<std::int64_t>(tick.faults));
}

/// Makes the table of a run's ticks. `AnyRun`: PathRun or HandRun.
template <typename AnyRun>
py::array MakeTickTable(const AnyRun& run) {
  Table table([&](auto&& visit) {
    VisitRow(typename decltype(run.ticks)::value_type{}, 0, visit);
    VisitChannels(run.channels, run.channels.rows(), visit);
  });
  table.Reserve(run.ticks.size());
  double total_mm3 = 0;
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    total_mm3 += run.ticks[i].out.removed_mm3;
    VisitRow(run.ticks[i], total_mm3, table);
    VisitChannels(run.channels, i, table);
  }
  return table.Take();
}

py::object MakeSlabTable(const PathRun& run) {
  if (run.slab_states.empty()) return py::none();
  Table table([](auto&& visit) { VisitSlabState({}, visit); });
  table.Reserve(run.slab_states.size());
  for (const SlabState& state : run.slab_states) VisitSlabState(state, table);
  return table.Take();
}

/// Result of a run, as Python sees it.
struct Result {
  py::array ticks;
  py::object slab = py::none();
  std::shared_ptr<Bone> bone;
  double removed_mm3 = 0;
  py::dict removed_by_region_mm3;
  double wall_s = 0;
  py::list warnings;
  py::object difference = py::none();
};

template <typename AnyRun>
Result MakeResult(AnyRun& run) {
  Result result;
  result.ticks = MakeTickTable(run);
  result.bone = std::make_shared<Bone>(std::move(run.bone));
  result.removed_mm3 = run.removed_mm3;
  result.wall_s = run.wall_s;
  result.warnings = ShowTexts(run.warnings);
  std::set<std::string> shown;
  WarnOnce(run.warnings, shown);
  if (run.difference) result.difference = py::make_tuple(run.difference->time_s, ShowText(run.difference->what));
  return result;
}

Result MakePathResult(PathRun&& run) {
  Result result = MakeResult(run);
  result.slab = MakeSlabTable(run);
  for (std::size_t id = 0; id < run.removed_mm3_by_region.size(); ++id) {
    if (run.removed_mm3_by_region[id] != 0) result.removed_by_region_mm3[py::cast(id)] = run.removed_mm3_by_region[id];
  }
  return result;
}

Result MakeHandResult(HandRun&& run) {
  return MakeResult(run);
}

py::tuple GetResultState(const Result& r) {
  return py::make_tuple(r.ticks, r.slab, r.bone, r.removed_mm3, r.removed_by_region_mm3, r.wall_s, r.warnings,
                        r.difference);
}

Result MakeResultOfState(const py::tuple& state) {
  return OfState("Run", [&]() -> Result {
    return {.ticks = state[0],
            .slab = state[1],
            .bone = py::cast<std::shared_ptr<Bone>>(state[2]),
            .removed_mm3 = py::cast<double>(state[3]),
            .removed_by_region_mm3 = state[4],
            .wall_s = py::cast<double>(state[5]),
            .warnings = state[6],
            .difference = state[7]};
  });
}

/// Reads the scene if its path is given.
SceneFile ToScene(const py::object& scene) {
  if (py::isinstance<SceneFile>(scene)) return py::cast<SceneFile>(scene);
  try {
    return SceneFile::Read(py::cast<std::filesystem::path>(scene).string());
  } catch (const py::cast_error&) {
    throw Error("scene must be a Scene or the path of one");
  }
}

void CheckRecord(const std::optional<std::filesystem::path>& record) {
  if (record && record->empty()) throw Error("record must be the name of a file, or None");
}

Result RunScene(const py::object& given, const Bone* bone, const std::optional<std::filesystem::path>& record,
                const py::object& progress) {
  const SceneFile scene = ToScene(given);
  CheckRecord(record);
  if (bone != nullptr && record) throw Error("a run with a bone of its own can't be recorded");
  return MakePathResult(RunLong(progress, "run", [&](Watch& watch) {
    const ShowProgress show = [&](double fraction) { return watch(fraction); };
    return bone != nullptr ? RunAlongPath(scene, *bone, show)
                           : RunAlongPath(scene, {.record = record ? record->string() : "", .progress = show});
  }));
}

Result RunSceneInHand(const py::object& given, double seconds, bool real_time,
                      const std::optional<std::filesystem::path>& record, const py::object& progress) {
  const SceneFile scene = ToScene(given);
  CheckRecord(record);
  return MakeHandResult(RunLong(progress, "run in hand", [&](Watch& watch) {
    HandRunOptions options;
    options.seconds = seconds;
    options.real_time = real_time;
    options.record = record ? record->string() : "";
    options.progress = [&](double fraction) { return watch(fraction); };
    return RunInHand(scene, options);
  }));
}

template <typename V>
void VisitInput(const RecordedInput& in, V&& visit) {
  visit("time_s", in.time_s);
  VisitPose("{}_mm", "qw", "qx", "qy", "qz", in.X, visit);
  visit("dt_s", in.dt_s);
  visit("rpm", in.rpm);
  visit("buttons", static_cast<std::int64_t>(in.buttons));
  visit("set_down", static_cast<std::int64_t>(in.set_down));
}

py::array MakeInputTable(Recording& recording) {
  const std::vector<RecordedInput> inputs = recording.ReadInputs();
  Table table([](auto&& visit) { VisitInput({}, visit); });
  table.Reserve(inputs.size());
  for (const RecordedInput& input : inputs) VisitInput(input, table);
  return table.Take();
}

/// A recording that one thread uses at a time.
struct SharedRecording {
  explicit SharedRecording(const std::filesystem::path& path)
      : absolute_path(std::filesystem::absolute(path).string()), recording(path.string()) {}
  std::string absolute_path;
  Recording recording;
  std::atomic<bool> busy = false;
};

Result Replay(SharedRecording& shared, const py::object& progress) {
  const Turn turn(shared.busy, "recording");
  Recording& recording = shared.recording;
  if (recording.kind() == "loop") {
    return MakeHandResult(RunLong(progress, "replay", [&](Watch& watch) {
      return recording.ReplayHand([&](double fraction) { return watch(fraction); });
    }));
  }
  return MakePathResult(RunLong(progress, "replay", [&](Watch& watch) {
    return recording.ReplayPath([&](double fraction) { return watch(fraction); });
  }));
}

}  // namespace

void BindRuns(py::module_& m) {
  py::class_<Result>(m, "Run", "Result of a run.")
      .def(py::pickle(&GetResultState, &MakeResultOfState))
      .def_readonly("ticks", &Result::ticks,
                    "One row per tick: structured array with the columns of forces.csv (docs/formats.md) and those of "
                    "the effects.")
      .def_readonly("slab", &Result::slab,
                    "State of the slab after each tick, as a structured array; None in voxel mode.")
      .def_readonly("bone", &Result::bone, "Bone after the cut; empty in slab mode.")
      .def_readonly("removed_mm3", &Result::removed_mm3, "Volume removed, exact; 0 in slab mode.")
      .def_readonly("removed_by_region_mm3", &Result::removed_by_region_mm3,
                    "Dict of volumes by region; of a run along a path.")
      .def_readonly("wall_s", &Result::wall_s, "Duration of the ticks, s.")
      .def_readonly("warnings", &Result::warnings, "List of sentences, as the program prints them.")
      .def("__repr__",
           [](const Result& r) {
             return "<kerf.Run, " + std::to_string(py::len(r.ticks)) +
                    " ticks, warnings: " + std::to_string(r.warnings.size()) + ">";
           })
      .def_readonly("difference", &Result::difference,
                    "Of a replay: (time_s, what) of the first difference from the recording; None if there is none.");
  const auto progress = py::arg("progress") = py::none();
  m.def("run", &RunScene, py::arg("scene"), py::arg("bone") = py::none(), py::arg("record") = py::none(), progress,
        R"(Runs a Scene, or the file of that name, as `kerf run` does, with the same bits; in slab mode if it says so.

bone: instead of the scene's; such a run cannot be recorded. record: file name of a recording to be written, which must
not exist. progress: None, False, or a function of the completed fraction.)");
  m.def("run_in_hand", &RunSceneInHand, py::arg("scene"), py::arg("seconds") = 10.0, py::arg("real_time") = false,
        py::arg("record") = py::none(), progress,
        R"(Runs a scene with the tool in the scene's simulated hand, as `kerf loop` does.

seconds: 0.01 to 36000. real_time: at the scene's rate; otherwise as fast as possible, with the same bits each time.
record, progress: as for run().)");
  py::class_<SharedRecording>(m, "Recording", "A recording (.kerf). Of a damaged one, all that can be read is used.")
      .def(py::init([](const std::filesystem::path& path) { return std::make_unique<SharedRecording>(path); }),
           py::arg("path"))
      .def(py::pickle([](const SharedRecording& r) { return py::bytes(r.absolute_path); },
                      [](const py::bytes& state) {
                        return std::make_unique<SharedRecording>(OfState("Recording", [&] {
                          auto path = std::string(state);
                          if (path.empty() || path.find('\0') != std::string::npos) throw py::cast_error();
                          return path;
                        }));
                      }))
      .def_property_readonly(
          "kind", [](const SharedRecording& r) { return r.recording.kind(); },
          "'run' along a path, 'slab', or 'loop' in a hand.")
      .def_property_readonly(
          "created", [](const SharedRecording& r) { return r.recording.created(); }, "UTC.")
      .def_property_readonly(
          "version", [](const SharedRecording& r) { return r.recording.version(); }, "Version of kerf that made it.")
      .def_property_readonly("rate_hz", [](const SharedRecording& r) { return r.recording.rate_hz(); })
      .def_property_readonly("duration_s", [](const SharedRecording& r) { return r.recording.duration_s(); })
      .def_property_readonly(
          "damage", [](const SharedRecording& r) { return ShowText(r.recording.damage()); },
          "One sentence; '' if the recording is whole.")
      .def_property_readonly(
          "moments",
          [](const SharedRecording& shared) {
            py::list list;
            for (const RecordedMoment& moment : shared.recording.moments()) {
              list.append(py::make_tuple(moment.time_s, moment.what, moment.name));
            }
            return list;
          },
          "List of (time_s, what, name), such as checkpoints.")
      .def_property_readonly(
          "scene", [](const SharedRecording& r) { return r.recording.scene(); },
          "The recorded scene with all its settings.")
      .def(
          "inputs",
          [](SharedRecording& shared) {
            const Turn turn(shared.busy, "recording");
            return MakeInputTable(shared.recording);
          },
          R"(Inputs of all ticks, as a structured array.

Columns: time_s, x_mm, y_mm, z_mm, qw, qx, qy, qz (of the handle, or of the tool on a path), dt_s, rpm, buttons, set_down.
A row with set_down = 1 is no tick: the tool is placed at the pose, and dt_s and rpm are 0. A recording of a path begins
with such a row, and so does each stroke after a retraction; the other rows are those of replay().ticks.)")
      .def("replay", &Replay, progress,
           "Runs the session again; `difference` of the result is None if it has the same bits.")
      .def(
          "__len__", [](const SharedRecording& r) { return r.recording.ticks(); }, "Rows of inputs().")
      .def("__repr__", [](const SharedRecording& r) {
        return ShowText("<kerf.Recording '" + r.absolute_path + "', " + r.recording.kind() + ">");
      });
}

}  // namespace kerf::python
