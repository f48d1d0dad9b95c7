// Pictures in the report of `kerf assess`.
#pragma once

#include <string>
#include <vector>

#include "session/export/write_export.h"
#include "session/plan/assess.h"

namespace kerf::cli {

/// Draws the pieces in their positions with the planned and the achieved planes: an overview in three-quarter view, and
/// a view into the first cut, along its planned plane. Returns an empty vector if there is nothing to show.
/// `of_patient`: true if the bone is in patient coordinates. Throws Error if this machine cannot draw.
std::vector<ExportPicture> DrawAssessment(const std::string& title, const Assessment& assessment,
                                          const PieceSet& pieces, bool of_patient);

}  // namespace kerf::cli
