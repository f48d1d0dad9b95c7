#include "import/image_file.h"

#include <fmt/format.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "files/child.h"
#include "import/image_fields.h"
#include "import/image_header.h"
#include "import/itk_read.h"
#include "import/nifti.h"
#include "import/nrrd_lattice.h"
#include "import/patient_frame.h"
#include "import/volume_bytes.h"
#include "kerf/error.h"

namespace kerf {

namespace {

bool IsNrrd(const std::string& path) {
  return EndsWith(Lower(path), ".nrrd") || EndsWith(Lower(path), ".nhdr");
}

void PlaceMeta(const itk::ImageIOBase& io, const ImageFields& fields, const std::string& path, bool frame_stated,
               Volume& volume) {
  const double unit_mm = CheckMetaSpacing(fields, path);
  for (unsigned a = 0; a < 3; ++a) {
    volume.spacing_mm[a] = io.GetSpacing(a) * unit_mm;
    volume.origin_W[a] = io.GetOrigin(a) * unit_mm;
    const std::vector<double> axis = io.GetDirection(a);
    for (unsigned c = 0; c < 3; ++c) volume.axes_W[a][c] = axis[c];
  }
  for (int a = 0; a < 3; ++a) {
    const double length = glm::length(volume.axes_W[a]);
    if (std::abs(length - 1) > 1e-3) {
      throw Error(
          fmt::format("{}: an axis of the header's TransformMatrix has the length {:.4g} instead of 1, so the "
                      "size of a voxel is unclear",
                      path, length));
    }
  }
  const auto has_none = [&](std::initializer_list<const char*> names) {
    return std::none_of(names.begin(), names.end(), [&](const char* name) { return fields.Contains(name); });
  };
  if (has_none({"transformmatrix", "rotation", "orientation"}) && !frame_stated) {
    volume.warnings.emplace_back(
        "the MetaImage header has no TransformMatrix: its axes were taken to point left, posterior and superior; check "
        "that left is left");
  }
  if (has_none({"offset", "position", "origin"})) {
    volume.warnings.emplace_back("the MetaImage header has no Offset: the first voxel was taken to lie at 0, 0, 0");
  }
  StateFrame(volume.frame, volume);
}

// An NRRD's place is not taken from ITK, which turns LAS into something else and takes any other space as LPS.
Volume ReadByItk(const std::string& path, const std::string& frame, std::uint64_t promised) {
  Volume volume;
  const ImageFields fields = IsNrrd(path) ? ParseNrrdFields(ReadHead(path)) : ParseMetaFields(ReadHead(path));
  if (IsNrrd(path)) {
    SetNrrdFrame(fields, path, frame, volume);
  } else if (!frame.empty()) {
    volume.frame = frame;
  }
  const QuietItk quiet;
  const itk::ImageIOBase::Pointer io = IsNrrd(path) ? itk::ImageIOBase::Pointer(itk::NrrdImageIO::New().GetPointer())
                                                    : itk::MetaImageIO::New().GetPointer();
  io->SetFileName(path);
  try {
    io->ReadImageInformation();
  } catch (const itk::ExceptionObject& e) {
    throw Error(fmt::format("{}: the header can't be read ({})", path, OneLine(e)));
  }
  unsigned dimensions = io->GetNumberOfDimensions();
  while (dimensions > 3 && io->GetDimensions(dimensions - 1) == 1) --dimensions;
  if (dimensions != 3)
    throw Error(fmt::format("{}: the image has {} dimensions; kerf needs a volume of 3", path, dimensions));
  CheckOneComponent(io->GetNumberOfComponents(), path);

  // ITK may have read the header otherwise, and what it found is what it asks memory for.
  if (static_cast<std::uint64_t>(io->GetImageSizeInBytes()) > promised) {
    throw Error(fmt::format(
        "{}: the header can be read in two ways, and one of them promises more voxels than the file has", path));
  }
  for (unsigned a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(io->GetDimensions(a));
  if (IsNrrd(path)) {
    PlaceNrrd(fields, path, volume);
  } else {
    PlaceMeta(*io, fields, path, !frame.empty(), volume);
  }
  CheckLattice(volume, path);
  const Overflow overflow = AppendPixels(*io, path, volume.hu);
  if (volume.hu.size() != volume.count()) {
    throw Error(
        fmt::format("{}: {} voxels were read where the header promises {}", path, volume.hu.size(), volume.count()));
  }
  if (overflow.count > 0) volume.warnings.push_back(Describe(overflow, volume.count()));
  return volume;
}

}  // namespace

Volume ReadImageFile(const std::string& path, const std::string& frame) {
  const ImageCheck check = CheckImageHeader(path);
  const auto read = [&](ChildReport&) { return Encode(ReadByItk(path, frame, check.bytes)); };
  Volume volume = HasNiftiExtension(path) ? ReadNifti(path, frame) : DecodeVolume(RunInChild(path, {}, read, {}));
  volume.warnings.insert(volume.warnings.end(), check.warnings.begin(), check.warnings.end());
  return volume;
}

}  // namespace kerf
