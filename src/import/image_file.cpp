#include "import/image_file.h"

#include <fmt/format.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cctype>

#include "import/image_header.h"
#include "import/itk_read.h"
#include "kerf/error.h"

namespace kerf {

namespace {

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

itk::ImageIOBase::Pointer MakeImageIo(const std::string& path) {
  std::string lower = path;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  if (EndsWith(lower, ".nrrd") || EndsWith(lower, ".nhdr")) return itk::NrrdImageIO::New().GetPointer();
  if (EndsWith(lower, ".nii") || EndsWith(lower, ".nii.gz")) return itk::NiftiImageIO::New().GetPointer();
  return itk::MetaImageIO::New().GetPointer();
}

}  // namespace

Volume ReadImageFile(const std::string& path) {
  const std::uint64_t promised = CheckImageHeader(path);
  const QuietItk quiet;
  const itk::ImageIOBase::Pointer io = MakeImageIo(path);
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

  // ITK may have read the header otherwise, and what it found is what it asks memory for.
  if (static_cast<std::uint64_t>(io->GetImageSizeInBytes()) > promised) {
    throw Error(fmt::format(
        "{}: the header can be read in two ways, and one of them promises more voxels than the file has", path));
  }
  Volume volume;
  for (unsigned a = 0; a < 3; ++a) {
    volume.size[a] = static_cast<int>(io->GetDimensions(a));
    volume.spacing_mm[a] = io->GetSpacing(a);
    volume.origin_W[a] = io->GetOrigin(a);
    const std::vector<double> axis = io->GetDirection(a);
    for (unsigned c = 0; c < 3; ++c) volume.axes_W[a][c] = axis[c];
  }
  CheckLattice(volume, path);
  AppendPixels(*io, path, volume.hu);
  if (volume.hu.size() != volume.count()) {
    throw Error(
        fmt::format("{}: {} voxels were read where the header promises {}", path, volume.hu.size(), volume.count()));
  }
  return volume;
}

}  // namespace kerf
