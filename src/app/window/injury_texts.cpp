#include "app/window/injury_texts.h"

#include <fmt/format.h>

#include <cmath>

#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxLines = 4;
constexpr double kLeastShown_mm3 = 0.1;

bool IsTooth(const StructureResult& s) {
  return s.kind == MarkKind::kTooth || s.kind == MarkKind::kRoot;
}
bool IsNerve(const StructureResult& s) {
  return s.kind == MarkKind::kNerve || s.kind == MarkKind::kCanal;
}

std::string ShowStructureName(const StructureResult& s) {
  if (s.is_mark) return ShowName(s.name);
  if (!IsTooth(s)) {
    return s.side == BodySide::kLeft    ? Tr("Nerve, patient's left")
           : s.side == BodySide::kRight ? Tr("Nerve, patient's right")
                                        : Tr("Nerve, on both sides");
  }
  if (s.side == BodySide::kBoth) return Tr("A tooth in the row of touching teeth");
  return fmt::format(fmt::runtime(s.side == BodySide::kLeft ? Tr("Tooth {} from the middle, patient's left")
                                                            : Tr("Tooth {} from the middle, patient's right")),
                     s.number);
}

std::string ShowPlace(const Vec3& p_W) {
  const auto along = [](double mm, const char* positive, const char* negative) {
    return fmt::format(fmt::runtime(Tr(mm < 0 ? negative : positive)), ShowNumber(std::abs(mm), 1));
  };
  return fmt::format("{}, {}, {}", along(p_W.x, Msg("{} mm left"), Msg("{} mm right")),
                     along(p_W.y, Msg("{} mm back"), Msg("{} mm front")),
                     along(p_W.z, Msg("{} mm up"), Msg("{} mm down")));
}

}  // namespace

std::string DescribeInjury(const StructureResult& injury) {
  const char* text = IsTooth(injury)     ? injury.is_severed ? Msg("{}: cut through. {} removed at {}.")
                                                             : Msg("{}: cut. {} removed at {}.")
                         : injury.is_severed ? Msg("{}: severed. {} removed at {}.")
                                         : Msg("{}: injured. {} removed at {}.");
  const std::string volume = injury.removed_mm3 < kLeastShown_mm3
                                 ? fmt::format(fmt::runtime(Tr("Less than {}")), ShowVolume(kLeastShown_mm3))
                                 : ShowVolume(injury.removed_mm3);
  return fmt::format(fmt::runtime(Tr(text)), ShowStructureName(injury), volume, ShowPlace(injury.p_W));
}

void ShowInjuries(const std::vector<StructureResult>& injuries, HudState& hud) {
  bool nerve_is_severed = false;
  for (const StructureResult& injury : injuries) {
    if (hud.injuries.size() < kMaxLines) hud.injuries.push_back(DescribeInjury(injury));
    if (IsTooth(injury)) hud.values.teeth_injury = Tr("cut");
    if (!IsNerve(injury)) continue;
    nerve_is_severed |= injury.is_severed;
    hud.values.nerve_injury = nerve_is_severed ? Tr("severed") : Tr("injured");
  }
  if (injuries.size() > kMaxLines) {
    hud.injuries.back() =
        fmt::format(fmt::runtime(Tr("{} more structures are injured.")), injuries.size() - kMaxLines + 1);
  }
}

}  // namespace kerf
