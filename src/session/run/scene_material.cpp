#include "session/run/scene_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/files/files.h"
#include "bone/material/ct_law_table.h"
#include "kerf/error.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxLawFileBytes = std::size_t{1} << 20;

CtLaw ReadLaw(const SceneMaterial& material) {
  if (material.ct_law_file.empty()) return FindCtLaw(DefaultCtLaws(), material.ct_law);
  const std::vector<CtLaw> laws =
      ParseCtLaws(ReadTextFile(material.ct_law_file, kMaxLawFileBytes), material.ct_law_file);
  try {
    return FindCtLaw(laws, material.ct_law);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", material.ct_law_file, e.what()));
  }
}

void ApplyCt(const Scene& scene, Bone& bone, MaterialSummary& summary) {
  const SceneMaterial& material = scene.material;
  summary.law = WithCalibration(ReadLaw(material), material.ct_calibration);
  summary.own_calibration = material.ct_calibration.empty();
  if (!bone.has_hu()) {
    throw Error(
        fmt::format("{}: contains no CT numbers, which kind = \"ct\" requires; import the CT again with "
                    "'kerf import --keep-hu'",
                    scene.bone.file));
  }
  summary.ct = UseCtModulus(bone, summary.law, material.ct_all);
  for (const auto& [id, region] : bone.materials().regions()) {
    if (material.ct_all || region.tissue == Tissue::kCancellous) summary.ct_regions.push_back(id);
  }
  const CtModulusReport& ct = summary.ct;
  const auto [low, high] = CalcValidHu(summary.law);
  if (ct.voxels == 0) {
    summary.warnings.emplace_back("no part of the bone takes its E from the CT: no CT voxel lies in such a region");
  } else if (ct.fraction_below + ct.fraction_above > 0) {
    summary.warnings.push_back(
        fmt::format("{:.1f} % of the bone that takes E from the CT lies outside the range of {} ({:.0f} to {:.0f} HU) "
                    "and gets the E at its ends: {:.1f} % below, {:.1f} % above",
                    100 * (ct.fraction_below + ct.fraction_above), summary.law.name, low, high, 100 * ct.fraction_below,
                    100 * ct.fraction_above));
  }
  if (material.ct_all) {
    summary.warnings.emplace_back(
        "ct_applies_to = \"all\": in cortical bone the CT number explains less than a fifth of the variance of the "
        "modulus (Rho, "
        "Hobatho "
        "and Ashman 1995), and soft tissue lowers it near the surface; \"cancellous\" gives cortex its region's "
        "constants");
  }
  const std::vector<LawParameter>& parameters = scene.force.info().parameters;
  if (std::ranges::find(parameters, std::string_view("density_exponent"), &LawParameter::key) != parameters.end() &&
      scene.force.Get("density_exponent") > 0) {
    const double b = scene.force.Get("modulus_exponent");
    const std::vector<CtLaw::Band>& bands = summary.law.bands;
    if (bands.size() > 1 || bands[0].E0_MPa != 0 || bands[0].b != b) {
      summary.warnings.push_back(
          fmt::format("the force law takes the density from E ~ density^{:g} (modulus_exponent), and {} has another "
                      "relation, so its density is not that of the CT",
                      b, summary.law.name));
    }
  }
  if (summary.law.tag == 'R') {
    summary.warnings.push_back(fmt::format("part of the law {} is quoted from memory, not verified: {}",
                                           summary.law.name, summary.law.source));
  }
}

}  // namespace

MaterialSummary ApplySceneMaterial(const Scene& scene, Bone& bone) {
  MaterialSummary summary;
  summary.kind = scene.material.kind;
  switch (scene.material.kind) {
    case MaterialKind::kRegions:
      break;
    case MaterialKind::kUniform:
      bone.OverrideMaterials(MakeUniformTable(bone.materials(), 1000 * scene.material.E_GPa, scene.material.nu));
      break;
    case MaterialKind::kCt:
      ApplyCt(scene, bone, summary);
      break;
  }
  if (scene.material.osteon_direction) {
    MaterialTable materials = bone.materials();
    materials.SetOsteonDirection(*scene.material.osteon_direction);
    bone.OverrideMaterials(std::move(materials));
  }
  return summary;
}

std::string DescribeMaterial(const Scene& scene, const MaterialSummary& s) {
  switch (s.kind) {
    case MaterialKind::kRegions:
      return "by region";
    case MaterialKind::kUniform:
      return fmt::format("uniform, E {:g} GPa, nu {:g}", scene.material.E_GPa, scene.material.nu);
    case MaterialKind::kCt:
      break;
  }
  const std::string where = scene.material.ct_all ? "all regions" : "cancellous regions";
  return fmt::format("E of {} from the CT by {}: {:.3g} to {:.3g} GPa, median {:.3g} GPa; {:.1f} % outside its range",
                     where, s.law.name, s.ct.E_min_MPa / 1000, s.ct.E_max_MPa / 1000, s.ct.E_p50_MPa / 1000,
                     100 * (s.ct.fraction_below + s.ct.fraction_above));
}

nlohmann::ordered_json MaterialJson(const Scene& scene, const MaterialSummary& s) {
  nlohmann::ordered_json json = {{"kind", kMaterialKindWords[static_cast<std::size_t>(s.kind)]}};
  if (s.kind == MaterialKind::kRegions) {
    json["source"] = scene.bone.materials.empty() ? "the bone's own table" : scene.bone.materials;
  } else if (s.kind == MaterialKind::kUniform) {
    json["E_GPa"] = scene.material.E_GPa;
    json["nu"] = scene.material.nu;
    json["source"] = "the scene";
    json["estimate"] = true;
  } else {
    const auto [low, high] = CalcValidHu(s.law);
    json["law"] = s.law.name;
    json["source"] = s.law.source;
    json["tissue"] = s.law.tissue;
    json["density"] = s.law.density;
    json["estimate"] = true;
    json["tag"] = std::string(1, s.law.tag);
    json["calibration_HU_g_per_cm3"] = FormatCalibration(s.law.calibration);
    json["calibration_source"] = s.own_calibration ? "the law" : "the scene";
    json["valid_HU"] = {low, high};
    json["valid_g_per_cm3"] = {s.law.lower_rho(), s.law.upper_rho()};
    json["applies_to"] = scene.material.ct_all ? "all" : "cancellous";
    json["regions"] = s.ct_regions;
    json["voxels"] = s.ct.voxels;
    json["share_below_range"] = s.ct.fraction_below;
    json["share_above_range"] = s.ct.fraction_above;
    json["E_GPa"] = {{"min", s.ct.E_min_MPa / 1000},
                     {"p5", s.ct.E_p5_MPa / 1000},
                     {"p50", s.ct.E_p50_MPa / 1000},
                     {"p95", s.ct.E_p95_MPa / 1000},
                     {"max", s.ct.E_max_MPa / 1000}};
  }
  json["warnings"] = s.warnings;
  return json;
}

}  // namespace kerf
