// Texts that name injured structures to the user.
#pragma once

#include <string>
#include <vector>

#include "session/marks/structures.h"
#include "view/ui/hud.h"

namespace kerf {

/// Returns one or two sentences, such as "Canal of the nerve, patient's left: severed. 4.2 mm³ removed at 25.1 mm left,
/// 3.2 mm back, 8.9 mm up."
std::string DescribeInjury(const StructureResult& injury);
/// Adds the injuries to what stays shown.
void ShowInjuries(const std::vector<StructureResult>& injuries, HudState& hud);

}  // namespace kerf
