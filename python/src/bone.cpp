#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "copies.h"
#include "kerf/bone_file.h"
#include "kerf/error.h"
#include "kerf/import.h"
#include "kerf/label_map.h"
#include "kerf/models.h"
#include "kerf/surface.h"
#include "long_work.h"
#include "parameters.h"
#include "text.h"

namespace kerf::python {
namespace {

using SharedBone = std::shared_ptr<Bone>;

SharedBone Share(Bone&& bone) {
  return std::make_shared<Bone>(std::move(bone));
}

const MaterialTable& OrDefault(const std::optional<MaterialTable>& materials) {
  return materials ? *materials : DefaultMandibleTable();
}

SharedBone MakeBlockWatched(const BlockParams& params, const std::optional<MaterialTable>& materials, const char* label,
                            const py::object& progress) {
  return Share(RunLong(progress, label,
                       [&](Watch& watch) { return MakeBlock(params, OrDefault(materials), ThrowToEnd(watch)); }));
}

SharedBone MakeBlockBone(const py::object& size_mm, const std::vector<std::pair<double, int>>& layers, double voxel_mm,
                         const py::object& top_mm, const py::object& rotation,
                         const std::optional<MaterialTable>& materials, const py::object& progress) {
  BlockParams params;
  params.size_mm = ToVec3(size_mm, "size_mm");
  for (const auto& [thickness_mm, region] : layers) params.layers.push_back({thickness_mm, region});
  params.voxel_mm = voxel_mm;
  params.X_WB.p_AB = ToVec3(top_mm, "top_mm");
  py::dict turned;
  if (!rotation.is_none()) turned["rotation"] = rotation;
  ParameterSetter setter(turned);
  setter("rotation", params.X_WB.R_AB, "");
  return MakeBlockWatched(params, materials, "block", progress);
}

SharedBone MakePlateBone(double voxel_mm, const std::optional<MaterialTable>& materials, const py::object& progress) {
  BlockParams params = MakePlateParams();
  params.voxel_mm = voxel_mm;
  return MakeBlockWatched(params, materials, "plate", progress);
}

SharedBone MakeMandibleBone(const std::optional<MaterialTable>& materials, const py::object& progress,
                            const py::kwargs& arguments) {
  const auto params = ReadParameters<MandibleParams>(arguments, "mandible");
  return Share(RunLong(progress, "mandible",
                       [&](Watch& watch) { return MakeMandible(params, OrDefault(materials), ThrowToEnd(watch)); }));
}

std::string ToFileName(const py::handle& value, const char* name) {
  try {
    return value.cast<std::filesystem::path>().string();
  } catch (const py::cast_error&) {
    throw Error(std::string(name) + " must be the name of a file");
  }
}

/// `value`: dict from a label's number or a segment's name to what it is. Returns texts such as "2=mandible".
std::vector<std::string> ToAssignments(const py::handle& value, const char* name) {
  if (!py::isinstance<py::dict>(value)) {
    throw Error(std::string(name) + " must be a dict such as {2: 'mandible', 'Bone 3': 'canal'}");
  }
  std::vector<std::string> assignments;
  for (const auto& [label, role] : value.cast<py::dict>()) {
    assignments.push_back(ToUtf8(py::str(label)) + "=" + ToUtf8(py::str(role)));
  }
  return assignments;
}

/// `path`: nullopt for a mask alone. `arguments`: members of ImportSettings.
py::tuple ImportFile(const std::optional<std::filesystem::path>& path, const std::optional<MaterialTable>& materials,
                     const py::object& progress, const py::kwargs& arguments) {
  ImportSettings settings;
  settings.materials = materials;
  py::dict rest(arguments);
  ParameterSetter set(rest);
  const Range any{-1e9, 1e9};  // ImportBone() checks the ranges
  set("voxel_mm", settings.voxel_mm, any, "");
  set("series", settings.series, TextLimit{1000}, "");
  set("as_ct", settings.as_ct, "");
  set("frame", settings.frame, TextLimit{10}, "");
  set("spacing_z_mm", settings.spacing_z_mm, any, "");
  set("iso_hu", settings.iso_hu, any, "");
  set("iso_auto", settings.iso_auto, "");
  set("isolate", settings.isolate, "");
  set("fill", settings.fill, "");
  set("keep_hu", settings.keep_hu, "");
  set("mask_labels", settings.mask_labels, TextLimit{100}, "");
  set("mask_threshold", settings.mask_threshold, any, "");
  set("mask_reach_mm", settings.mask_reach_mm, any, "");
  set("mesh_units", settings.mesh_units, TextLimit{10}, "");
  set("mesh_shell_mm", settings.mesh_shell_mm, any, "");
  for (const auto& [key, points] : {std::pair("keep", &settings.keep_W), std::pair("drop", &settings.drop_W)}) {
    set.AddKnown(key);
    if (rest.contains(key)) *points = ToPoints(rest.attr("pop")(key), key);
  }
  for (const char* key : {"mask", "mask_label"}) set.AddKnown(key);
  if (rest.contains("mask")) settings.mask = ToFileName(rest.attr("pop")("mask"), "mask");
  if (rest.contains("mask_label")) settings.mask_label = ToAssignments(rest.attr("pop")("mask_label"), "mask_label");
  set.CheckRest("from_file");
  ImportedBone imported = RunLong(progress, "import", [&](Watch& watch) {
    settings.progress = [&](double fraction) { return watch(fraction); };
    return ImportBone(path ? path->string() : "", settings);
  });
  py::dict report;
  report["mandible"] = imported.mandible;
  report["surface_error_mm"] = imported.surface_error_mm;
  report["warnings"] = ShowTexts(imported.warnings);
  return py::make_tuple(Share(std::move(imported.bone)), report);
}

using Labels = py::array_t<std::uint8_t, py::array::f_style | py::array::forcecast>;

/// Throws kerf::Error for numbers that uint8 cannot hold.
Labels ToLabels(const py::array& array) {
  const char kind = array.dtype().kind();
  if (kind != 'b' && kind != 'i' && kind != 'u') {
    throw Error("labels must be whole numbers of an integer type, not " + py::str(array.dtype()).cast<std::string>() +
                "; convert them with labels.astype(int)");
  }
  if (array.ndim() != 3) throw Error("labels must have three dimensions");
  if (array.size() > 0) {
    const py::object lowest = array.attr("min")(), highest = array.attr("max")();
    if (py::cast<double>(lowest) < 0 || py::cast<double>(highest) > 255) throw Error("labels must be 0 to 255");
  }
  for (int i = 0; i < 3; ++i) {
    if (array.shape(i) > std::numeric_limits<int>::max()) throw Error("labels must have less than 2^31 voxels an axis");
  }
  Labels labels = TryArray<Labels>(array);
  if (!labels) throw std::bad_alloc();  // any other reason was excluded above
  return labels;
}

SharedBone MakeLabelBone(const py::object& given, const std::map<int, int>& regions, double voxel_mm,
                         const py::object& spacing_mm, const py::object& pose,
                         const std::optional<MaterialTable>& materials, const py::object& progress) {
  const auto array = TryArray<py::array>(given);
  if (!array) throw Error("labels must be an array of whole numbers");
  const Labels labels = ToLabels(array);
  LabelMap map;
  for (int i = 0; i < 3; ++i) map.size[static_cast<std::size_t>(i)] = static_cast<int>(labels.shape(i));
  map.spacing_mm = ToVec3(spacing_mm, "spacing_mm");
  map.X_WL = ToPose(pose, "pose");
  map.labels = {labels.data(), static_cast<std::size_t>(labels.size())};
  return Share(RunLong(progress, "labels", [&](Watch& watch) {
    return MakeBoneFromLabels(map, regions, voxel_mm, OrDefault(materials), ThrowToEnd(watch));
  }));
}

/// Evaluates `get(bone, point)` at points of n x 3.
template <typename T, typename Get>
py::array AtPoints(const Bone& bone, const py::object& points_W, Get&& get) {
  const std::vector<Vec3> points = ToPoints(points_W, "points");
  std::vector<T> values(points.size());
  {
    const Unlocked unlocked;
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = static_cast<T>(get(bone, points[i]));
  }
  const auto count = static_cast<py::ssize_t>(values.size());
  return MoveToArray(std::move(values), {count});
}

py::tuple MakeMesh(const Bone& bone, double adaptivity) {
  if (!(adaptivity >= 0 && adaptivity <= 1)) throw Error("adaptivity must be 0 to 1");
  TriangleMesh mesh = RunLong(py::bool_(false), "mesh", [&](Watch&) { return ExtractSurface(bone, adaptivity); });
  static_assert(sizeof(mesh.triangles[0]) == 3 * sizeof(std::uint32_t));
  auto* kept = new std::vector<std::array<std::uint32_t, 3>>(std::move(mesh.triangles));
  py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<std::array<std::uint32_t, 3>>*>(p); });
  py::array_t<std::uint32_t> triangles({static_cast<py::ssize_t>(kept->size()), py::ssize_t{3}},
                                       reinterpret_cast<const std::uint32_t*>(kept->data()), owner);
  return py::make_tuple(MovePoints(std::move(mesh.points)), triangles);
}

