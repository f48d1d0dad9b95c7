#include "bone/import/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <vector>

#include "bone/import/image_fields.h"
#include "bone/import/image_header.h"
#include "bone/import/nifti.h"
#include "bone/import/nrrd_lattice.h"
#include "bone/import/patient_frame.h"
#include "bone/import/voxel_values.h"
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
  if (origin.empty()) {
    volume.warnings.emplace_back("the MetaImage header has no Offset: the first voxel was taken to lie at 0, 0, 0");
  }
  ReinterpretFrame(volume.frame, volume);
}

// Throws kerf::Error if an axis of an NRRD runs over the values of a voxel instead of through space.
void CheckNrrdComponents(const ImageFields& fields, const ImageLayout& layout, const std::string& path) {
  const std::string kinds = Lower(fields.Get("kinds"));
  const std::string first = kinds.substr(0, kinds.find(' '));
  const bool through_space = first.empty() || first == "domain" || first == "space" || first == "time";
  if (layout.sizes.size() > 3 && !through_space) CheckOneComponent(static_cast<unsigned>(layout.sizes[0]), path);
}

Volume ReadNrrdOrMeta(const std::string& path, const std::string& frame, ImageLayout& layout) {
  Volume volume;
  const bool is_nrrd = IsNrrd(path);
  const ImageFields fields = is_nrrd ? ParseNrrdFields(ReadHead(path)) : ParseMetaFields(ReadHead(path));
  if (is_nrrd) {
    CheckNrrdComponents(fields, layout, path);
    SetNrrdFrame(fields, path, frame, volume);
  } else if (!frame.empty()) {
    volume.frame = frame;
  }
  if (layout.sizes.size() != 3) {
    throw Error(fmt::format("{}: the image has {} dimensions; kerf requires 3", path, layout.sizes.size()));
  }
  CheckOneComponent(static_cast<unsigned>(layout.components), path);
  for (std::size_t a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(layout.sizes[a]);
  if (is_nrrd) {
    PlaceNrrd(fields, path, volume);
  } else {
    PlaceMeta(fields, path, !frame.empty(), volume);
  }
  CheckLattice(volume, path);
  const std::vector<char> bytes = ReadVoxels(layout, volume.count(), path);
  const Overflow overflow = AppendHu(bytes, layout.type, 1, 0, path, volume.hu);
  volume.exact = overflow.count == 0 && !overflow.rounded;
  if (overflow.count > 0) volume.warnings.push_back(Describe(overflow, volume.count()));
  return volume;
}

}  // namespace

Volume ReadImageFile(const std::string& path, const std::string& frame) {
  ImageCheck check = CheckImageHeader(path);
  Volume volume = HasNiftiExtension(path) ? ReadNifti(path, frame) : ReadNrrdOrMeta(path, frame, check.layout);
  volume.warnings.insert(volume.warnings.end(), check.warnings.begin(), check.warnings.end());
  return volume;
}

}  // namespace kerf
