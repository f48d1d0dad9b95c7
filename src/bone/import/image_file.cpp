#include "bone/import/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <utility>
#include <vector>

#include "bone/import/image_fields.h"
#include "bone/import/image_header.h"
#include "bone/import/limits.h"
#include "bone/import/nifti.h"
#include "bone/import/nrrd_lattice.h"
#include "bone/import/patient_frame.h"
#include "bone/import/voxel_values.h"
#include "bone/import/vti.h"
#include "kerf/error.h"

namespace kerf {

namespace {

bool IsNrrd(const std::string& path) {
  return EndsWith(Lower(path), ".nrrd") || EndsWith(Lower(path), ".nhdr");
}

// Returns the first of the fields `names` that a MetaImage header has, as rows of which the first three numbers are
// used; empty if it has none of them.
std::vector<Vec3> ParseMetaRows(const ImageFields& fields, std::initializer_list<const char*> names, std::size_t rows,
                                const std::string& path) {
  for (const char* name : names) {
    const std::string key = Lower(name);
    if (!fields.Contains(key)) continue;
    const std::size_t columns = ParseNumbers(fields.Get("dimsize")).size();
    const std::vector<double> numbers = ParseNumbers(fields.Get(key));
    if (columns < 3 || numbers.size() < (rows == 1 ? 3 : rows * columns)) {
      throw Error(fmt::format("{}: the MetaImage header's {} '{}' should have {} numbers", path, name, fields.Get(key),
                              rows * columns));
    }
    std::vector<Vec3> parsed;
    for (std::size_t n = 0; n < rows; ++n) {
      const double* row = &numbers[n * columns];
      parsed.emplace_back(row[0], row[1], row[2]);
    }
    return parsed;
  }
  return {};
}

void PlaceMeta(const ImageFields& fields, const std::string& path, bool frame_stated, Volume& volume) {
  const double unit_mm = CheckMetaSpacing(fields, path);
  const bool has_spacing = ParseNumbers(fields.Get("elementspacing")).size() >= 3;
  volume.spacing_mm =
      unit_mm * ParseMetaRows(fields, {has_spacing ? "ElementSpacing" : "ElementSize"}, 1, path).front();
  const std::vector<Vec3> origin = ParseMetaRows(fields, {"Offset", "Position", "Origin"}, 1, path);
  if (!origin.empty()) volume.origin_W = unit_mm * origin.front();
  const std::vector<Vec3> axes = ParseMetaRows(fields, {"TransformMatrix", "Rotation", "Orientation"}, 3, path);
  for (std::size_t a = 0; a < axes.size(); ++a) volume.axes_W[static_cast<int>(a)] = axes[a];
  for (int a = 0; a < 3; ++a) {
    const double length = glm::length(volume.axes_W[a]);
    if (std::abs(length - 1) > 1e-3) {
      throw Error(
          fmt::format("{}: an axis of the header's TransformMatrix has the length {:.4g} instead of 1, so the "
                      "size of a voxel is unclear",
                      path, length));
    }
  }
  if (axes.empty() && !frame_stated) {
    volume.warnings.emplace_back(
        "the MetaImage header has no TransformMatrix: its axes were taken to point left, posterior and superior; check "
        "that left is left");
  }
  for (const char* name : {"ElementToIntensityFunctionSlope", "ElementToIntensityFunctionOffset"}) {
    const std::vector<double> numbers = ParseNumbers(fields.Get(Lower(name)));
    if (numbers.empty() || numbers[0] == (std::string_view(name).ends_with("Slope") ? 1 : 0)) continue;
    throw Error(
        fmt::format("{}: the MetaImage header's {} is {}, which kerf doesn't apply; export the file with the values "
                    "themselves",
                    path, name, numbers[0]));
  }
  if (origin.empty()) {
    volume.warnings.emplace_back("the MetaImage header has no Offset: the first voxel was taken to lie at 0, 0, 0");
  }
  ReinterpretFrame(volume.frame, volume);
}

// Axis of an NRRD that runs over the values of a voxel instead of through space.
enum class ValueAxis { kNone, kFirst, kLast };

ValueAxis FindValueAxis(const ImageFields& fields, std::size_t dimensions) {
  if (dimensions < 4) return ValueAxis::kNone;
  const std::string kinds = Lower(fields.Get("kinds"));
  const std::string directions = Lower(fields.Get("spacedirections"));
  const auto is_value = [](const std::string& kind) { return kind != "domain" && kind != "space" && kind != "time"; };
  if (kinds.empty()) {
    if (directions.compare(0, 4, "none") == 0) return ValueAxis::kFirst;
    return EndsWith(directions, "none") ? ValueAxis::kLast : ValueAxis::kNone;
  }
  if (is_value(kinds.substr(0, kinds.find(' ')))) return ValueAxis::kFirst;
  return is_value(kinds.substr(kinds.rfind(' ') + 1)) ? ValueAxis::kLast : ValueAxis::kNone;
}

// Returns the values of each layer. On the first axis, those of one voxel follow each other.
std::vector<std::vector<std::int16_t>> SplitLayers(std::vector<std::int16_t> values, std::size_t layers,
                                                   ValueAxis axis) {
  std::vector<std::vector<std::int16_t>> split(layers);
  if (layers == 1) {
    split[0] = std::move(values);
    return split;
  }
  const std::size_t count = values.size() / layers;
  const std::size_t step = axis == ValueAxis::kFirst ? layers : 1;
  for (std::size_t n = 0; n < layers; ++n) {
    split[n].reserve(count);
    std::size_t from = axis == ValueAxis::kFirst ? n : n * count;
    for (std::size_t v = 0; v < count; ++v, from += step) split[n].push_back(values[from]);
  }
  return split;
}

LayeredImage ReadNrrdOrMeta(const std::string& path, const std::string& frame, ImageLayout& layout,
                            std::size_t max_layers, double scale) {
  LayeredImage image;
  Volume& volume = image.lattice;
  const bool is_nrrd = IsNrrd(path);
  ImageFields fields = is_nrrd ? ParseNrrdFields(ReadHead(path)) : ParseMetaFields(ReadHead(path));
  std::vector<double> sizes = layout.sizes;
  std::size_t layers = 1;
  ValueAxis axis = ValueAxis::kNone;
  if (is_nrrd) {
    const std::vector<double> all_sizes = ParseNumbers(fields.Get("sizes"));
    axis = FindValueAxis(fields, all_sizes.size());
    if (axis != ValueAxis::kNone) {
      const bool first = axis == ValueAxis::kFirst;
      const double values = first ? all_sizes.front() : all_sizes.back();
      if (values > static_cast<double>(max_layers)) {
        if (max_layers == 1) CheckOneComponent(static_cast<unsigned>(values), path);
        throw Error(fmt::format("{}: the image has {:.0f} layers; kerf reads up to {}", path, values, max_layers));
      }
      layers = static_cast<std::size_t>(values);
      sizes.assign(all_sizes.begin() + (first ? 1 : 0), all_sizes.end() - (first ? 0 : 1));
      while (sizes.size() > 3 && sizes.back() == 1) sizes.pop_back();
    }
    SetNrrdFrame(fields, path, frame, volume);
  } else if (!frame.empty()) {
    volume.frame = frame;
  }
  if (sizes.size() != 3) {
    throw Error(fmt::format("{}: the image has {} dimensions; kerf requires 3", path, sizes.size()));
  }
  CheckOneComponent(static_cast<unsigned>(layout.components), path);
  for (std::size_t a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(sizes[a]);
  if (is_nrrd) {
    PlaceNrrd(fields, path, volume);
  } else {
    PlaceMeta(fields, path, !frame.empty(), volume);
  }
  CheckLattice(volume, path);
  const std::size_t count = volume.count() * layers;
  const std::vector<char> bytes = ReadVoxels(layout, count, path);
  const std::int16_t blank = max_layers > 1 ? std::int16_t{0} : kBlankHu;
  std::vector<std::int16_t> values;
  const Overflow overflow = AppendHu(bytes, layout.type, scale, 0, values, blank);
  if (layers == 1) volume.padding = overflow.is_blank;
  volume.exact = overflow.count == 0 && !overflow.rounded;
  AddWarnings(overflow, count, blank, volume.warnings);
  image.layers = SplitLayers(std::move(values), layers, axis);
  image.keys = std::move(fields.keys);
  return image;
}

LayeredImage ReadLayers(const std::string& path, const std::string& frame, std::size_t max_layers, double scale) {
  ImageCheck check = CheckImageHeader(path, max_layers > 1 ? ImageContent::kLabels : ImageContent::kCt);
  LayeredImage image;
  const std::int16_t blank = max_layers > 1 ? std::int16_t{0} : kBlankHu;
  if (HasNiftiExtension(path) || IsVtiPath(path)) {
    image.lattice = IsVtiPath(path) ? ReadVti(path, frame, scale, blank) : ReadNifti(path, frame, scale, blank);
    image.layers.push_back(std::move(image.lattice.hu));
    image.lattice.hu.clear();
  } else {
    image = ReadNrrdOrMeta(path, frame, check.layout, max_layers, scale);
  }
  std::vector<std::string>& warnings = image.lattice.warnings;
  warnings.insert(warnings.end(), check.warnings.begin(), check.warnings.end());
  return image;
}

}  // namespace

Volume ReadImageFile(const std::string& path, const std::string& frame) {
  LayeredImage image = ReadLayers(path, frame, 1, 1);
  image.lattice.hu = std::move(image.layers.front());
  return std::move(image.lattice);
}

LayeredImage ReadLayeredImage(const std::string& path, const std::string& frame, double scale) {
  return ReadLayers(path, frame, kMaxLabelLayers, scale);
}

}  // namespace kerf
