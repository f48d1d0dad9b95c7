// View of a lattice's values as an ITK image, without a copy. Only files of this folder that include ITK use it.
#pragma once

#include <itkImportImageFilter.h>

#include "bone/import/volume.h"

namespace kerf {

/// Makes an image that refers to `data`. It has the lattice's spacing, but is placed at the origin and along the axes.
/// This is sufficient for filters that work within the lattice.
template <typename T>
typename itk::Image<T, 3>::Pointer MakeView(const Volume& lattice, T* data) {
  using Import = itk::ImportImageFilter<T, 3>;
  const auto import = Import::New();
  typename Import::RegionType region;
  for (unsigned a = 0; a < 3; ++a) region.SetSize(a, static_cast<itk::SizeValueType>(lattice.size[a]));
  import->SetRegion(region);
  const double spacing[3] = {lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z};
  import->SetSpacing(spacing);
  import->SetImportPointer(data, lattice.count(), false);
  import->Update();
  typename itk::Image<T, 3>::Pointer image = import->GetOutput();
  image->DisconnectPipeline();
  return image;
}

}  // namespace kerf
