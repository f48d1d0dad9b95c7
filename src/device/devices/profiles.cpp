#include "device/devices/profiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/core/csv.h"
#include "base/core/nearest_name.h"
#include "device_profiles_csv.h"
#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf {
namespace {

struct Figure {
  const char* name;
  double DeviceProfile::*member;
  Range range;
  bool needed;  // `none` and `unknown` are not permitted
};

constexpr std::array<Figure, 13> kFigures{{
    {"peak_force_N", &DeviceProfile::peak_force_N, {0.01, 1e4}, true},
    {"continuous_force_N", &DeviceProfile::continuous_force_N, {0.01, 1e4}, false},
    {"peak_torque_Nmm", &DeviceProfile::peak_torque_Nmm, {0.1, 1e7}, false},
    {"continuous_torque_Nmm", &DeviceProfile::continuous_torque_Nmm, {0.1, 1e7}, false},
    {"max_stiffness_N_per_mm", &DeviceProfile::max_stiffness_N_per_mm, {1e-3, 1e4}, true},
    {"max_damping_Ns_per_mm", &DeviceProfile::max_damping_Ns_per_mm, {1e-5, 10}, true},
    {"max_torsion_Nmm_per_rad", &DeviceProfile::max_torsion_Nmm_per_rad, {0.1, 1e8}, false},
    {"max_torsion_damping_Nmms", &DeviceProfile::max_torsion_damping_Nmms, {1e-3, 1e6}, false},
    {"resolution_mm", &DeviceProfile::resolution_mm, {1e-7, 1}, true},
    {"workspace_radius_mm", &DeviceProfile::workspace_radius_mm, {1, 1e4}, true},
    {"friction_N", &DeviceProfile::friction_N, {1e-4, 100}, false},
    {"mass_kg", &DeviceProfile::mass_kg, {1e-3, 100}, true},
    {"own_damping_Ns_per_mm", &DeviceProfile::own_damping_Ns_per_mm, {1e-7, 1}, false},
}};
constexpr std::size_t kFirstFigure = 2;  // column of the first value, after name and degrees of freedom
constexpr std::size_t kMaxProfiles = 1000;
constexpr std::size_t kMaxName = 40;

std::vector<std::string> MakeColumns() {
  std::vector<std::string> columns = {"name", "degrees_of_freedom"};
  for (const Figure& figure : kFigures) columns.emplace_back(figure.name);
  columns.emplace_back("source");
  return columns;
}

/// Returns the value and its reliability letter, which is ' ' if there is none.
std::pair<double, char> ParseFigure(const Figure& figure, std::string_view text, const CsvPlace& place) {
  if (text == "none" || text == "unknown") {
    if (figure.needed) place.Fail(fmt::format("{} = {} is not accepted; give a number", figure.name, text));
    return {0, ' '};
  }
  const std::size_t blank = text.find(' ');
  const std::string_view tag = blank == std::string_view::npos ? std::string_view{} : Trim(text.substr(blank));
  if (tag != "S" && tag != "R" && tag != "A") {
    place.Fail(
        fmt::format("{} = {} must end with its reliability: S (read in the source), R (recalled, unverified) or A "
                    "(assumed), such as \"3.3 S\"; or be none or unknown",
                    figure.name, Quote(text)));
  }
  const double value = ParseCsvNumber(text.substr(0, blank), 0, figure.name, place);
  if (const std::string fault = FindRangeFault(value, figure.range, UnitOfKey(figure.name)); !fault.empty()) {
    place.Fail(fmt::format("{} = {} {}", figure.name, value, fault));
  }
  return {value, tag.front()};
}

DeviceProfile ParseRow(const std::vector<std::string>& fields, const CsvPlace& place) {
  DeviceProfile profile;
  profile.name = fields[0];
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (profile.name.empty() || profile.name.size() > kMaxName ||
      !std::all_of(profile.name.begin(), profile.name.end(), plain)) {
    place.Fail(fmt::format("name = {} must consist of 1 to {} lower-case letters, digits and _", Quote(profile.name),
                           kMaxName));
  }
  if (fields[1] != "3" && fields[1] != "6") {
    place.Fail(fmt::format("degrees_of_freedom = {} must be 3 or 6", Quote(fields[1])));
  }
  profile.degrees_of_freedom = fields[1] == "3" ? 3 : 6;
  std::vector<std::string> recalled;
  std::vector<std::string> assumed;
  for (std::size_t i = 0; i < kFigures.size(); ++i) {
    const auto [value, tag] = ParseFigure(kFigures[i], fields[kFirstFigure + i], place);
    profile.*kFigures[i].member = value;
    if (tag == 'R') recalled.emplace_back(kFigures[i].name);
    if (tag == 'A') assumed.emplace_back(kFigures[i].name);
  }
  const auto check_order = [&](double continuous, double peak, const char* what) {
    if (continuous > peak) {
      place.Fail(fmt::format("{}: the continuous {} {} is above the peak {}", profile.name, what, continuous, peak));
    }
  };
  check_order(profile.continuous_force_N, profile.peak_force_N, "force");
  check_order(profile.continuous_torque_Nmm, profile.peak_torque_Nmm, "torque");
  if (profile.degrees_of_freedom == 3 && profile.peak_torque_Nmm > 0) {
    place.Fail(fmt::format("{}: a device with 3 degrees of freedom has no torque; write none", profile.name));
  }
  profile.source = fields.back();
  if (profile.source.empty()) place.Fail("source is empty; state where the values come from");
  if (!recalled.empty()) profile.source += fmt::format("; recalled, not verified: {}", fmt::join(recalled, ", "));
  if (!assumed.empty()) profile.source += fmt::format("; assumed: {}", fmt::join(assumed, ", "));
  return profile;
}

}  // namespace

std::vector<DeviceProfile> ParseDeviceProfiles(const std::string& text, const std::string& file) {
  std::vector<DeviceProfile> profiles;
  ReadCsv(text, file, MakeColumns(), [&profiles](const std::vector<std::string>& fields, const CsvPlace& place) {
    if (profiles.size() == kMaxProfiles) place.Fail(fmt::format("more than {} devices", kMaxProfiles));
    DeviceProfile profile = ParseRow(fields, place);
    for (const DeviceProfile& other : profiles) {
      if (other.name == profile.name) place.Fail(fmt::format("device \"{}\" is given twice", profile.name));
    }
    profiles.push_back(std::move(profile));
  });
  if (profiles.empty()) throw Error(fmt::format("{}: no device below the header", file));
  return profiles;
}

const std::vector<DeviceProfile>& DeviceProfiles() {
  static const std::vector<DeviceProfile> profiles =
      ParseDeviceProfiles(kDeviceProfilesCsv, "device_profiles.csv (built in)");
  return profiles;
}

const DeviceProfile& FindDeviceProfile(const std::vector<DeviceProfile>& profiles, const std::string& name) {
  std::vector<std::string> names;
  for (const DeviceProfile& profile : profiles) {
    if (profile.name == name) return profile;
    names.push_back(profile.name);
  }
  const std::string nearest = FindNearestName(name, names);
  throw Error(fmt::format("device {} is unknown; {}", Quote(name),
                          nearest.empty() ? fmt::format("the devices are {}", fmt::join(names, ", "))
                                          : fmt::format("the nearest is \"{}\"", nearest)));
}

const DeviceProfile& FindDeviceProfile(const std::string& name) {
  return FindDeviceProfile(DeviceProfiles(), name);
}

}  // namespace kerf
