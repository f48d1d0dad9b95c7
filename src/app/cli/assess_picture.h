// The picture in the report of `kerf assess`.
#pragma once

#include <string>
#include <vector>

#include "session/export/take_away.h"
#include "session/plan/assess.h"

namespace kerf::cli {

/// The pieces where they are with the planned and the achieved planes, in three quarters and along the first plane.
/// Empty where there is nothing to see. `of_patient`: the bone lies as in a patient. Throws Error when this machine
/// can't draw.
std::vector<TakenPicture> DrawAssessment(const std::string& title, const Assessment& assessment, const PieceSet& pieces,
                                         bool of_patient);

}  // namespace kerf::cli
