// A curve as SVG that stands in a page.
#pragma once

#include <string>

#include "session/export/take_away.h"

namespace kerf::takeaway {

/// With axes, round ticks, labels and a title for those who don't see it. However many points: no peak is lost.
std::string FormatCurveSvg(const TakenCurve& curve);

}  // namespace kerf::takeaway
