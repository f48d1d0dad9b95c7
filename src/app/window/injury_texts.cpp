#include "app/window/injury_texts.h"

#include <fmt/format.h>

#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxLines = 4;
constexpr double kLeastShown_mm3 = 0.1;

/// Returns the text as the beginning of a sentence.
std::string Capitalise(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

}  // namespace

std::string DescribeInjury(const StructureResult& injury) {
  const bool is_cut = IsTooth(injury.kind) || injury.kind == MarkKind::kLesion;
  const char* text =
      is_cut ? injury.is_severed ? Msg("{}: cut through. {} removed at {}.") : Msg("{}: cut. {} removed at {}.")
      : injury.is_severed ? Msg("{}: severed. {} removed at {}.")
                          : Msg("{}: injured. {} removed at {}.");
  const std::string volume = injury.removed_mm3 < kLeastShown_mm3
                                 ? fmt::format(fmt::runtime(Tr("Less than {}")), ShowVolume(kLeastShown_mm3))
                                 : ShowVolume(injury.removed_mm3);
  const std::string name = Translate(NameStructure(injury));
  return fmt::format(fmt::runtime(Tr(text)), injury.is_mark ? name : Capitalise(name), volume,
                     Translate(DescribePlace(injury.p_W)));
}

void ShowInjuries(const std::vector<StructureResult>& injuries, HudState& hud) {
  bool nerve_is_severed = false;
  for (const StructureResult& injury : injuries) {
    if (hud.injuries.size() < kMaxLines) hud.injuries.push_back(DescribeInjury(injury));
    if (IsTooth(injury.kind)) hud.values.teeth_injury = Tr("cut");
    if (!IsNerve(injury.kind)) continue;
    nerve_is_severed |= injury.is_severed;
    hud.values.nerve_injury = nerve_is_severed ? Tr("severed") : Tr("injured");
  }
  if (injuries.size() > kMaxLines) {
    hud.injuries.back() =
        fmt::format(fmt::runtime(Tr("{} more structures are injured.")), injuries.size() - kMaxLines + 1);
  }
}

}  // namespace kerf
