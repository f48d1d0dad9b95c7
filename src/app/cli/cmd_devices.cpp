// kerf devices: lists the connected haptic devices and the properties of each known one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/numbers.h"
#include "base/table/table.h"
#include "device/devices/force_table.h"
#include "device/devices/profiles.h"
#include "device/drivers/device_list.h"
#include "device/drivers/libusb_bus.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

struct DevicesArguments {
  bool json = false;
  bool markdown = false;
  bool udev_rules = false;
  bool profiles = false;
  double peak_N = 28;
};

void PrintFound(const std::vector<FoundDevice>& devices) {
  if (devices.empty()) fmt::print("No supported device is connected.\n");
  for (const FoundDevice& found : devices) {
    fmt::print("{:<14} {} at {}: {}\n", found.choice, found.model, found.where,
               found.state == DeviceState::kReady ? "ready" : found.problem);
    if (!found.remedy.empty()) fmt::print("{:<14} {}\n", "", found.remedy);
  }
  fmt::print("\nSupported devices, by name for --device:\n");
  for (const KnownDevice& known : KnownDevices()) {
    fmt::print("{:<14} {} ({}){}\n", known.name, known.what, known.link, known.makes_force ? "" : ", without force");
  }
  fmt::print("\n'kerf devices --profiles' shows the properties of each, and of the simulated devices.\n");
}

void PrintFoundJson(const std::vector<FoundDevice>& devices) {
  Json json = {{"schema", 1}, {"devices", Json::array()}, {"known", Json::array()}};
  for (const FoundDevice& found : devices) {
    json["devices"].push_back({{"device", found.choice},
                               {"kind", found.kind->name},
                               {"model", found.model},
                               {"where", found.where},
                               {"node", found.usb.vendor != 0 ? Json(DeviceNode(found.usb)) : Json(nullptr)},
                               {"makes_force", found.kind->makes_force},
                               {"state", ToString(found.state)},
                               {"problem", found.problem},
                               {"remedy", found.remedy}});
  }
  for (const KnownDevice& known : KnownDevices()) {
    Json numbers = Json::array();
    for (const UsbNumbers& n : known.numbers) numbers.push_back(fmt::format("{:04x}:{:04x}", n.vendor, n.product));
    json["known"].push_back({{"kind", known.name},
                             {"what", known.what},
                             {"link", known.link},
                             {"makes_force", known.makes_force},
                             {"numbers", numbers}});
  }
  fmt::print("{}\n", json.dump(2));
}

/// Formats a value with three significant digits; "-" if it is unknown or absent.
std::string Figure(double value) {
  return value > 0 ? fmt::format("{:.3g}", value) : "-";
}

void PrintProfiles(const DevicesArguments& options) {
  const std::vector<ForceTableRow> table = CalcForceTable(DeviceProfiles(), options.peak_N);
  if (options.json) {
    Json json = {{"schema", 1}, {"expected_peak_N", options.peak_N}, {"profiles", Json::array()}};
    const auto known = [](double value) { return value > 0 ? Json(std::round(value * 1e6) / 1e6) : Json(nullptr); };
    for (const ForceTableRow& row : table) {
      json["profiles"].push_back({{"profile", row.profile.name},
                                  {"peak_force_N", row.profile.peak_force_N},
                                  {"scale", known(row.scale)},
                                  {"largest_N", known(row.largest_N)},
                                  {"friction_hides_below_N", known(row.masked_N)},
                                  {"largest_over_hidden", known(row.range)},
                                  {"for_ever_N", known(row.lasting_N)},
                                  {"for_ever_share", known(row.lasting_fraction)},
                                  {"source", row.profile.source}});
    }
    fmt::print("{}\n", json.dump(2));
    return;
  }
  TextTable rows({"profile", "peak (N)", "scale", "largest (N)", "hidden (N)", "range", "cont. (N)", "cont. (%)"});
  for (const ForceTableRow& row : table) {
    rows.Add({row.profile.name, Figure(row.profile.peak_force_N), Figure(row.scale), Figure(row.largest_N),
              Figure(row.masked_N), Figure(row.range), Figure(row.lasting_N), Figure(100 * row.lasting_fraction)});
  }
  if (options.markdown) {
    fmt::print("{}", rows.FormatMarkdown());
    return;
  }
  fmt::print(
      "A simulated force of {:g} N is scaled to each device's peak; all columns but the peak are in simulated "
      "newtons.\n\n{}",
      options.peak_N, rows.FormatTerminal());
  fmt::print(
      "\nscale     force on the device for 1 N in the simulation: peak / {:g}, at most 1\nhidden    the device's "
      "friction masks smaller forces: friction / scale\nrange     largest / hidden\ncont.     continuous, without "
      "overheating the motors: continuous force / scale, and in % of the largest\n-         unknown or absent\n",
      options.peak_N);
}

void Run(const DevicesArguments& options) {
  if (options.udev_rules) {
    fmt::print("{}", MakeUdevRules());
  } else if (options.profiles) {
    PrintProfiles(options);
  } else {
    LibusbBus bus;
    const std::vector<FoundDevice> devices = FindDevices(bus);
    if (options.json) {
      PrintFoundJson(devices);
    } else {
      PrintFound(devices);
    }
  }
}

}  // namespace

void AddDevicesCommand(CLI::App& app) {
  const auto options = std::make_shared<DevicesArguments>();
  CLI::App* command = app.add_subcommand(
      "devices",
      "List the connected haptic devices; if one can't be opened, show why and how to correct it; nothing is moved");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  CLI::Option* rules =
      command->add_flag("--udev-rules", options->udev_rules,
                        "Print udev rules that give users access to the devices, and how to install them");
  CLI::Option* profiles = command->add_flag("--profiles", options->profiles,
                                            "Show how each supported device renders the simulated force: its scale, "
                                            "the forces that friction masks, the continuous force");
  AddNumberOption(*command, "--peak", options->peak_N, "peak_N", kExpectedPeakRange_N, "largest simulated force")
      ->needs(profiles)
      ->capture_default_str();
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/devices.md")
      ->needs(profiles)
      ->excludes(json);
  rules->excludes(json)->excludes(profiles);
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
