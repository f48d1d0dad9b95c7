#include "bone/segmentation/roles.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "base/core/number_text.h"
#include "bone/segmentation/preset_check.h"
#include "bone/segmentation/role_warnings.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr std::pair<const char*, SegmentRole> kRoleNames[] = {
    {"mandible", SegmentRole::kMandible}, {"tooth", SegmentRole::kTooth},   {"canal", SegmentRole::kCanal},
    {"metal", SegmentRole::kMetal},       {"lesion", SegmentRole::kLesion}, {"other", SegmentRole::kOtherBone},
    {"ignored", SegmentRole::kIgnored}};

std::string ListSegments(const Segmentation& segmentation) {
  std::string list;
  for (const Segment& segment : segmentation.segments) list += "\n  " + Describe(segment);
  return list;
}

// Parses the right side of "2=mandible": a role, or a role with a tooth's number, a jaw or a side.
SegmentMeaning ParseMeaning(const std::string& text, const std::string& assignment) {
  for (const auto& [name, role] : kRoleNames) {
    if (text == name) return {.role = role};
  }
  if (text.compare(0, 5, "tooth") == 0) {
    const std::optional<SegmentMeaning> tooth = FindMeaning("tooth " + text.substr(5));
    if (tooth && tooth->fdi != 0) return *tooth;
  }
  if (text == "lower-teeth") return {.role = SegmentRole::kTooth, .fdi = 0, .jaw = JawPart::kLower};
  if (text == "upper-teeth") return {.role = SegmentRole::kTooth, .fdi = 0, .jaw = JawPart::kUpper};
  if (text == "left-canal") return {.role = SegmentRole::kCanal, .fdi = 0, .jaw = {}, .side = JawSide::kLeft};
  if (text == "right-canal") return {.role = SegmentRole::kCanal, .fdi = 0, .jaw = {}, .side = JawSide::kRight};
  throw Error(
      fmt::format("--label {}: '{}' is no role; the roles are mandible, tooth, tooth36 (any number of ISO 3950), "
                  "lower-teeth, upper-teeth, canal, left-canal, right-canal, metal, lesion, other and ignored",
                  assignment, text));
}

// Splits "2=mandible" at its last equals sign, and parses the right side.
std::pair<std::string, SegmentMeaning> ParseAssignment(const std::string& assignment) {
  const std::size_t equals = assignment.rfind('=');
  if (equals == std::string::npos) {
    throw Error(fmt::format("--label {}: should be LABEL=ROLE or NAME=ROLE, such as 2=mandible", assignment));
  }
  return {assignment.substr(0, equals), ParseMeaning(assignment.substr(equals + 1), assignment)};
}

// Returns the segments that the left side of an assignment means: those with this name or, if none has it, this label.
std::vector<std::size_t> FindSegments(const Segmentation& segmentation, const std::string& text,
                                      const std::string& assignment) {
  std::vector<std::size_t> found;
  const auto& all = segmentation.segments;
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (!text.empty() && all[n].name == text) found.push_back(n);
  }
  for (std::size_t n = 0; found.empty() && n < all.size(); ++n) {
    if (fmt::format("{}", all[n].label) == text) found.push_back(n);
  }
  if (found.empty()) {
    throw Error(fmt::format("--label {}: the segmentation has no segment '{}'; it has:{}", assignment, text,
                            ListSegments(segmentation)));
  }
  if (found.size() > 1) {
    throw Error(
        fmt::format("--label {}: {} segments are called '{}'; give their names or labels in the program that "
                    "made the segmentation",
                    assignment, found.size(), text));
  }
  return found;
}

// Returns whether the left side of an assignment is a label that no voxel of a label map without names has.
bool IsAbsentLabel(const Segmentation& segmentation, const std::string& text) {
  if (segmentation.named || text.empty() || text.find_first_not_of("0123456789") != std::string::npos) return false;
  return std::ranges::none_of(segmentation.segments,
                              [&text](const Segment& segment) { return fmt::format("{}", segment.label) == text; });
}

