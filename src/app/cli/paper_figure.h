// Figure of kerf paper: force against depth, as computed in the paper and corrected.
#pragma once

#include <string>

#include "cut/paper/paper_tables.h"

namespace kerf::cli {

/// Writes a PNG of 1920 x 1080 pixels. Throws Error if it cannot be written or this machine cannot draw.
void WritePaperFigure(const PaperTables& tables, const std::string& path);

}  // namespace kerf::cli
