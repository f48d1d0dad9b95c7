// The meaning of names, codes and presets, and the mask made of them.
#include "bone/segmentation/roles.h"

#include <gmock/gmock.h>

#include <set>

#include "bone/segmentation/preset_check.h"
#include "label_files.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using enum SegmentRole;

Segmentation MakeSegmentation(const std::vector<std::pair<int, std::string>>& labels) {
  Segmentation segmentation;
  segmentation.path = "a.nrrd";
  segmentation.lattice.size = {static_cast<int>(labels.size()), 1, 1};
  segmentation.layers.emplace_back();
  for (const auto& [label, name] : labels) {
    Segment segment;
    segment.name = name;
    segment.label = label;
    segment.voxels = 1;
    segment.volume_mm3 = 1000 * label;
    segmentation.named |= !name.empty();
    segmentation.segments.push_back(segment);
    segmentation.layers[0].push_back(static_cast<std::int16_t>(label));
  }
  return segmentation;
}

TEST(SegmentNames, AreUnderstoodAsSlicerAndItsExtensionsWriteThem) {
  const std::vector<std::pair<const char*, SegmentMeaning>> cases = {
      {"Mandible", {kMandible}},
      {"mandible", {kMandible}},
      {"lower_jawbone", {kMandible}},
      {"Lower jaw", {kMandible}},
      {"Unterkiefer", {kMandible}},
      {"MAND", {kMandible}},
      {"Maxilla / Upper Skull", {kOtherBone}},
      {"Upper skull", {kOtherBone}},
      {"upper_jawbone", {kOtherBone}},
      {"Sch\xc3\xa4"
       "del",
       {kOtherBone}},
      {"Upper Teeth", {kTooth, 0, JawPart::kUpper}},
      {"teeth_lower", {kTooth, 0, JawPart::kLower}},
      {"Unterkieferz\xc3\xa4hne", {kTooth, 0, JawPart::kLower}},
      {"lower_left_first_molar_fdi36", {kTooth, 36, JawPart::kLower}},
      {"Lower right third molar", {kTooth, 48, JawPart::kLower}},
      {"upper_left_canine_pulp_fdi123", {kTooth, 23, JawPart::kUpper}},
      {"Zahn 11", {kTooth, 11, JawPart::kUpper}},
      {"tooth_85", {kTooth, 85, JawPart::kLower}},
      {"tooth", {kTooth}},
      {"Tooth 19", {kTooth}},  // no number of ISO 3950
      {"Mandibular canal", {kCanal}},
      {"left_inferior_alveolar_canal", {kCanal, 0, {}, JawSide::kLeft}},
      {"Nervus alveolaris inferior rechts", {kCanal, 0, {}, JawSide::kRight}},
      {"right_mandibular_incisive_canal_fdi104", {kCanal, 0, {}, JawSide::kRight}},
      {"Canal R", {kCanal, 0, {}, JawSide::kRight}},
      {"implant", {kMetal}},
      {"Reconstruction plate", {kMetal}},
      {"Tumor", {kLesion}},
      {"left_maxillary_sinus", {kIgnored}},
      {"pharynx", {kIgnored}},
  };
  for (const auto& [name, expected] : cases) {
    const std::optional<SegmentMeaning> found = FindMeaning(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(*found, expected) << name << ": " << ToString(found->role) << " " << found->fdi;
  }
  for (const char* name : {"", "Segment_1", "facial nerve", "optic canal", "liver", "not the mandible", "non-mandible",
                           "Mandible planned resection", "Resektat Unterkiefer", "Mandible marrow"})
    EXPECT_FALSE(FindMeaning(name)) << name;
}

TEST(SegmentNames, CodesGiveTheRoleAndMustAgreeWithTheName) {
  Segmentation segmentation = MakeSegmentation({{1, "Segment_1"}, {2, "Segment_2"}});
  segmentation.segments[0].codes = {"91609006"};
  segmentation.segments[1].codes = {"866006002"};
  const SegmentationRoles roles = FindRoles(segmentation, {});
  EXPECT_EQ(roles.meanings[0], SegmentMeaning{kMandible});
  EXPECT_EQ(roles.meanings[1], (SegmentMeaning{kTooth, 36, JawPart::kLower}));
  segmentation.segments[0].name = "Maxilla";
  EXPECT_THAT(MessageOf([&] { FindRoles(segmentation, {}); }),
              HasSubstr("'Maxilla' (label 1, 1.00 cm3) is other by its name, but mandible by its code"));
}

TEST(LabelPresets, EachHasOneMandibleAndOnlyKnownNames) {
  for (const LabelPreset& preset : ListLabelPresets()) {
    int mandibles = 0;
    std::set<int> labels;
    for (const PresetLabel& label : preset.labels) {
      const std::optional<SegmentMeaning> meaning = FindMeaning(label.name);
      ASSERT_TRUE(meaning) << preset.name << ": " << label.name;
      mandibles += meaning->role == kMandible ? 1 : 0;
      EXPECT_TRUE(labels.insert(label.label).second) << preset.name << ": " << label.label;
    }
    EXPECT_EQ(mandibles, 1) << preset.name;
  }
}

TEST(LabelPresets, GiveTheLabelsOfTheirSources) {
  const auto meaning = [](const char* preset, int label) {
    const Segmentation map = MakeSegmentation({{label, ""}, {1, ""}, {2, ""}});
    return FindRoles(map, {.preset = preset, .assignments = {}}).meanings[0];
  };
  EXPECT_EQ(meaning("dentalsegmentator", 5), SegmentMeaning{kCanal});
  EXPECT_EQ(meaning("dentalsegmentator", 3), (SegmentMeaning{kTooth, 0, JawPart::kUpper}));
  EXPECT_EQ(meaning("totalsegmentator", 3), SegmentMeaning{kOtherBone});
  EXPECT_EQ(meaning("totalsegmentator-teeth", 3), (SegmentMeaning{kCanal, 0, {}, JawSide::kLeft}));
  EXPECT_EQ(meaning("totalsegmentator-teeth", 32), (SegmentMeaning{kTooth, 36, JawPart::kLower}));
  EXPECT_EQ(meaning("totalsegmentator-teeth", 45), SegmentMeaning{kCanal});
  EXPECT_EQ(meaning("totalsegmentator-teeth", 77), (SegmentMeaning{kTooth, 48, JawPart::kLower}));
  EXPECT_EQ(meaning("toothfairy2", 4), (SegmentMeaning{kCanal, 0, {}, JawSide::kRight}));
  EXPECT_EQ(meaning("toothfairy2", 10), SegmentMeaning{kMetal});
  EXPECT_EQ(meaning("toothfairy2", 48), (SegmentMeaning{kTooth, 48, JawPart::kLower}));
  EXPECT_EQ(meaning("amasss", 4), SegmentMeaning{kOtherBone});
  EXPECT_EQ(meaning("nv-segment-ct", 4), SegmentMeaning{kTooth});
  EXPECT_EQ(meaning("nv-segment-ct", 6), SegmentMeaning{kLesion});
  EXPECT_THAT(MessageOf([&] { meaning("slicer", 1); }),
              HasSubstr("there is no such preset; the presets are dentalsegm"));
}

// A head in boxes, on voxels of 2 mm: 0 nothing, 1 skull, 2 mandible of 86 cm3 with its canals, 3 and 4 upper and lower
// teeth, 5 canals.
int HeadLabel(const Vec3& p_W) {
  const double x = std::abs(p_W.x), y = p_W.y, z = p_W.z;
  if (x < 40 && y > -40 && y < 60 && z > 62 && z < 90) return 1;
  if (x < 25 && y > -38 && y < -32 && z > 32 && z < 42) return 3;
  if (x < 25 && y > -38 && y < -32 && z > 20 && z < 30) return 4;
  if (x > 36 && x < 40 && std::abs(y) < 20 && z > 8 && z < 12) return 5;
  const bool body = x < 50 && y > -40 && y < 30 && z > 0 && z < 20 && (x > 30 || y < -25);
  return body || (x > 38 && x < 48 && y > 15 && y < 30 && z >= 20 && z < 60) ? 2 : 0;
}

/// The head with the given labels of its structures; `up` of -1 turns it upside down.
Segmentation MakeHead(const std::vector<int>& labels, double up = 1) {
  Volume lattice;
  lattice.size = {60, 60, 50};
  lattice.spacing_mm = Vec3(2);
  lattice.origin_W = {-59, -49, up > 0 ? -3.0 : -95.0};
  const test::Folder folder;
  const Volume map = test::MakeLabels(lattice, [&](const Vec3& p_W) {
    return labels[static_cast<std::size_t>(HeadLabel({p_W.x, p_W.y, up * p_W.z}))];
  });
  test::WriteNrrd(map, folder.file("a.nrrd"));
  return ReadSegmentation(folder.file("a.nrrd"));
}

TEST(LabelPresets, AreProposedIfVolumesAndPlacesFit) {
  struct Case {
    const char* preset;
    std::vector<int> labels;  // of nothing, skull, mandible, upper teeth, lower teeth, canals
  };
  for (const Case& c : {Case{"dentalsegmentator", {0, 1, 2, 3, 4, 5}},
                        {"dentalsegmentator", {0, 1, 2, 3, 4, 0}},
                        {"totalsegmentator", {0, 3, 1, 7, 2, 1}},
                        {"nv-segment-ct", {0, 2, 1, 4, 4, 3}},
                        {"toothfairy2", {0, 2, 1, 12, 38, 3}}}) {
    const Segmentation head = MakeHead(c.labels);
    const std::vector<PresetFit> fits = FitPresets(head);
    EXPECT_EQ(fits[0].preset->name, c.preset);
    EXPECT_EQ(fits[0].objection, "");
    for (const PresetFit& fit : fits) {
      if (!fit.objection.empty()) continue;
      EXPECT_EQ(fit.mandible->label, c.labels[2]) << c.preset << ": " << fit.preset->name;
    }
    EXPECT_THAT(MessageOf([&] { FindRoles(head, {}); }),
                AllOf(HasSubstr("the file does not say what its labels are. They are:\n"),
                      HasSubstr(fmt::format("By volume and place, --labels {} fits best, in which label {} (", c.preset,
                                            c.labels[2]))));
  }
  const Segmentation wrong_way_up = MakeHead({0, 1, 2, 3, 4, 5}, -1);
  EXPECT_THAT(MessageOf([&] { FindRoles(wrong_way_up, {}); }),
              HasSubstr("No preset of --labels fits; of the nearest, dentalsegmentator, label 1 (224.00 cm3) would be "
                        "'Upper skull', but does not lie above the mandible, which would be label 2 ("));
  EXPECT_THAT(FindRoles(wrong_way_up, {.preset = "dentalsegmentator", .assignments = {}}).warnings,
              ElementsAre(HasSubstr("the labels may not be those of --labels dentalsegmentator")));
  EXPECT_THAT(MessageOf([] { FindRoles(MakeSegmentation({{90, ""}}), {}); }), HasSubstr("No preset of --labels fits."));
}

TEST(LabelPresets, ThatDoNotFitAreRefusedIfAnotherDoes) {
  const Segmentation head = MakeHead({0, 1, 2, 3, 4, 0});
  for (const char* wrong : {"totalsegmentator", "amasss", "nv-segment-ct"}) {
    EXPECT_THAT(MessageOf([&] { FindRoles(head, {.preset = wrong, .assignments = {}}); }),
                AllOf(HasSubstr(fmt::format("the labels are not those of --labels {}: label 1 (224.00 cm3) would be "
                                            "'mandible', which has 8 to 120 cm3; --labels dentalsegmentator fits, in "
                                            "which label 2 (",
                                            wrong)),
                      HasSubstr("--label 2=mandible")));
  }
  // The user's word counts.
  EXPECT_EQ(FindRoles(head, {.preset = "amasss", .assignments = {"2=mandible", "1=other"}}).meanings[1].role,
            kMandible);
}

TEST(LabelPresets, NameTheCanalThatIsAbsent) {
  const LabelOptions dental{.preset = "dentalsegmentator", .assignments = {}};
  EXPECT_THAT(FindRoles(MakeHead({0, 1, 2, 3, 4, 0}), dental).warnings,
              ElementsAre("the canal of the nerve is absent from the mask: no voxel is 'Mandibular canal' (label 5)"));
  EXPECT_TRUE(FindRoles(MakeHead({0, 1, 2, 3, 4, 5}), dental).warnings.empty());
  EXPECT_THAT(
      FindRoles(MakeHead({0, 1, 2, 3, 4, 0}), {.preset = "", .assignments = {"2=mandible", "5=canal"}}).warnings,
      ::testing::Contains(HasSubstr("no voxel has the label of --label 5=canal")));
}

TEST(LabelRoles, AssignmentsNameLabelsOrSegments) {
  const Segmentation map = MakeSegmentation({{1, ""}, {2, ""}, {7, ""}});
  const SegmentationRoles roles = FindRoles(map, {.preset = "", .assignments = {"2=mandible", "7=tooth36"}});
  EXPECT_EQ(roles.meanings[0], SegmentMeaning{kIgnored});
  EXPECT_EQ(roles.meanings[1], SegmentMeaning{kMandible});
  EXPECT_EQ(roles.meanings[2], (SegmentMeaning{kTooth, 36, JawPart::kLower}));
  EXPECT_THAT(roles.warnings, ElementsAre(HasSubstr("unknown meaning were ignored: label 1 (1.00 cm3)")));

  const Segmentation named = MakeSegmentation({{1, "Bone"}, {2, "Mandible"}});
  EXPECT_EQ(FindRoles(named, {.preset = "", .assignments = {"Bone=other"}}).meanings[0], SegmentMeaning{kOtherBone});
  const auto message = [&](const char* assignment) {
    return MessageOf([&] { FindRoles(named, {.preset = "", .assignments = {assignment}}); });
  };
  EXPECT_THAT(message("Jaw=mandible"), HasSubstr("has no segment 'Jaw'; it has:\n  'Bone' (label 1, 1.00 cm3)"));
  EXPECT_THAT(message("Bone=jaw"), HasSubstr("'jaw' is no role; the roles are mandible, "));
  EXPECT_THAT(message("Bone"), HasSubstr("should be LABEL=ROLE or NAME=ROLE"));
}

TEST(LabelRoles, ContradictionsAreRefusedOrNamed) {
  const Segmentation map = MakeSegmentation({{1, ""}, {2, ""}});
  EXPECT_THAT(MessageOf([&] {
                FindRoles(map, {.preset = "", .assignments = {"1=mandible", "2=canal", "2=metal"}});
              }),
              HasSubstr("--label 2=metal: contradicts another --label for the same segment, label 2 (2.00 cm3)"));
  EXPECT_EQ(MessageOf([&] {
              FindRoles(map, {.preset = "", .assignments = {"1=mandible", "2=canal", "2=canal"}});
            }),
            "");
  EXPECT_THAT(MessageOf([] { CheckAssignment("1=foo"); }), HasSubstr("'foo' is no role"));
  EXPECT_EQ(MessageOf([] { CheckAssignment("a=b=tooth36"); }), "");

  Segmentation named = MakeSegmentation({{1, "Mandible"},
                                         {2, "tooth 36"},
                                         {3, "lower left first molar"},
                                         {4, "tooth pulp 36"},
                                         {5, "tooth 99"},
                                         {6, "tooth 1 from the middle"},
                                         {7, "canal"}});
  named.segments[6].voxels = 0;
  EXPECT_THAT(FindRoles(named, {}).warnings,
              ElementsAre(HasSubstr("'tooth 36' (label 2, 2.00 cm3) and 'lower left first molar' (label 3, 3.00 cm3) "
                                    "are both tooth 36"),
                          HasSubstr("'tooth 99' (label 5, 5.00 cm3) is a tooth, but its number is not of ISO 3950"),
                          HasSubstr("the canal of the nerve is absent from the mask: no voxel is 'canal' (label 7")));
}

TEST(LabelRoles, TheMandibleMustBeOneSegment) {
  const Segmentation two = MakeSegmentation({{1, "Mandible"}, {2, "Unterkiefer"}});
  EXPECT_THAT(
      MessageOf([&] { FindRoles(two, {}); }),
      HasSubstr("the segments 'Mandible' (label 1, 1.00 cm3) and 'Unterkiefer' (label 2, 2.00 cm3) both claim to "
                "be the mandible; state which with --label, such as --label 'Unterkiefer=ignored'"));
  EXPECT_THAT(MessageOf([&] { FindRoles(two, {.preset = "", .assignments = {"Unterkiefer=mandible"}}); }),
              HasSubstr("such as --label 'Mandible=ignored'"));
  EXPECT_EQ(FindRoles(two, {.preset = "", .assignments = {"Unterkiefer=ignored"}}).meanings[0].role, kMandible);
  // Stated explicitly, two segments together are the mandible.
  const LabelOptions both{.preset = "", .assignments = {"1=mandible", "2=mandible"}};
  EXPECT_EQ(FindRoles(two, both).meanings[1].role, kMandible);
  EXPECT_THAT(MessageOf([] {
                FindRoles(MakeSegmentation({{1, "Maxilla"}}), {});
              }),
              HasSubstr("no segment is the mandible; state which"));
  Segmentation empty = MakeSegmentation({{1, "Mandible"}});
  empty.segments[0].voxels = 0;
  EXPECT_THAT(MessageOf([&] { FindRoles(empty, {}); }), HasSubstr("has no voxels"));
}

TEST(LabelRoles, OverlapsKeepFineStructuresAndLeaveContradictionsToTheCt) {
  Segmentation map = MakeSegmentation(
      {{1, "mandible"}, {2, "mandible canal"}, {3, "tooth 36"}, {4, "skull"}, {5, "implant"}, {6, "cyst"}});
  map.lattice.size = {7, 1, 1};
  map.layers = {{1, 1, 1, 1, 1, 1, 0}, {2, 3, 4, 5, 0, 6, 6}};
  for (std::size_t n = 1; n < 6; ++n) map.segments[n].layer = 1;
  const BoneMask mask = MakeBoneMask(map, FindRoles(map, {}));
  EXPECT_EQ(mask.At(0), MaskTissue::kCanal);
  EXPECT_EQ(mask.At(1), MaskTissue::kTooth);
  EXPECT_EQ(mask.At(2), MaskTissue::kUndecided);
  EXPECT_EQ(mask.At(3), MaskTissue::kBoneMetal);
  EXPECT_EQ(mask.At(4), MaskTissue::kBone);
  EXPECT_EQ(mask.At(5), MaskTissue::kBoneLesion);
  EXPECT_EQ(mask.At(6), MaskTissue::kLesion);
  EXPECT_EQ(mask.ToothAt(1), 36);
  EXPECT_EQ(mask.ToothAt(0), 0);
  EXPECT_EQ(ListTeeth(mask), std::vector<int>{36});
}

}  // namespace
}  // namespace kerf