const LabelPreset& FindPreset(const std::string& name) {
  std::string names;
  for (const LabelPreset& preset : ListLabelPresets()) {
    if (preset.name == name) return preset;
    names += (names.empty() ? "" : ", ") + preset.name;
  }
  throw Error(fmt::format("--labels {}: there is no such preset; the presets are {}", name, names));
}

const PresetLabel* FindLabel(const LabelPreset& preset, int label) {
  const auto found = std::find_if(preset.labels.begin(), preset.labels.end(),
                                  [label](const PresetLabel& l) { return l.label == label; });
  return found == preset.labels.end() ? nullptr : &*found;
}

// Throws kerf::Error if the preset does not fit by volume and place, but another one does. If none does, or a label is
// said to be the mandible, it warns.
void CheckPreset(const Segmentation& segmentation, const LabelPreset& preset, bool mandible_assigned,
                 std::vector<std::string>& warnings) {
  constexpr double kWhole_mm3 = 20e3;  // less may be a part of any structure
  const std::vector<PresetFit> fits = FitPresets(segmentation);
  const auto given = std::ranges::find(fits, &preset, &PresetFit::preset);
  // Without a mandible another check refuses it.
  if (given->objection.empty() || given->mandible == nullptr) return;
  const PresetFit& best = fits.front();
  if (best.objection.empty() && best.score >= given->score && best.mandible->volume_mm3 > kWhole_mm3 &&
      !mandible_assigned) {
    throw Error(fmt::format(
        "{}: the labels are not those of --labels {}: {}; --labels {} fits, in which {} is the mandible, or state what "
        "each label is, such as --label {}=mandible",
        segmentation.path, preset.name, given->objection, best.preset->name, Describe(*best.mandible),
        best.mandible->label));
  }
  warnings.push_back(fmt::format("the labels may not be those of --labels {}: {}", preset.name, given->objection));
}

// Warns of canals of the nerve that the preset has, but no voxel.
void AddAbsentCanals(const Segmentation& segmentation, const LabelPreset& preset, std::vector<std::string>& warnings) {
  std::string absent;
  for (const PresetLabel& label : preset.labels) {
    const std::optional<SegmentMeaning> meaning = FindMeaning(label.name);
    const bool is_main =
        label.name.find("incisive") == std::string::npos && label.name.find("lingual") == std::string::npos;
    if (!meaning || meaning->role != SegmentRole::kCanal || !is_main) continue;
    const bool present = std::ranges::any_of(segmentation.segments, [&label](const Segment& segment) {
      return segment.label == label.label && segment.voxels > 0;
    });
    if (!present) absent += fmt::format("{}'{}' (label {})", absent.empty() ? "" : ", ", label.name, label.label);
  }
  if (!absent.empty()) {
    warnings.push_back(fmt::format("the canal of the nerve is absent from the mask: no voxel is {}", absent));
  }
}

// Returns the meaning by the name and the code; they must agree.
std::optional<SegmentMeaning> FindNamedMeaning(const Segment& segment, const std::string& path) {
  const std::optional<SegmentMeaning> named = FindMeaning(segment.name);
  const std::optional<SegmentMeaning> coded = FindCodedMeaning(segment);
  if (!named || !coded) return named ? named : coded;
  if (named->role != coded->role) {
    throw Error(fmt::format("{}: the segment {} is {} by its name, but {} by its code; state which with --label", path,
                            Describe(segment), ToString(named->role), ToString(coded->role)));
  }
  return coded->fdi != 0 ? coded : named;
}

void CheckMandible(const Segmentation& segmentation, const std::vector<bool>& assigned,
                   const std::vector<SegmentMeaning>& meanings) {
  std::vector<std::size_t> mandibles;
  bool all_assigned = true;
  for (std::size_t n = 0; n < meanings.size(); ++n) {
    if (meanings[n].role != SegmentRole::kMandible) continue;
    mandibles.push_back(n);
    all_assigned = all_assigned && assigned[n];
  }
  if (mandibles.empty()) {
    throw Error(
        fmt::format("{}: no segment is the mandible; state which with --label NAME=mandible. The segments are:{}",
                    segmentation.path, ListSegments(segmentation)));
  }
  if (mandibles.size() > 1 && !all_assigned) {
    // The one to ignore is not one that the user has called so.
    const auto last = std::find_if(mandibles.rbegin(), mandibles.rend(), [&](std::size_t n) { return !assigned[n]; });
    const Segment& other = segmentation.segments[*last];
    throw Error(fmt::format(
        "{}: the segments {} and {} both claim to be the mandible; state which with --label, such as "
        "--label '{}=ignored'",
        segmentation.path, Describe(segmentation.segments[mandibles[0]]), Describe(segmentation.segments[mandibles[1]]),
        other.name.empty() ? fmt::format("{}", other.label) : other.name));
  }
  std::size_t voxels = 0;
  for (const std::size_t n : mandibles) voxels += segmentation.segments[n].voxels;
  if (voxels == 0) {
    throw Error(fmt::format("{}: the mandible, {}, has no voxels", segmentation.path,
                            Describe(segmentation.segments[mandibles[0]])));
  }
}

