#include "bone/segmentation/preset_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vector_relational.hpp>
#include <initializer_list>
#include <limits>
#include <utility>

#include "base/core/number_text.h"
#include "bone/import/image_fields.h"

namespace kerf {
namespace {

/// Where a segment lies in the patient, LPS, mm.
struct Place {
  Vec3 centre_W{0};
  Box3 box_W;
};

/// A structure as a preset names it.
struct NamedStructure {
  const Segment* segment;
  const Place* place;
  std::string name;
  SegmentMeaning meaning;
};

struct VolumeRange {
  double lower_cm3;
  double upper_cm3;
};

constexpr VolumeRange kMandible_cm3{8, 120};  // without teeth and worn, up to large with its marrow
constexpr double kNear_mm = 5;                // beyond the box of the mandible, for what lies in it

bool NamesOneOf(const std::string& name, std::initializer_list<const char*> words) {
  const std::string lower = Lower(name);
  return std::ranges::any_of(words, [&lower](const char* word) { return lower.find(word) != std::string::npos; });
}

/// Returns the volumes that a structure can have in the image of a head or of a jaw alone.
VolumeRange FindVolumes(const NamedStructure& s) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  switch (s.meaning.role) {
    case SegmentRole::kMandible:
      return kMandible_cm3;
    case SegmentRole::kTooth:
      if (NamesOneOf(s.name, {"pulp", "root"})) return {0, 5};
      return {0, s.meaning.fdi != 0 ? 5.0 : 35.0};
    case SegmentRole::kCanal:
      return {0, 12};
    case SegmentRole::kMetal:
      return {0, 60};
    case SegmentRole::kOtherBone:
      return {2, kAny};
    case SegmentRole::kIgnored:
      if (NamesOneOf(s.name, {"sinus"})) return {0, 90};
      if (NamesOneOf(s.name, {"airway", "pharynx"})) return {2, 150};
      return NamesOneOf(s.name, {"head", "skin"}) ? VolumeRange{50, kAny} : VolumeRange{0, kAny};
    default:
      return {0, kAny};
  }
}

/// Returns where a structure has to lie and does not; empty if it can lie where it does.
std::string FindPlaceObjection(const NamedStructure& s, const NamedStructure& mandible) {
  const Vec3 off = s.place->centre_W - mandible.place->centre_W;
  const Box3& box = mandible.place->box_W;
  const Vec3& c = s.place->centre_W;
  const bool inside =
      glm::all(glm::greaterThan(c, box.lower - kNear_mm)) && glm::all(glm::lessThan(c, box.upper + kNear_mm));
  switch (s.meaning.role) {
    case SegmentRole::kTooth:
      if (s.meaning.jaw == JawPart::kUpper) return off.z > 0 ? "" : "above the mandible";
      return inside ? "" : "at the mandible";
    case SegmentRole::kCanal:
      return inside ? "" : "in the mandible";
    case SegmentRole::kOtherBone:
      if (NamesOneOf(s.name, {"vertebra"})) return off.y > 0 ? "" : "behind the mandible";
      return off.z > 0 ? "" : "above the mandible";
    case SegmentRole::kIgnored:
      return NamesOneOf(s.name, {"sinus"}) && !(off.z > 0) ? "above the mandible" : "";
    default:
      return "";
  }
}

std::string FindObjection(const std::vector<NamedStructure>& structures, const NamedStructure& mandible) {
  for (const NamedStructure& s : structures) {
    const VolumeRange volumes = FindVolumes(s);
    const double cm3 = s.segment->volume_mm3 / 1000;
    if (cm3 >= volumes.lower_cm3 && cm3 <= volumes.upper_cm3) continue;
    const std::string allowed = std::isinf(volumes.upper_cm3)
                                    ? fmt::format("at least {:g} cm3", volumes.lower_cm3)
                                    : fmt::format("{:g} to {:g} cm3", volumes.lower_cm3, volumes.upper_cm3);
    return fmt::format("{} would be '{}', which has {}", Describe(*s.segment), s.name, allowed);
  }
  for (const NamedStructure& s : structures) {
    if (s.segment == mandible.segment) continue;
    if (const std::string where = FindPlaceObjection(s, mandible); !where.empty()) {
      return fmt::format("{} would be '{}', but does not lie {}, which would be {}", Describe(*s.segment), s.name,
                         where, Describe(*mandible.segment));
    }
  }
  const auto find = [&structures](JawSide side) {
    return std::ranges::find_if(structures, [side](const NamedStructure& s) {
      return s.meaning.role == SegmentRole::kCanal && s.meaning.side == side && !NamesOneOf(s.name, {"incisive"});
    });
  };
  const auto left = find(JawSide::kLeft), right = find(JawSide::kRight);
  if (left == structures.end() || right == structures.end()) return "";
  if (left->place->centre_W.x > right->place->centre_W.x) return "";
  return fmt::format("{} would be '{}', but lies on the patient's right of '{}'", Describe(*left->segment), left->name,
                     right->name);
}

/// Returns the place of each segment; those of segments without voxels mean nothing.
std::vector<Place> FindPlaces(const Segmentation& segmentation) {
  struct Sum {
    std::array<double, 3> total{};
    std::array<int, 3> lower{std::numeric_limits<int>::max(), std::numeric_limits<int>::max(),
                             std::numeric_limits<int>::max()};
    std::array<int, 3> upper{-1, -1, -1};
    double count = 0;
  };
  const Volume& lattice = segmentation.lattice;
  std::vector<Sum> sums(segmentation.segments.size());
  for (std::size_t layer = 0; layer < segmentation.layers.size(); ++layer) {
    std::vector<Sum*> sum_of(32768, nullptr);
    for (std::size_t n = 0; n < sums.size(); ++n) {
      const Segment& segment = segmentation.segments[n];
      if (segment.layer == static_cast<int>(layer)) sum_of[static_cast<std::size_t>(segment.label)] = &sums[n];
    }
    const std::vector<std::int16_t>& labels = segmentation.layers[layer];
    std::size_t v = 0;
    for (int k = 0; k < lattice.size[2]; ++k) {
      for (int j = 0; j < lattice.size[1]; ++j) {
        for (int i = 0; i < lattice.size[0] && v < labels.size(); ++i, ++v) {
          Sum* const sum = labels[v] == 0 ? nullptr : sum_of[static_cast<std::size_t>(labels[v])];
          if (sum == nullptr) continue;
          const std::array<int, 3> at{i, j, k};
          for (std::size_t a = 0; a < 3; ++a) {
            sum->total[a] += at[a];
            sum->lower[a] = std::min(sum->lower[a], at[a]);
            sum->upper[a] = std::max(sum->upper[a], at[a]);
          }
          sum->count += 1;
        }
      }
    }
  }
  std::vector<Place> places(sums.size());
  for (std::size_t n = 0; n < sums.size(); ++n) {
    const Sum& sum = sums[n];
    if (sum.count == 0) continue;
    places[n].centre_W = lattice.WorldFromVoxel(Vec3(sum.total[0], sum.total[1], sum.total[2]) / sum.count);
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 p_V;
      for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        p_V[a] = (corner >> a & 1) != 0 ? sum.upper[i] + 0.5 : sum.lower[i] - 0.5;
      }
      places[n].box_W.Include(lattice.WorldFromVoxel(p_V));
    }
  }
  return places;
}

