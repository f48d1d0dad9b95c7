// Formats a curve as SVG for embedding in a page.
#pragma once

#include <string>

#include "session/export/write_export.h"

namespace kerf::takeaway {

/// The curve has axes, round tick values, labels and a title for screen readers. Peaks are preserved however many
/// points there are.
std::string FormatCurveSvg(const TakenCurve& curve);

}  // namespace kerf::takeaway
