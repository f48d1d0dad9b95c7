// Tests of `kerf materials`, and of the kinds of material from the CT to the result.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;

class Materials : public test::ProgramTest {};

TEST_F(Materials, ListsRegionsAndLawsWithTheirValidity) {
  const ProgramResult text = Kerf("materials");
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_EQ(text.err, "");
  for (const char* part :
       {"molar base", "Estimate: ", "E = 1157.1 rho^1.78 MPa, 0.8 to 1.8 g/cm3 (mass density)",
        "valid from 121 to 3000 HU", "less than a fifth of the variance of the modulus", "not verified"}) {
    EXPECT_THAT(text.out, HasSubstr(part));
  }
  const ProgramResult json = Kerf("materials --json");
  ASSERT_EQ(json.code, 0) << json.err;
  const auto all = nlohmann::json::parse(json.out);
  EXPECT_EQ(all["regions"].size(), 34u);
  ASSERT_EQ(all["ct_laws"].size(), 5u);
  EXPECT_EQ(all["ct_laws"][0]["name"], "mandible_matmap");
  EXPECT_EQ(all["ct_laws"][0]["bands"][1]["a_MPa"], 2017.3);
  EXPECT_TRUE(all["ct_laws"][1]["valid_HU"].is_null());
  Write("bad.csv", "name,tissue,density,calibration,bands,tag,source\na,b,ash,none,1 to 2: 3 rho^4,S\n");
  ExpectRefusal(Kerf("materials --laws bad.csv"),
                "bad.csv:2: 6 fields instead of 7; a field with a comma must be in double quotes");
}

TEST_F(Materials, HuVoxelRequiresKeepHuAndAValidSize) {
  EXPECT_EQ(Kerf("import ct.nrrd -o b.vdb --hu-voxel 1").code, 2);
  EXPECT_EQ(Kerf("import ct.nrrd -o b.vdb --keep-hu --hu-voxel 9").code, 2);
}

TEST_F(Materials, CutsVisibleHumanWithRegionUniformAndCtMaterials) {
  const std::string ct = KERF_TEST_DATA "/visible_human_female/vhf_head_hu_int16_250x250x234.nrrd";
  if (!std::filesystem::exists(ct)) GTEST_SKIP() << "no " << ct;
  ASSERT_EQ(Kerf("import '" + ct + "' --voxel 0.4 -o plain.vdb").code, 0);
  const ProgramResult import = Kerf("import '" + ct + "' --voxel 0.4 --keep-hu --json -o hu.vdb");
  ASSERT_EQ(import.code, 0) << import.err;
  EXPECT_EQ(nlohmann::json::parse(import.out)["hu"]["voxel_mm"], 1.0);
  EXPECT_THAT(Kerf("info hu.vdb").out, HasSubstr(" HU in the bone, mean "));

  // The disc moves 9 mm down into the left body, so that it cuts cortex and marrow.
  const std::string rest = test::StrokeToml({21.9, -70.05, 60}, {21.9, -70.05, 51}, 6, {0.6, 0.8, 0}) +
                           "[force]\nlaw = \"hertz_chip\"\n[simulation]\nrate_hz = 500\n" +
                           "[output]\npictures = false\npieces = false\nbone = false\n";
  const std::string by_ct = "[material]\nkind = \"ct\"\nct_law = \"mandible_matmap\"\n";
  const auto run = [&](const std::string& bone, const std::string& material) {
    Write("s.toml", "[bone]\nfile = \"" + bone + "\"\n" + material + rest);
    const ProgramResult result = Kerf("run s.toml -o out --json");
    EXPECT_EQ(result.code, 0) << result.err;
    auto json = nlohmann::json::parse(result.out);
    std::printf("%-8s peak %.3f N, mean %.3f N, impulse %.3f N s\n",
                json["material"]["kind"].get<std::string>().c_str(), json["force"]["peak_N"].get<double>(),
                json["force"]["mean_while_cutting_N"].get<double>(), json["force"]["impulse_Ns"].get<double>());
    return json;
  };
  const auto regions = run("plain.vdb", "");
  const auto also_regions = run("hu.vdb", "");
  const auto uniform = run("hu.vdb", "[material]\nkind = \"uniform\"\n");
  const auto cancellous = run("hu.vdb", by_ct);
  const auto all = run("hu.vdb", by_ct + "ct_applies_to = \"all\"\n");

  // Naming the default explicitly costs nothing and changes nothing.
  EXPECT_EQ(regions["force"], also_regions["force"]);
  EXPECT_EQ(regions["bone"], also_regions["bone"]);
  for (const auto& other : {uniform, cancellous, all}) {
    EXPECT_EQ(other["bone"]["hash_after"], regions["bone"]["hash_after"]);
    EXPECT_NE(other["force"]["impulse_Ns"], regions["force"]["impulse_Ns"]);
  }
  // With the E of cortex everywhere, the marrow is too hard.
  EXPECT_GT(uniform["force"]["impulse_Ns"], regions["force"]["impulse_Ns"]);
  // The marrow contributes little to the force, and the law's E in it (0.78 to 3.3 GPa) is near the table's 1.37.
  const double impulse = regions["force"]["impulse_Ns"];
  EXPECT_NEAR(cancellous["force"]["impulse_Ns"].get<double>() / impulse, 1, 0.1);
  // With E from the CT, the cortex is far too soft, because of the partial volume effect and a law that does not apply
  // to cortex.
  EXPECT_LT(all["force"]["impulse_Ns"].get<double>(), 0.6 * impulse);
  EXPECT_GE(cancellous["material"]["E_GPa"]["min"].get<double>(), 0.777);
  EXPECT_LE(cancellous["material"]["E_GPa"]["max"].get<double>(), 3.3);
  EXPECT_GT(cancellous["material"]["share_below_range"].get<double>(), 0.01);
  EXPECT_LT(cancellous["material"]["share_below_range"].get<double>(), 0.2);

  Write("s.toml", "[bone]\nfile = \"plain.vdb\"\n" + by_ct + rest);
  const ProgramResult none = Kerf("check s.toml");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err,
              HasSubstr("plain.vdb: contains no CT numbers, which kind = \"ct\" requires; import the CT again with "
                        "'kerf import --keep-hu'\n"));
  Write("s.toml", "[bone]\nfile = \"hu.vdb\"\n" + by_ct + "ct_applies_to = \"all\"\n" + rest);
  const char* warning = "in cortical bone the CT number explains less than a fifth";
  EXPECT_THAT(Kerf("check s.toml").err, HasSubstr(warning));
  // The same holds in slab mode and in the summary.
  std::string slab_rest = rest;
  slab_rest.replace(slab_rest.find("rate_hz"), 0, "mode = \"slab\"\n");
  Write("slab.toml", "[bone]\nfile = \"hu.vdb\"\n" + by_ct + "ct_applies_to = \"all\"\n" + slab_rest +
                         "[slab]\ndirection = [0, 0, -1]\n");
  const ProgramResult slab = Kerf("check slab.toml");
  EXPECT_THAT(slab.err, HasSubstr(warning)) << slab.code;
}

}  // namespace
}  // namespace kerf
