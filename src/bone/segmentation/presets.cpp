// The labels of programs and data whose files do not name them.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "bone/segmentation/roles.h"

namespace kerf {

namespace {

// The numbers of the permanent teeth after ISO 3950, in the order of TotalSegmentator's labels.
std::vector<int> ListTeeth() {
  std::vector<int> teeth;
  for (int quadrant = 1; quadrant <= 4; ++quadrant) {
    for (int n = 1; n <= 8; ++n) teeth.push_back(10 * quadrant + n);
  }
  return teeth;
}

std::vector<PresetLabel> WithTeeth(std::vector<PresetLabel> labels, bool label_is_number) {
  int next = labels.back().label + 1;
  for (const int fdi : ListTeeth()) {
    labels.push_back({label_is_number ? fdi : next, fmt::format("tooth {}", fdi)});
    ++next;
  }
  return labels;
}

std::vector<PresetLabel> MakeTotalSegmentatorTeeth() {
  std::vector<PresetLabel> labels = WithTeeth({{1, "lower_jawbone"},
                                               {2, "upper_jawbone"},
                                               {3, "left_inferior_alveolar_canal"},
                                               {4, "right_inferior_alveolar_canal"},
                                               {5, "left_maxillary_sinus"},
                                               {6, "right_maxillary_sinus"},
                                               {7, "pharynx"},
                                               {8, "bridge"},
                                               {9, "crown"},
                                               {10, "implant"}},
                                              false);
  labels.push_back({43, "left_mandibular_incisive_canal"});
  labels.push_back({44, "right_mandibular_incisive_canal"});
  labels.push_back({45, "lingual_canal"});
  int next = 46;
  for (const int fdi : ListTeeth()) labels.push_back({next++, fmt::format("pulp of tooth {}", fdi)});
  return labels;
}

}  // namespace

const std::vector<LabelPreset>& ListLabelPresets() {
  static const std::vector<LabelPreset> kPresets = {
      {"dentalsegmentator",
       "DentalSegmentator, nnU-Net Dataset112, Zenodo 10829674",
       {{1, "Upper skull"}, {2, "Mandible"}, {3, "Upper teeth"}, {4, "Lower teeth"}, {5, "Mandibular canal"}}},
      {"totalsegmentator",
       "TotalSegmentator, task craniofacial_structures, README of the project",
       {{1, "mandible"},
        {2, "teeth_lower"},
        {3, "skull"},
        {4, "head"},
        {5, "sinus_maxillary"},
        {6, "sinus_frontal"},
        {7, "teeth_upper"}}},
      {"totalsegmentator-teeth", "TotalSegmentator, task teeth (ToothFairy3), README of the project",
       MakeTotalSegmentatorTeeth()},
      {"toothfairy2", "ToothFairy2, README of the data",
       WithTeeth({{1, "lower_jawbone"},
                  {2, "upper_jawbone"},
                  {3, "left_inferior_alveolar_canal"},
                  {4, "right_inferior_alveolar_canal"},
                  {5, "left_maxillary_sinus"},
                  {6, "right_maxillary_sinus"},
                  {7, "pharynx"},
                  {8, "bridge"},
                  {9, "crown"},
                  {10, "implant"}},
                 true)},
      {"amasss",
       "AMASSS of SlicerAutomatedDentalTools, large structures, source code",
       {{1, "mandible"},
        {2, "cranial base"},
        {3, "upper airway"},
        {4, "maxilla"},
        {5, "cervical vertebra"},
        {6, "skin"}}},
      {"amasss-small",
       "AMASSS of SlicerAutomatedDentalTools, small structures, source code",
       {{1, "mandible"}, {2, "root canal"}, {4, "maxilla"}}},
      {"nv-segment-ct",
       "NV-Segment-CT, dental model, model card",
       {{1, "mandible"}, {2, "maxilla"}, {3, "canal"}, {4, "teeth"}, {5, "implant"}, {6, "lesion"}}},
  };
  return kPresets;
}

}  // namespace kerf
