// kerf materials: lists the regions' constants, and the laws from CT number to modulus with the range in which each is
// valid.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "base/files/files.h"
#include "bone/material/ct_law_table.h"
#include "bone/material/region_table.h"

namespace kerf::cli {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMaxMaterialsBytes = std::size_t{1} << 20;

struct MaterialsArguments {
  std::string regions;
  std::string laws;
  bool json = false;
};

const char* TagText(char tag) {
  return tag == 'S' ? "coefficients read in the source" : tag == 'D' ? "derived" : "partly from memory, not verified";
}

void PrintJson(const MaterialTable& table, const std::vector<CtLaw>& laws) {
  ordered_json json;
  json["regions"] = ordered_json::array();
  for (const auto& [id, r] : table.regions()) {
    json["regions"].push_back({{"id", id},
                               {"name", r.name},
                               {"tissue", ToString(r.tissue)},
                               {"E_GPa", r.E_MPa / 1000},
                               {"nu", r.nu},
                               {"estimate", r.estimate},
                               {"source", r.source}});
    if (r.has_interval()) json["regions"].back()["E_interval_GPa"] = {r.E_lower_MPa / 1000, r.E_upper_MPa / 1000};
  }
  json["ct_laws"] = ordered_json::array();
  for (const CtLaw& law : laws) {
    ordered_json row = {{"name", law.name},
                        {"tissue", law.tissue},
                        {"density", law.density},
                        {"valid_g_per_cm3", {law.lower_rho(), law.upper_rho()}},
                        {"E_GPa", {CalcModulus(law, law.lower_rho()) / 1000, CalcModulus(law, law.upper_rho()) / 1000}},
                        {"calibration_HU_g_per_cm3", nullptr},
                        {"valid_HU", nullptr},
                        {"tag", std::string(1, law.tag)},
                        {"source", law.source}};
    row["bands"] = ordered_json::array();
    for (const CtLaw::Band& b : law.bands) {
      row["bands"].push_back({{"lower_g_per_cm3", b.lower},
                              {"upper_g_per_cm3", b.upper},
                              {"E0_MPa", b.E0_MPa},
                              {"a_MPa", b.a_MPa},
                              {"b", b.b}});
    }
    if (!law.calibration.empty()) {
      const auto [low, high] = CalcValidHu(law);
      row["calibration_HU_g_per_cm3"] = FormatCalibration(law.calibration);
      row["valid_HU"] = {low, high};
    }
    json["ct_laws"].push_back(row);
  }
  fmt::print("{}\n", json.dump(2, ' ', false, ordered_json::error_handler_t::replace));
}

void PrintText(const MaterialTable& table, const std::vector<CtLaw>& laws) {
  fmt::print("Regions ([material] kind = \"regions\")\n");
  fmt::print("  {:>3}  {:<34} {:<11} {:>8} {:<13} {:>5}  {:<4} {}\n", "id", "region", "tissue", "E (GPa)", "interval",
             "nu", "est.", "source");
  for (const auto& [id, r] : table.regions()) {
    const std::string interval =
        r.has_interval() ? fmt::format("{:g} to {:g}", r.E_lower_MPa / 1000, r.E_upper_MPa / 1000) : "";
    fmt::print("  {:>3}  {:<34} {:<11} {:>8.4g} {:<13} {:>5.2f}  {:<4} {}\n", id, r.name, ToString(r.tissue),
               r.E_MPa / 1000, interval, r.nu, r.estimate ? "yes" : "no", r.source);
  }
  fmt::print(
      "\nLaws from CT number to E ([material] kind = \"ct\", ct_law = \"...\"), for cancellous bone: in cortical "
      "bone the CT number\nexplains less than a fifth of the variance of the modulus (Rho, Hobatho and Ashman 1995)\n");
  for (const CtLaw& law : laws) {
    fmt::print("  {}\n", law.name);
    fmt::print("    made for     {}\n", law.tissue);
    for (const CtLaw::Band& b : law.bands) {
      const std::string offset = b.E0_MPa != 0 ? fmt::format("{:g} + ", b.E0_MPa) : "";
      fmt::print("    law          E = {}{:g} rho^{:g} MPa, {:g} to {:g} g/cm3 ({} density): {:.3g} to {:.3g} GPa\n",
                 offset, b.a_MPa, b.b, b.lower, b.upper, law.density,
                 (b.E0_MPa + b.a_MPa * std::pow(b.lower, b.b)) / 1000,
                 (b.E0_MPa + b.a_MPa * std::pow(b.upper, b.b)) / 1000);
    }
    if (law.calibration.empty()) {
      fmt::print("    calibration  none: the scene must give ct_calibration, from the scanner's phantom\n");
    } else {
      const auto [low, high] = CalcValidHu(law);
      fmt::print("    calibration  {} (HU:g/cm3); valid from {:.0f} to {:.0f} HU\n", FormatCalibration(law.calibration),
                 low, high);
    }
    fmt::print("    source       {} ({})\n", law.source, TagText(law.tag));
  }
}

void Run(const MaterialsArguments& options) {
  const MaterialTable table =
      options.regions.empty() ? DefaultMandibleTable()
                              : ParseRegionTable(ReadTextFile(options.regions, kMaxMaterialsBytes), options.regions);
  const std::vector<CtLaw> laws = options.laws.empty()
                                      ? DefaultCtLaws()
                                      : ParseCtLaws(ReadTextFile(options.laws, kMaxMaterialsBytes), options.laws);
  if (options.json) {
    PrintJson(table, laws);
  } else {
    PrintText(table, laws);
  }
}

}  // namespace

void AddMaterialsCommand(CLI::App& app) {
  const auto options = std::make_shared<MaterialsArguments>();
  CLI::App* command = app.add_subcommand(
      "materials", "List the regions' elastic constants and the laws from CT number to modulus, with their sources");
  command->add_option("--regions", options->regions, "Region table (CSV) instead of the built-in one");
  command->add_option("--laws", options->laws, "Table of CT laws (CSV) instead of the built-in one");
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
