// JSON messages of Haply's Inverse Service: states of an Inverse3 and a Verse Grip, and the force that is sent to it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "kerf/geometry.h"

namespace kerf {

/// State in the service's axes H: x to the right, y away from the user, z up (assumed). Positions are converted from
/// metres to mm.
struct HaplyState {
  std::string id;                // id of the Inverse3
  Vec3 p_H_mm{0};                // position of its cursor
  std::optional<Quat> R_H_grip;  // orientation of a Verse Grip, if one is connected
  std::uint32_t buttons = 0;     // buttons of the grip: bits 0, 1 and 2 are a, b and c
};

enum class HaplyReading : std::uint8_t {
  kOk,
  kNoDevice,  // a valid message without the position of an Inverse3, or of the one requested
  kBad,       // not JSON, not in the expected form, or with an impossible number
};

/// Reads a message. `wanted_id` selects the device; "" selects the first. `state` changes only if the result is kOk.
/// Allocates.
HaplyReading ReadHaplyMessage(std::string_view text, const std::string& wanted_id, HaplyState& state);

/// Returns the message that sets the force of a device, N. `id`: the device's id, as read from a message.
std::string WriteHaplyForce(const std::string& id, const Vec3& f_H_N);

/// These functions convert from the service's axes to frame D and back.
inline Vec3 HaplyToFrameD(const Vec3& v_H) {
  return {v_H.x, v_H.z, -v_H.y};
}
inline Vec3 FrameDToHaply(const Vec3& v_D) {
  return {v_D.x, -v_D.z, v_D.y};
}
inline Quat HaplyToFrameD(const Quat& R_H) {
  return {R_H.w, R_H.x, R_H.z, -R_H.y};
}

}  // namespace kerf