/// The arrays of voxels are the bone's own memory; each keeps the bone alive.
py::tuple MakeLeafViews(const py::object& self) {
  const std::vector<BoneLeaf> leaves = ListLeaves(py::cast<const Bone&>(self));
  std::vector<std::int32_t> first;
  first.reserve(3 * leaves.size());
  py::list views(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    for (const int index : leaves[i].first_voxel) first.push_back(index);
    py::array_t<float> view({8, 8, 8}, leaves[i].phi_mm.data(), self);
    view.attr("flags").attr("writeable") = false;
    views[i] = std::move(view);
  }
  const auto count = static_cast<py::ssize_t>(leaves.size());
  return py::make_tuple(MoveToArray(std::move(first), {count, py::ssize_t{3}}), views);
}

py::array CalcBoundsArray(const Bone& bone) {
  const Box3 box = bone.CalcBounds();
  return MovePoints({box.lower, box.upper});
}

std::string ShowHash(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

std::string ShowBone(const Bone& bone) {
  if (bone.empty()) return "<kerf.Bone, empty>";
  char text[200];
  const Vec3 size = bone.CalcBounds().size();
  std::snprintf(text, sizeof text, "<kerf.Bone, %.4g x %.4g x %.4g mm, voxels of %g mm, %.4g mm3>", size.x, size.y,
                size.z, bone.voxel_mm(), bone.CalcVolume());
  return text;
}

py::dict ShowNotes(const Bone& bone) {
  py::dict notes;
  for (const auto& [key, value] : bone.notes()) notes[ShowText(key)] = ShowText(value);
  return notes;
}

// ---- pickling: a bone is its file, with the materials that the run gave it

/// Path of a bone's file in a folder that is removed with `folder`.
std::string MakeTemporaryPath(py::object& folder) {
  folder = py::module_::import("tempfile").attr("TemporaryDirectory")(py::arg("prefix") = "kerf_");
  return py::cast<std::filesystem::path>(folder.attr("name")).string() + "/bone.vdb";
}

/// Throws TypeError for a bone with moduli of a CT, which its file does not contain.
py::tuple GetBoneState(const Bone& bone) {
  if (bone.empty()) return py::make_tuple(py::bytes(), bone.materials());
  Bone without_voxels;
  without_voxels.set_materials(bone.materials());
  if (without_voxels.CalcMaterialHash() != bone.CalcMaterialHash()) {
    throw py::type_error("a bone whose moduli come from a CT cannot be pickled; pickle its scene instead");
  }
  py::object folder;
  const std::string path = MakeTemporaryPath(folder);
  {
    const Unlocked unlocked;
    WriteBone(bone, path);
  }
  const py::bytes bytes = py::module_::import("pathlib").attr("Path")(path).attr("read_bytes")();
  folder.attr("cleanup")();
  return py::make_tuple(bytes, bone.materials());
}

SharedBone MakeBoneOfState(const py::tuple& state) {
  const auto [bytes, materials] =
      OfState("Bone", [&] { return std::pair(py::bytes(py::object(state[0])), py::cast<MaterialTable>(state[1])); });
  Bone bone;
  if (py::len(bytes) == 0) {
    bone.set_materials(materials);
    return Share(std::move(bone));
  }
  py::object folder;
  const std::string path = MakeTemporaryPath(folder);
  py::module_::import("pathlib").attr("Path")(path).attr("write_bytes")(bytes);
  std::string fault;
  try {
    const Unlocked unlocked;
    bone = ReadBone(path, {.hu = true});
  } catch (const Error& e) {
    fault = e.what();
    if (fault.starts_with(path)) fault.replace(0, path.size(), "the pickled bone");
  }
  folder.attr("cleanup")();
  if (!fault.empty()) throw Error(fault);
  Bone without_voxels;
  without_voxels.set_materials(materials);
  if (without_voxels.CalcMaterialHash() != bone.CalcMaterialHash()) bone.OverrideMaterials(materials);
  return Share(std::move(bone));
}

py::tuple GetRegionState(const Region& r) {
  return py::make_tuple(r.id, r.name, static_cast<int>(r.tissue), r.E_MPa, r.nu, r.estimate, r.source, r.E_lower_MPa,
                        r.E_upper_MPa);
}

Region MakeRegionOfState(const py::tuple& state) {
  return OfState("Region", [&] {
    const int tissue = py::cast<int>(state[2]);
    if (tissue < 0 || tissue > static_cast<int>(Tissue::kLesion) || py::len(state) != 9) throw py::cast_error();
    Region region{.id = py::cast<int>(state[0]),
                  .name = py::cast<std::string>(state[1]),
                  .tissue = static_cast<Tissue>(tissue),
                  .E_MPa = py::cast<double>(state[3]),
                  .nu = py::cast<double>(state[4]),
                  .estimate = py::cast<bool>(state[5]),
                  .source = py::cast<std::string>(state[6]),
                  .E_lower_MPa = py::cast<double>(state[7]),
                  .E_upper_MPa = py::cast<double>(state[8])};
    MaterialTable().Add(region);  // checks it
    return region;
  });
}

py::tuple GetMaterialState(const MaterialTable& table) {
  py::list regions;
  for (const auto& [id, region] : table.regions()) regions.append(region);
  const std::optional<Vec3>& direction = table.osteon_direction();
  return py::make_tuple(regions, direction ? py::object(FromVec3(*direction)) : py::none());
}

MaterialTable MakeMaterialsOfState(const py::tuple& state) {
  return OfState("Materials", [&] {
    MaterialTable table;
    for (const py::handle region : state[0]) table.Add(py::cast<Region>(region));
    if (!state[1].is_none()) table.SetOsteonDirection(ToVec3(state[1], "direction"));
    return table;
  });
}

MaterialTable MakeMaterials(const std::vector<Region>& regions) {
  if (regions.empty()) throw Error("regions must have at least one Region");
  MaterialTable table;
  for (const Region& region : regions) table.Add(region);
  return table;
}

Region MakeRegion(int id, const Text& name, const Text& tissue, double E_MPa, double nu, const Text& source,
                  bool estimate) {
  const std::optional<Tissue> known = TissueFromString(tissue.utf8);
  if (!known) {
    throw Error("tissue must be 'cortical', 'cancellous', 'tooth', 'canal', 'other', 'metal' or 'lesion', not '" +
                tissue.utf8 + "'");
  }
  Region region{.id = id,
                .name = name.utf8,
                .tissue = *known,
                .E_MPa = E_MPa,
                .nu = nu,
                .estimate = estimate,
                .source = source.utf8};
  MaterialTable().Add(region);  // checks it
  return region;
}

void BindMaterials(py::module_& m) {
  py::class_<Region> region_class(m, "Region", "A part of the bone with uniform elastic constants.");
  BindCopies(region_class);
  region_class.def(py::pickle(&GetRegionState, &MakeRegionOfState))
      .def(py::init(&MakeRegion), py::arg("id"), py::arg("name"), py::arg("tissue"), py::arg("E_MPa"), py::arg("nu"),
           py::arg("source") = "given in Python", py::arg("estimate") = true,
           "id: 1 to 255. tissue: 'cortical', 'cancellous', 'tooth', 'canal', 'other', 'metal' or 'lesion'. E_MPa: "
           "Young's modulus. nu: Poisson's ratio. source: source of the constants. estimate: they are assumed, not "
           "measured.")
      .def_readonly("id", &Region::id)
      .def_readonly("name", &Region::name)
      .def_property_readonly("tissue", [](const Region& r) { return ToString(r.tissue); })
      .def_readonly("E_MPa", &Region::E_MPa, "Young's modulus, MPa.")
      .def_readonly("nu", &Region::nu, "Poisson's ratio.")
      .def_readonly("source", &Region::source)
      .def_readonly("estimate", &Region::estimate)
      .def("__repr__", [](const Region& r) {
        char text[100];
        std::snprintf(text, sizeof text, "', %s, E = %g MPa, nu = %g>", ToString(r.tissue), r.E_MPa, r.nu);
        return "<kerf.Region " + std::to_string(r.id) + " '" + r.name + text;
      });
  py::class_<MaterialTable> table_class(m, "Materials", "Elastic constants by region. Cannot be changed.");
  BindCopies(table_class);
  table_class.def(py::pickle(&GetMaterialState, &MakeMaterialsOfState))
      .def(py::init(&MakeMaterials), py::arg("regions"), "Makes a table of a list of Region.")
      .def_static(
          "default", [] { return DefaultMandibleTable(); },
          "The regions of the mandible that are built in: 1 to 31 cortex, 32 cancellous bone, 33 teeth, 34 nerve "
          "canal.")
      .def_static(
          "parse", [](const Text& csv, const Text& name) { return ParseRegionTable(csv.utf8, name.utf8); },
          py::arg("csv"), py::arg("name") = "materials.csv",
          "Reads a table from CSV text (docs/formats.md). `name` is used in messages.")
      .def("uniform", &MakeUniformTable, py::arg("E_MPa"), py::arg("nu"), "Returns the same regions with one E and nu.")
      .def("csv", &FormatRegionTable, "Returns the table as CSV text.")
      .def_property_readonly(
          "regions",
          [](const MaterialTable& table) {
            py::dict regions;
            for (const auto& [id, region] : table.regions()) regions[py::cast(id)] = py::cast(region);
            return regions;
          },
          "Dict of Region by id.")
      .def(
          "__getitem__", [](const MaterialTable& table, int id) { return table.At(id); }, py::arg("id"))
      .def(
          "__contains__", [](const MaterialTable& table, int id) { return table.Contains(id); }, py::arg("id"))
      .def("__len__", [](const MaterialTable& table) { return table.regions().size(); })
      .def("__repr__", [](const MaterialTable& table) {
        return "<kerf.Materials, " + std::to_string(table.regions().size()) + " regions>";
      });
}

}  // namespace

