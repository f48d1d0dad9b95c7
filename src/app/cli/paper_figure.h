// The figure of kerf paper: force against depth, as the paper computed it and corrected.
#pragma once

#include <string>

#include "cut/paper/paper_tables.h"

namespace kerf::cli {

/// Writes a PNG of 1920 x 1080 pixels. Throws Error when it can't be written or this machine can't draw.
void WritePaperFigure(const PaperTables& tables, const std::string& path);

}  // namespace kerf::cli
