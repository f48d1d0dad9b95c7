// Tests of the reader's messages for [material].
#include <gtest/gtest.h>

#include "scene_text.h"

namespace kerf {
namespace {

const std::string kFileScene =
    "[bone]\nfile = \"b.vdb\"\n[[path.stroke]]\nstart_mm = [0,0,0]\nend_mm = [1,0,0]\nfeed_mm_per_s = 3\n"
    "disc_normal = [0,1,0]\n[material]\n";

TEST(SceneMaterial, IsByRegionByDefault) {
  EXPECT_EQ(ParseScene(test::ShortScene(), "s.toml").material.kind, MaterialKind::kRegions);
  const Scene scene = ParseScene(test::ShortScene() + "[material]\nkind = \"uniform\"\n", "s.toml");
  EXPECT_EQ(scene.material.kind, MaterialKind::kUniform);
  // This is the paper's region 24.
  EXPECT_EQ(scene.material.E_GPa, 19.3);
  EXPECT_EQ(scene.material.nu, 0.28);
}

TEST(SceneMaterial, KeysOfAnotherKindAreRefused) {
  EXPECT_EQ(test::MessageFor(test::ShortScene() + "[material]\nE_GPa = 3\n"),
            "s.toml:9:1: E_GPa is not used: kind = \"regions\"; remove it");
  EXPECT_EQ(test::MessageFor(test::ShortScene() + "[material]\nkind = \"uniform\"\nct_law = \"mandible_matmap\"\n"),
            "s.toml:10:1: ct_law is not used: kind = \"uniform\"; remove it");
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"ct\"\nct_law = \"mandible_matmap\"\nnu = 0.3\n"),
            "s.toml:11:1: nu is not used: kind = \"ct\"; remove it");
  EXPECT_EQ(
      test::MessageFor(kFileScene + "ct_applies_to = \"all\"\nct_calibration = \"0:0 1:1\"\nct_law_file = \"a\"\n"),
      "s.toml:9:1: ct_applies_to is not used: kind = \"regions\"; remove it\n"
      "s.toml:10:1: ct_calibration is not used: kind = \"regions\"; remove it\n"
      "s.toml:11:1: ct_law_file is not used: kind = \"regions\"; remove it");
}

TEST(SceneMaterial, ACtLawMustBeNamedAndKnown) {
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"ct\"\n"),
            "s.toml:8:2: [material] has no ct_law; kerf has mandible_matmap, morgan_2003_vertebra, morgan_2003_tibia, "
            "morgan_2003_trochanter, morgan_2003_femoral_neck, and none of them applies to all bone: 'kerf materials' "
            "shows what each applies to");
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"ct\"\nct_law = \"mandible_mapmat\"\n"),
            "s.toml:10:1: ct_law = \"mandible_mapmat\" is unknown; the nearest is \"mandible_matmap\"");
  // A file of laws is not opened before the scene runs.
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"ct\"\nct_law = \"mine\"\nct_law_file = \"laws.csv\"\n"), "");
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"ct\"\nct_law = \"mandible_matmap\"\nct_calibration = \"0:0.1\"\n"),
            "s.toml:11:1: a calibration has at least two points HU:density");
  EXPECT_EQ(
      test::MessageFor(kFileScene + "kind = \"ct\"\nct_law = \"mandible_matmap\"\nct_calibration = \"0:0.1 9\"\n"),
      "s.toml:11:1: calibration point \"9\" is not HU:density, such as 1000:1.2");
  EXPECT_EQ(test::MessageFor(kFileScene + "kind = \"xray\"\n"),
            "s.toml:9:1: kind = \"xray\" is unknown; it must be \"regions\" or \"uniform\" or \"ct\"");
}

TEST(SceneMaterial, AModelHasNoCtNumbers) {
  EXPECT_EQ(test::MessageFor(test::ShortScene() + "[material]\nkind = \"ct\"\nct_law = \"mandible_matmap\"\n"),
            "s.toml:9:1: kind = \"ct\" needs CT numbers, and a bone with model = \"block\" has none; give a file made "
            "with 'kerf import --keep-hu'");
}

}  // namespace
}  // namespace kerf
