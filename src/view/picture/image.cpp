#include "view/picture/image.h"

#include <fmt/format.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <cstring>
#include <filesystem>

#include "base/files/files.h"
#include "base/files/memory.h"
#include "kerf/error.h"
#include "view/picture/vtk_mesh.h"

namespace kerf {

void WritePng(const Image& image, const std::string& path) {
  if (std::filesystem::path(path).extension() != ".png")
    throw Error(fmt::format("{}: the name of a picture must end in .png", path));
  QuietVtk();
  const ExitOnBadAlloc ends;
  const vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const auto row_size = static_cast<std::size_t>(image.width);
  for (int row = 0; row < image.height; ++row) {
    // VTK's rows begin at the bottom.
    std::memcpy(data->GetScalarPointer(0, image.height - 1 - row, 0),
                image.pixels.data() + static_cast<std::size_t>(row) * row_size, 3 * row_size);
  }
  // The picture is encoded in memory, because libpng would print messages if the disk were full.
  const vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(data);
  writer->SetWriteToMemory(1);
  writer->Write();
  vtkUnsignedCharArray* png = writer->GetResult();
  if (writer->GetErrorCode() != 0 || png == nullptr) throw Error(fmt::format("{}: the picture can't be created", path));
  const auto size = static_cast<std::size_t>(png->GetNumberOfValues());
  WriteTextFile(path, std::string(reinterpret_cast<const char*>(png->GetPointer(0)), size));
}

}  // namespace kerf
