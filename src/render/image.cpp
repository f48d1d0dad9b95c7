#include "render/image.h"

#include <fmt/format.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>

#include <cstring>
#include <filesystem>

#include "files/files.h"
#include "kerf/error.h"
#include "mesh/vtk_mesh.h"

namespace kerf {

void WritePng(const Image& image, const std::string& path) {
  if (std::filesystem::path(path).extension() != ".png")
    throw Error(fmt::format("{}: a picture's name must end in .png", path));
  QuietVtk();
  const vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const auto row_size = static_cast<std::size_t>(image.width);
  for (int row = 0; row < image.height; ++row) {
    // VTK's rows begin at the bottom.
    std::memcpy(data->GetScalarPointer(0, image.height - 1 - row, 0),
                image.pixels.data() + static_cast<std::size_t>(row) * row_size, 3 * row_size);
  }
  WriteAtomically(path, [&](const std::string& temporary) {
    const vtkNew<vtkPNGWriter> writer;
    writer->SetInputData(data);
    writer->SetFileName(temporary.c_str());
    writer->Write();
    if (writer->GetErrorCode() != 0)
      throw Error(fmt::format("{}: the picture can't be written; is the disk full?", path));
  });
}

}  // namespace kerf