MaskTissue TissueOf(const SegmentMeaning& meaning) {
  switch (meaning.role) {
    case SegmentRole::kMandible:
      return MaskTissue::kBone;
    case SegmentRole::kCanal:
      return MaskTissue::kCanal;
    case SegmentRole::kTooth:
      if (meaning.jaw == JawPart::kUpper) return MaskTissue::kOther;
      return meaning.jaw == JawPart::kLower ? MaskTissue::kTooth : MaskTissue::kUndecidedTooth;
    case SegmentRole::kMetal:
      return MaskTissue::kMetal;
    case SegmentRole::kLesion:
      return MaskTissue::kLesion;
    case SegmentRole::kOtherBone:
      return MaskTissue::kOther;
    case SegmentRole::kIgnored:
      break;
  }
  return MaskTissue::kBackground;
}

// Returns the tissue of a voxel that is in two segments of different layers.
MaskTissue Join(MaskTissue a, MaskTissue b) {
  if (a == b || b == MaskTissue::kBackground) return a;
  if (a == MaskTissue::kBackground) return b;
  if (a == MaskTissue::kOther || b == MaskTissue::kOther) {
    const MaskTissue rest = a == MaskTissue::kOther ? b : a;
    if (IsTooth(rest)) return MaskTissue::kUndecidedTooth;
    return MaskTissue::kUndecided;
  }
  // Finer structures lie in the bone.
  const bool wanted = IsWanted(a) || IsWanted(b);
  if (IsMetal(a) || IsMetal(b)) return wanted ? MaskTissue::kBoneMetal : MaskTissue::kMetal;
  for (const MaskTissue fine : {MaskTissue::kCanal, MaskTissue::kTooth}) {
    if (a == fine || b == fine) return fine;
  }
  if (IsTooth(a) || IsTooth(b)) return wanted ? MaskTissue::kTooth : MaskTissue::kUndecidedTooth;
  if (IsLesion(a) || IsLesion(b)) return wanted ? MaskTissue::kBoneLesion : MaskTissue::kLesion;
  return wanted ? MaskTissue::kBone : MaskTissue::kUndecided;
}

// The same for values of BoneMask::Pack(). A tooth keeps its number.
std::int16_t JoinPacked(std::int16_t a, std::int16_t b) {
  const MaskTissue joined = Join(static_cast<MaskTissue>(a % 16), static_cast<MaskTissue>(b % 16));
  return BoneMask::Pack(joined, !IsTooth(joined) ? 0 : a / 16 != 0 ? a / 16 : b / 16);
}

}  // namespace

void CheckAssignment(const std::string& assignment) {
  ParseAssignment(assignment);
}

const char* ToString(SegmentRole role) {
  for (const auto& [name, named] : kRoleNames) {
    if (named == role) return name;
  }
  return "ignored";
}

