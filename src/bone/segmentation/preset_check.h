// Whether the labels of a program fit a segmentation, by the volume and the place of each.
#pragma once

#include <string>
#include <vector>

#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"

namespace kerf {

/// A preset and how well it fits a segmentation.
struct PresetFit {
  const LabelPreset* preset = nullptr;
  std::size_t shared = 0;  // labels of the segmentation that the preset has
  double score = 0;  // sum of two fractions that both have: of the labels of the segmentation, and of those of either
  const Segment* mandible = nullptr;  // null: it has none
  std::string objection;              // why it does not fit; empty if it does
};

/// Returns the fit of each preset, the best first: those without objection, then by their labels. A preset does not fit
/// if a structure would have a volume that it cannot have, or would lie where it cannot lie, such as the upper teeth
/// below the mandible.
std::vector<PresetFit> FitPresets(const Segmentation& segmentation);

/// Returns a sentence that proposes the presets that fit, or says why the nearest one does not.
std::string ProposePreset(const Segmentation& segmentation);

}  // namespace kerf
