// Formats a curve as SVG for embedding in a page.
#pragma once

#include <string>

#include "session/export/write_export.h"

namespace kerf::export_detail {

/// The curve has axes, round tick values, labels and a title for screen readers. Peaks are preserved however many
/// points there are.
std::string FormatCurveSvg(const ExportCurve& curve, const ReportLanguage& t = {});

}  // namespace kerf::export_detail
