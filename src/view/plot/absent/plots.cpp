// Replacement for the plots in a build without VTK.
#include "base/core/not_built.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

[[noreturn]] void Fail() {
  FailNotBuilt("pictures", "KERF_WITH_PICTURES");
}

}  // namespace

Image RenderPlot(const PlotSpec&, PlotFrame*) {
  Fail();
}
void WritePlot(const PlotSpec&, const std::string&) {
  Fail();
}
std::string FormatPlotSvg(const PlotSpec&, PlotFrame*) {
  Fail();
}

}  // namespace kerf
