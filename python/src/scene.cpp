#include "kerf/scene.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>

#include "arrays.h"
#include "bindings.h"
#include "copies.h"
#include "kerf/error.h"
#include "long_work.h"
#include "text.h"

namespace kerf::python {
namespace {

template <typename V>
void VisitStep(const PathStep& step, V&& visit) {
  visit("time_s", step.time_s);
  visit("segment", static_cast<std::int64_t>(step.segment + 1));
  visit("set_down", static_cast<std::int64_t>(step.set_down));
  visit("{}_mm", step.X_WT.p_AB);
  visit("qw", step.X_WT.R_AB.w);
  visit("qx", step.X_WT.R_AB.x);
  visit("qy", step.X_WT.R_AB.y);
  visit("qz", step.X_WT.R_AB.z);
  visit("dt_s", step.dt_s);
}

py::array ListSteps(const SceneFile& scene) {
  const std::vector<PathStep> steps = scene.ListPathSteps();
  Table table([](auto&& visit) { VisitStep({}, visit); });
  table.Reserve(steps.size());
  for (const PathStep& step : steps) VisitStep(step, table);
  return table.Take();
}

SceneFile MakeScene(const py::kwargs& tables) {
  if (tables.empty()) return {};
  return SceneFile::Parse(ToUtf8(py::module_::import("kerf._toml").attr("write")(tables)), "keywords.toml");
}

/// Throws kerf::Error if the scene contains the name of a file that TOML cannot contain.
std::string ResolveScene(const SceneFile& scene) {
  std::string toml = scene.Resolve();
  PyObject* text = PyUnicode_DecodeUTF8(toml.data(), static_cast<py::ssize_t>(toml.size()), nullptr);
  if (text == nullptr) {
    PyErr_Clear();
    throw Error("the scene names a file whose name is not valid UTF-8, which TOML cannot contain");
  }
  Py_DECREF(text);
  return toml;
}

/// The absolute path keeps the base of relative file names.
py::tuple GetSceneState(const SceneFile& scene) {
  return py::make_tuple(scene.toml(), py::bytes(std::filesystem::absolute(scene.path()).string()));
}

SceneFile MakeSceneOfState(const py::tuple& state) {
  return OfState("Scene", [&] {
    const auto path = py::cast<std::string>(state[1]);
    if (path.find('\0') != std::string::npos) throw py::cast_error();
    return SceneFile::Parse(py::cast<std::string>(state[0]), path);
  });
}

}  // namespace

void BindScene(py::module_& m) {
  py::class_<SceneFile> scene_class(m, "Scene", R"(A scene: all inputs of a run (docs/scene.md). Cannot be changed.

Scene() is the default scene. Scene(tool={"diameter_mm": 20}, ...) has the tables and keys of a scene file as keyword
arguments; positions in error messages refer to `toml`, the text that is made of them.)");
  scene_class.def(py::init(&MakeScene))
      .def(py::pickle(&GetSceneState, &MakeSceneOfState))
      .def_static(
          "read", [](const std::filesystem::path& path) { return SceneFile::Read(path.string()); }, py::arg("path"),
          "Reads a scene file.")
      .def_static(
          "parse",
          [](const Text& toml, const std::filesystem::path& path) {
            return SceneFile::Parse(toml.utf8, path.string());
          },
          py::arg("toml"), py::arg("path") = "scene.toml",
          "Reads a scene from text. `path` is used in messages and as the base of relative file names.")
      .def(
          "with_value",
          [](const SceneFile& scene, const Text& table, const Text& key, const py::object& value) {
            return scene.With(table.utf8, key.utf8,
                              ToUtf8(py::module_::import("kerf._toml").attr("write_value")(value)));
          },
          py::arg("table"), py::arg("key"), py::arg("value"),
          "Returns a copy with another value: scene.with_value('bone.block', 'voxel_mm', 0.2).")
      .def("resolve", &ResolveScene, "Returns the scene as TOML with every key, unit, range and meaning.")
      .def(
          "bone",
          [](const SceneFile& scene, const py::object& progress) {
            return std::make_shared<Bone>(RunLong(progress, "bone", [&](Watch& watch) {
              return scene.MakeBone([&](double fraction) { return watch(fraction); });
            }));
          },
          py::arg("progress") = py::none(), "Makes or reads the bone, with the scene's material.")
      .def("steps", &ListSteps,
           "Ticks and placements of the path, as a structured array: time_s, segment, set_down (1: the tool is placed "
           "at the "
           "pose, without a tick), x_mm, y_mm, z_mm, qw, qx, qy, qz, dt_s. The first row is where a simulation starts.")
      .def_property_readonly("toml", &SceneFile::toml)
      .def_property_readonly("path", [](const SceneFile& scene) { return DecodeFileName(scene.path()); })
      .def_property_readonly("name", [](const SceneFile& scene) { return ShowText(scene.name()); })
      .def_property_readonly("title", &SceneFile::title)
      .def_property_readonly("is_slab", &SceneFile::is_slab)
      .def_property_readonly("rate_hz", &SceneFile::rate_hz, "Ticks per second.")
      .def_property_readonly("rpm", &SceneFile::rpm, "Spindle speed; its sign is the sense about z of the tool.")
      .def("__repr__", [](const SceneFile& scene) { return ShowText("<kerf.Scene '" + scene.name() + "'>"); });
  BindCopies(scene_class);
}

}  // namespace kerf::python
