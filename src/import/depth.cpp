#include "import/depth.h"

#include <itkSignedMaurerDistanceMapImageFilter.h>

#include "import/itk_read.h"
#include "import/itk_view.h"
#include "kerf/error.h"

namespace kerf {

std::vector<float> CalcDepth(const Volume& lattice, const std::vector<std::uint8_t>& inside) {
  const QuietItk quiet;
  try {
    std::vector<std::uint8_t> mask = inside;
    using Filter = itk::SignedMaurerDistanceMapImageFilter<itk::Image<std::uint8_t, 3>, itk::Image<float, 3>>;
    const auto filter = Filter::New();
    filter->SetInput(MakeView(lattice, mask.data()));
    filter->InsideIsPositiveOn();
    filter->SquaredDistanceOff();
    filter->UseImageSpacingOn();
    filter->Update();
    const float* result = filter->GetOutput()->GetBufferPointer();
    std::vector<float> depth_mm(result, result + lattice.count());
    // ITK measures to the outermost voxels' centres.
    const auto half = static_cast<float>((lattice.spacing_mm.x + lattice.spacing_mm.y + lattice.spacing_mm.z) / 6);
    for (float& d : depth_mm) d += half;
    return depth_mm;
  } catch (const itk::ExceptionObject& e) {
    throw Error("the distance map failed: " + OneLine(e));
  }
}

}  // namespace kerf