PresetFit FitPreset(const Segmentation& segmentation, const std::vector<Place>& places, const LabelPreset& preset) {
  PresetFit fit;
  fit.preset = &preset;
  std::vector<NamedStructure> structures;
  std::size_t in_file = 0, mandible = 0;
  for (std::size_t n = 0; n < places.size(); ++n) {
    const Segment& segment = segmentation.segments[n];
    if (segment.voxels == 0) continue;
    ++in_file;
    const auto label = std::ranges::find(preset.labels, segment.label, &PresetLabel::label);
    const std::optional<SegmentMeaning> meaning =
        label == preset.labels.end() ? std::nullopt : FindMeaning(label->name);
    if (!meaning) continue;
    if (meaning->role == SegmentRole::kMandible) {
      mandible = structures.size();
      fit.mandible = &segment;
    }
    structures.push_back({&segment, &places[n], label->name, *meaning});
  }
  fit.shared = structures.size();
  const auto shared = static_cast<double>(fit.shared);
  const auto in_either = static_cast<double>(preset.labels.size() + in_file - fit.shared);
  fit.score = in_file == 0 ? 0 : shared / static_cast<double>(in_file) + shared / in_either;
  fit.objection =
      fit.mandible == nullptr ? "no voxel would be the mandible" : FindObjection(structures, structures[mandible]);
  return fit;
}

}  // namespace

std::vector<PresetFit> FitPresets(const Segmentation& segmentation) {
  const std::vector<Place> places = FindPlaces(segmentation);
  std::vector<PresetFit> fits;
  for (const LabelPreset& preset : ListLabelPresets()) fits.push_back(FitPreset(segmentation, places, preset));
  std::ranges::stable_sort(fits, [](const PresetFit& a, const PresetFit& b) {
    if (a.objection.empty() != b.objection.empty()) return a.objection.empty();
    return a.score > b.score;
  });
  return fits;
}

std::string ProposePreset(const Segmentation& segmentation) {
  constexpr std::size_t kMaxProposed = 3;
  const std::vector<PresetFit> fits = FitPresets(segmentation);
  const PresetFit& best = fits.front();
  if (!best.objection.empty()) {
    const auto nearest =
        std::ranges::find_if(fits, [](const PresetFit& fit) { return fit.mandible != nullptr && fit.shared > 0; });
    if (nearest == fits.end()) return "No preset of --labels fits.";
    return fmt::format("No preset of --labels fits; of the nearest, {}, {}.", nearest->preset->name,
                       nearest->objection);
  }
  std::string others;
  for (std::size_t n = 1; n < std::min(fits.size(), kMaxProposed) && fits[n].objection.empty(); ++n) {
    others += fmt::format("{}{} ({})", others.empty() ? "" : ", ", fits[n].preset->name, Describe(*fits[n].mandible));
  }
  return fmt::format(
      "By volume and place, --labels {} fits best, in which {} is the mandible; use it only if the file is from {}.{}",
      best.preset->name, Describe(*best.mandible), best.preset->source,
      others.empty() ? "" : fmt::format(" Presets that fit too, with their mandibles: {}.", others));
}

}  // namespace kerf
