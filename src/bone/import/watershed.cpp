#include "bone/import/watershed.h"

#include <itkMorphologicalWatershedFromMarkersImageFilter.h>

#include <algorithm>
#include <cmath>

#include "bone/import/depth.h"
#include "bone/import/itk_read.h"
#include "bone/import/itk_view.h"
#include "kerf/error.h"

namespace kerf {

namespace {

// HU are clamped to this, so that a bright enamel contact does not join two jaws more strongly than their own bone.
constexpr double kHuCeiling = 1200;
// HU equivalent of a millimetre of depth: where teeth or joint surfaces touch, the bridge is a millimetre or two thick
// and the bone on either side several.
constexpr double kHuPerMm = 100;
constexpr double kLevelHu = 16;  // quantisation of the relief; removes smaller noise, so that borders are straight

}  // namespace

std::vector<std::uint8_t> GrowMarkers(const Volume& ct, double iso_hu, const std::vector<std::uint8_t>& markers,
                                      const std::function<void(double)>& progress) {
  const QuietItk quiet;
  try {
    std::vector<std::uint8_t> bone(ct.count());
    for (std::size_t v = 0; v < bone.size(); ++v) bone[v] = ct.hu[v] >= iso_hu ? 1 : 0;
    const std::vector<float> depth_mm = CalcDepth(ct, bone);
    std::vector<std::int16_t> relief(ct.count());
    for (std::size_t v = 0; v < relief.size(); ++v) {
      const double height = std::min<double>(ct.hu[v], kHuCeiling) + kHuPerMm * std::clamp<double>(depth_mm[v], 0, 20);
      relief[v] = static_cast<std::int16_t>(-std::lround(height / kLevelHu));
    }
    using Mask = itk::Image<std::uint8_t, 3>;
    using Relief = itk::Image<std::int16_t, 3>;
    using Watershed = itk::MorphologicalWatershedFromMarkersImageFilter<Relief, Mask>;
    std::vector<std::uint8_t> seeds = markers;
    const auto watershed = Watershed::New();
    watershed->SetInput1(MakeView(ct, relief.data()));
    watershed->SetInput2(MakeView(ct, seeds.data()));
    watershed->SetMarkWatershedLine(false);
    watershed->SetFullyConnected(false);
    ReportProgress(*watershed, progress);
    watershed->Update();
    const std::uint8_t* labels = watershed->GetOutput()->GetBufferPointer();
    return {labels, labels + ct.count()};
  } catch (const itk::ExceptionObject& e) {
    throw Error("the watershed failed: " + OneLine(e));
  }
}

}  // namespace kerf
