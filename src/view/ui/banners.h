// Texts over the scene: banners and injuries at its top, messages at its bottom.
#pragma once

#include <string>
#include <vector>

#include "view/ui/hud.h"
#include "view/ui/ui.h"

namespace kerf {

/// What was injured, at the top of the area.
void DrawInjuries(Ui& ui, const std::vector<std::string>& injuries, const UiBox& scene);

/// Banner at the top of the scene: a notice, a warning, or what the user is asked to do.
void DrawBanner(Ui& ui, const HudBanner& banner, const UiBox& scene);
/// Returns its lower edge.
double CalcBannerBottom(const Ui& ui, const HudBanner& banner, const UiBox& scene);
/// Messages at the bottom of the scene, above the scale bar; those that are not empty are shown.
struct HudMessages {
  std::string message;
  std::string warning;  // with a mark
  std::string staying;  // the same, while its cause lasts
};
/// `below`: a box that they are drawn above; empty: none. The staying message is drawn below `top` instead of over
/// `tool`.
void DrawMessages(Ui& ui, const HudMessages& messages, const UiBox& scene, const UiBox& below, const UiBox& tool = {},
                  double top = 0);

}  // namespace kerf