SegmentationRoles FindRoles(const Segmentation& segmentation, const LabelOptions& options) {
  const std::vector<Segment>& segments = segmentation.segments;
  SegmentationRoles roles;
  roles.meanings.assign(segments.size(), {});
  std::vector<bool> assigned(segments.size(), false), known(segments.size(), false);
  bool mandible_assigned = false;
  for (const std::string& assignment : options.assignments) {
    const auto [which, meaning] = ParseAssignment(assignment);
    if (meaning.role == SegmentRole::kCanal && IsAbsentLabel(segmentation, which)) {
      roles.warnings.push_back(fmt::format(
          "the canal of the nerve is absent from the mask: no voxel has the label of --label {}", assignment));
      continue;
    }
    mandible_assigned |= meaning.role == SegmentRole::kMandible;
    for (const std::size_t n : FindSegments(segmentation, which, assignment)) {
      if (assigned[n] && roles.meanings[n] != meaning) {
        throw Error(fmt::format("--label {}: contradicts another --label for the same segment, {}", assignment,
                                Describe(segments[n])));
      }
      roles.meanings[n] = meaning;
      assigned[n] = known[n] = true;
    }
  }
  const LabelPreset* preset = options.preset.empty() ? nullptr : &FindPreset(options.preset);
  if (preset == nullptr && !segmentation.named && options.assignments.empty()) {
    throw Error(
        fmt::format("{}: the file does not say what its labels are. They are:{}\n{} Otherwise state what each "
                    "label is, such as --label 2=mandible",
                    segmentation.path, ListSegments(segmentation), ProposePreset(segmentation)));
  }
  std::string unknown;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    if (assigned[n]) continue;
    std::optional<SegmentMeaning> meaning;
    if (preset != nullptr) {
      if (const PresetLabel* label = FindLabel(*preset, segments[n].label)) meaning = FindMeaning(label->name);
    } else if (segmentation.named) {
      meaning = FindNamedMeaning(segments[n], segmentation.path);
    }
    if (meaning) {
      roles.meanings[n] = *meaning;
    } else {
      unknown += (unknown.empty() ? "" : ", ") + Describe(segments[n]);
    }
  }
  if (preset != nullptr) CheckPreset(segmentation, *preset, mandible_assigned, roles.warnings);
  CheckMandible(segmentation, assigned, roles.meanings);
  if (preset != nullptr) AddAbsentCanals(segmentation, *preset, roles.warnings);
  if (!unknown.empty()) roles.warnings.push_back(fmt::format("segments of unknown meaning were ignored: {}", unknown));
  AddRoleWarnings(segmentation, roles, preset == nullptr ? std::vector<bool>(segments.size(), true) : assigned);
  return roles;
}

BoneMask MakeBoneMask(const Segmentation& segmentation, const SegmentationRoles& roles) {
  BoneMask mask;
  mask.tissue = segmentation.lattice;
  mask.tissue.warnings = segmentation.warnings;
  mask.tissue.hu.assign(mask.tissue.count(), 0);
  for (std::size_t layer = 0; layer < segmentation.layers.size(); ++layer) {
    std::vector<std::int16_t> tissues(32768, BoneMask::Pack(MaskTissue::kBackground, 0));
    for (std::size_t n = 0; n < segmentation.segments.size(); ++n) {
      const Segment& segment = segmentation.segments[n];
      if (segment.layer != static_cast<int>(layer)) continue;
      const MaskTissue tissue = TissueOf(roles.meanings[n]);
      tissues[static_cast<std::size_t>(segment.label)] =
          BoneMask::Pack(tissue, IsTooth(tissue) ? roles.meanings[n].fdi : 0);
    }
    const std::vector<std::int16_t>& labels = segmentation.layers[layer];
    for (std::size_t v = 0; v < labels.size(); ++v) {
      const std::int16_t tissue = tissues[static_cast<std::size_t>(labels[v])];
      if (tissue != 0) mask.tissue.hu[v] = mask.tissue.hu[v] == 0 ? tissue : JoinPacked(mask.tissue.hu[v], tissue);
    }
  }
  std::string names;
  for (std::size_t n = 0; n < segmentation.segments.size(); ++n) {
    if (!IsWanted(TissueOf(roles.meanings[n]))) continue;
    const Segment& segment = segmentation.segments[n];
    names += (names.empty() ? "" : ", ") +
             (segment.name.empty() ? fmt::format("label {}", segment.label) : fmt::format("'{}'", segment.name));
  }
  mask.how = fmt::format("mask: {}", names);
  mask.series_uid = segmentation.series_uid;
  mask.frame_uid = segmentation.frame_uid;
  mask.cropped = segmentation.cropped;
  return mask;
}

}  // namespace kerf
