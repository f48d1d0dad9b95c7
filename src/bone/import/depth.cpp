#include "bone/import/depth.h"

#include <itkMultiThreaderBase.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

#include <new>
#include <string_view>

#include "bone/import/itk_read.h"
#include "bone/import/itk_view.h"
#include "kerf/error.h"

namespace kerf {

namespace {

/// Selects an ITK threader that reports exceptions. The default, a thread pool, drops the exceptions of all threads
/// except the first: after a failed allocation the distances would be wrong without any notice. This threader passes
/// them on as text.
void UseExceptionForwardingThreader() {
  itk::MultiThreaderBase::SetGlobalDefaultThreader(itk::MultiThreaderBase::ThreaderEnum::Platform);
}

bool IsLackOfMemory(const itk::ExceptionObject& e) {
  return dynamic_cast<const itk::MemoryAllocationError*>(&e) != nullptr ||
         std::string_view(e.GetDescription()).find("bad_alloc") != std::string_view::npos;
}

}  // namespace

std::vector<float> CalcDepth(const Volume& lattice, const std::vector<std::uint8_t>& inside) {
  const QuietItk quiet;
  UseExceptionForwardingThreader();
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
    // ITK measures to the centres of the outermost voxels.
    const auto half = static_cast<float>((lattice.spacing_mm.x + lattice.spacing_mm.y + lattice.spacing_mm.z) / 6);
    for (float& d : depth_mm) d += half;
    return depth_mm;
  } catch (const itk::ExceptionObject& e) {
    if (IsLackOfMemory(e)) throw std::bad_alloc();
    throw Error("the distance map failed: " + OneLine(e));
  }
}

}  // namespace kerf