void BindBone(py::module_& m) {
  BindMaterials(m);
  const auto materials = py::arg("materials") = py::none();
  const auto progress = py::arg("progress") = py::none();
  static const std::string mandible =
      "Makes the generic mandible (docs/mandible.md). Frame: LPS, mm; origin between the edges "
      "of the lower central incisors.\n\nParameters, each by name:\n" +
      ListParameters<MandibleParams>();
  py::class_<Bone, SharedBone> bone_class(m, "Bone", R"(Bone: a level set and a grid of regions. Cannot be changed.

Lengths are in mm, in the world frame (of a CT: the patient's, LPS). phi is the signed distance to the surface, negative
inside, and limited to +-band_mm.)");
  bone_class.def(py::pickle(&GetBoneState, &MakeBoneOfState))
      .def_static("block", &MakeBlockBone, py::arg("size_mm") = py::make_tuple(40, 20, 20),
                  py::arg("layers") = py::list(), py::arg("voxel_mm") = 0.1,
                  py::arg("top_mm") = py::make_tuple(0, 0, 0), py::arg("rotation") = py::none(), materials, progress,
                  R"(Makes a box with layers of material.

size_mm: edges along x, y, z. layers: list of (thickness_mm, region) from the top face (+z) down; the last one fills the
rest; [] is region 24. voxel_mm: 0.02 to 4. top_mm: middle of the top face. rotation: unit quaternion w, x, y, z.)")
      .def_static("plate", &MakePlateBone, py::arg("voxel_mm") = 0.1, materials, progress,
                  "Makes a plate of the mandible's body laid flat: cortical 2.2 mm, cancellous, cortical 2.0 mm; 13.5 "
                  "mm in all.")
      .def_static("mandible", &MakeMandibleBone, materials, progress, mandible.c_str())
      .def_static("from_file", &ImportFile, py::arg("path"), materials, progress,
                  R"(Imports a CT, a segmentation or a closed surface; returns (bone, report).

path: DICOM (a folder, a DICOMDIR, a slice or a .zip), an image (.nrrd .nhdr .mha .mhd .vti .nii .nii.gz .hdr .img) or a surface (.stl .obj .ply); None: the mask alone. report: dict with
'mandible' (bool), 'surface_error_mm' (rms, 0 if unknown) and 'warnings' (list of texts).

Options, each by name: voxel_mm = 0.1 (0.05 to 2). Of a CT: series (UID or its end), as_ct = False (read DICOM of
modality OT or secondary captures as a CT), frame ('LPS' or 'RAS'), spacing_z_mm, iso_hu = 300,
iso_auto = False (find it in the histogram, for values that are not HU),
isolate = True (separate the mandible), keep, drop (points (n, 3) in wanted and unwanted bone), fill = True, keep_hu = False.
Of a segmentation, as the options --mask, --labels, --label, --mask-threshold and --mask-reach of kerf import: mask (.seg.nrrd or a label map),
mask_labels (the program that wrote a label map without names, such as 'dentalsegmentator'), mask_label (dict such as
{2: 'mandible'}), mask_threshold = 0.5 (fraction from which on a voxel of a fractional segmentation or soft map counts),
mask_reach_mm = 0 (distance from its border beyond which it overrides the CT; 0: automatic).
Of a surface: mesh_units ('mm', 'cm', 'm', 'in', 'um'), mesh_shell_mm = 2 (thickness of the cortex).)")
      .def_static("from_labels", &MakeLabelBone, py::arg("labels"), py::arg("regions"), py::arg("voxel_mm") = 0.2,
                  py::arg("spacing_mm") = py::make_tuple(1, 1, 1), py::arg("pose") = py::make_tuple(0, 0, 0), materials,
                  progress,
                  R"(Makes a bone of a label map.

labels: array (nx, ny, nz) of whole numbers, 0 to 255. regions: dict from label to region; other labels are not bone. spacing_mm: of the
lattice along its axes. pose: of the lattice in the world; its origin is the centre of voxel (0, 0, 0).)")
      .def_static(
          "read",
          [](const std::filesystem::path& path, bool hu) {
            if (path.empty()) throw Error("path must be the name of a file");
            const Unlocked unlocked;
            return Share(ReadBone(path.string(), {.hu = hu}));
          },
          py::arg("path"), py::arg("hu") = false,
          "Reads a .vdb file of kerf. hu: also the CT numbers, if there are any.")
      .def(
          "write",
          [](const Bone& bone, const std::filesystem::path& path) {
            const Unlocked unlocked;
            WriteBone(bone, path.string());
          },
          py::arg("path"), "Writes a .vdb file, which any OpenVDB program can open.")
      .def(
          "phi",
          [](const Bone& bone, const py::object& points) {
            return AtPoints<double>(bone, points, [](const Bone& b, const Vec3& p) { return b.SignedDistance(p); });
          },
          py::arg("points"), "Signed distance to the surface, mm, at points (n, 3); array (n,).")
      .def(
          "region",
          [](const Bone& bone, const py::object& points) {
            return AtPoints<std::int32_t>(bone, points, [](const Bone& b, const Vec3& p) { return b.RegionAt(p); });
          },
          py::arg("points"), "Region id at points (n, 3), 0 outside the bone; array (n,) of int32.")
      .def(
          "modulus",
          [](const Bone& bone, const py::object& points) {
            return AtPoints<double>(bone, points, [](const Bone& b, const Vec3& p) { return b.ModulusAt(p); });
          },
          py::arg("points"), "Young's modulus at points (n, 3), MPa, 0 outside the bone; array (n,).")
      .def(
          "poisson_ratio",
          [](const Bone& bone, const py::object& points) {
            return AtPoints<double>(bone, points, [](const Bone& b, const Vec3& p) { return b.PoissonRatioAt(p); });
          },
          py::arg("points"), "Poisson's ratio at points (n, 3), 0 outside the bone; array (n,).")
      .def("mesh", &MakeMesh, py::arg("adaptivity") = 0.0,
           "Surface as (points, triangles): (n, 3) float64, mm, and (m, 3) uint32, counter-clockwise from outside. "
           "adaptivity: 0 to 1; larger values merge flat parts.")
      .def("leaves", &MakeLeafViews,
           "Leaves of the level set, without a copy: (first, leaves). first: (n, 3) int32, index of each leaf's first "
           "voxel, "
           "whose centre is at index * voxel_mm. leaves: list of n read-only arrays (8, 8, 8) of float32, phi in mm.")
      .def(
          "pieces",
          [](const Bone& bone, double min_mm3) {
            Pieces pieces = [&] {
              const Unlocked unlocked;
              return SplitPieces(bone, min_mm3);
            }();
            std::vector<SharedBone> list;
            for (Bone& piece : pieces.pieces) list.push_back(Share(std::move(piece)));
            return list;
          },
          py::arg("min_mm3") = 0.0, "Separate pieces, largest first, as a list of Bone; without those below min_mm3.")
      .def(
          "with_materials",
          [](const Bone& bone, const MaterialTable& table) {
            SharedBone copy = std::make_shared<Bone>(bone);
            copy->set_materials(table);
            return copy;
          },
          py::arg("materials"), "Returns a copy with other elastic constants.")
      .def_property_readonly("materials", [](const Bone& bone) { return bone.materials(); })
      .def_property_readonly("notes", &ShowNotes, "Provenance and other notes, dict of texts.")
      .def_property_readonly("voxel_mm", &Bone::voxel_mm)
      .def_property_readonly("region_voxel_mm", &Bone::region_voxel_mm)
      .def_property_readonly("band_mm", &Bone::band_mm, "Half width of the level set's band.")
      .def_property_readonly("empty", &Bone::empty)
      .def(
          "volume_mm3", [](const Bone& bone) { return bone.CalcVolume(); }, py::call_guard<Unlocked>())
      .def(
          "region_volumes_mm3", [](const Bone& bone) { return bone.CalcRegionVolumes(); },
          "Dict of volumes by region; their sum is volume_mm3().")
      .def("bounds_mm", &CalcBoundsArray, "Lower and upper corner of the surface: array (2, 3).")
      .def("memory_bytes", [](const Bone& bone) { return bone.CalcMemoryBytes(); })
      .def(
          "hash", [](const Bone& bone) { return ShowHash(bone.CalcHash()); },
          "Hash of all voxels, 16 hexadecimal digits, as the program prints it; equal for bit-identical bones.")
      .def("__repr__", &ShowBone);
  BindCopies(bone_class);
}

}  // namespace kerf::python
