// Replaces the drawing benchmark in builds without the window.
#include "experiment/draw_bench/view_bench.h"

#include "base/core/not_built.h"

namespace kerf {

ViewReport RunViewBench(const ViewBenchOptions&) {
  FailNotBuilt("the window", "KERF_WITH_WINDOW");
}

}  // namespace kerf
