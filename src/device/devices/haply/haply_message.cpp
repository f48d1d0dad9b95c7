#include "device/devices/haply/haply_message.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxIdBytes = 100;
constexpr double kMaxPosition_m = 10;  // a larger value cannot be the position of a hand

/// Returns a member of an object, or nullptr if it does not exist.
const Json* Find(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

std::optional<double> FindNumber(const Json& object, const char* key) {
  const Json* number = Find(object, key);
  if (number == nullptr || !number->is_number()) return std::nullopt;
  const auto value = number->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<Vec3> FindPosition(const Json& device) {
  const Json* state = Find(device, "state");
  const Json* position = state == nullptr ? nullptr : Find(*state, "cursor_position");
  if (position == nullptr) return std::nullopt;
  const auto x = FindNumber(*position, "x");
  const auto y = FindNumber(*position, "y");
  const auto z = FindNumber(*position, "z");
  return x && y && z ? std::optional(Vec3(*x, *y, *z)) : std::nullopt;
}

/// Reads the first grip of a list. Returns false if it is invalid.
bool ReadGrip(const Json& grips, HaplyState& read) {
  if (!grips.is_array()) return false;
  if (grips.empty()) return true;
  const Json* state = Find(grips[0], "state");
  if (state == nullptr) return true;
  if (const Json* turn = Find(*state, "orientation")) {
    std::array<double, 4> wxyz{};
    std::size_t i = 0;
    for (const char* key : {"w", "x", "y", "z"}) {
      const auto number = FindNumber(*turn, key);
      if (!number) return false;
      wxyz[i++] = *number;
    }
    const double length = std::sqrt(wxyz[0] * wxyz[0] + wxyz[1] * wxyz[1] + wxyz[2] * wxyz[2] + wxyz[3] * wxyz[3]);
    if (!(std::abs(length - 1) <= 0.01)) return false;
    read.R_H_grip = Quat(wxyz[0] / length, wxyz[1] / length, wxyz[2] / length, wxyz[3] / length);
  }
  if (const Json* buttons = Find(*state, "buttons")) {
    int bit = 0;
    for (const char* key : {"a", "b", "c"}) {
      const Json* pressed = Find(*buttons, key);
      if (pressed != nullptr && !pressed->is_boolean()) return false;
      if (pressed != nullptr && pressed->get<bool>()) read.buttons |= 1u << bit;
      ++bit;
    }
  }
  return true;
}

}  // namespace

HaplyReading ReadHaplyMessage(std::string_view text, const std::string& wanted_id, HaplyState& state) {
  const Json message = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return HaplyReading::kBad;
  const Json* devices = Find(message, "inverse3");
  if (devices == nullptr) return HaplyReading::kNoDevice;
  if (!devices->is_array()) return HaplyReading::kBad;
  for (const Json& device : *devices) {
    const Json* id = Find(device, "device_id");
    if (id == nullptr || !id->is_string()) return HaplyReading::kBad;
    const auto& name = id->get_ref<const std::string&>();
    if (name.empty() || name.size() > kMaxIdBytes) return HaplyReading::kBad;
    if (!wanted_id.empty() && name != wanted_id) continue;
    if (Find(device, "state") == nullptr) continue;
    const std::optional<Vec3> position = FindPosition(device);
    if (!position) return HaplyReading::kBad;
    HaplyState read;
    read.id = name;
    read.p_H_mm = 1000.0 * *position;
    for (int i = 0; i < 3; ++i) {
      if (std::abs((*position)[i]) > kMaxPosition_m) return HaplyReading::kBad;
    }
    for (const char* key : {"wireless_verse_grip", "verse_grip"}) {
      const Json* grips = Find(message, key);
      if (grips != nullptr && !read.R_H_grip && !ReadGrip(*grips, read)) return HaplyReading::kBad;
    }
    state = read;
    return HaplyReading::kOk;
  }
  return HaplyReading::kNoDevice;
}

std::string WriteHaplyForce(const std::string& id, const Vec3& f_H_N) {
  Json device;
  device["device_id"] = id;
  device["commands"]["set_cursor_force"]["values"] = {{"x", f_H_N.x}, {"y", f_H_N.y}, {"z", f_H_N.z}};
  Json message;
  message["inverse3"] = Json::array({device});
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace kerf
