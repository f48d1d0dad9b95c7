// The JSON of Haply's Inverse Service: what it tells of an Inverse3 and a Verse Grip, and the force sent back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "kerf/geometry.h"

namespace kerf {

/// The service's own axes H: x to the right, y away from the user, z up (assumed); metres become mm.
struct HaplyState {
  std::string id;                // of the Inverse3
  Vec3 p_H_mm{0};                // of its cursor
  std::optional<Quat> R_H_grip;  // of a Verse Grip, where one is connected
  std::uint32_t buttons = 0;     // of the grip: bits 0, 1 and 2 are a, b and c
};

enum class HaplyReading : std::uint8_t {
  kOk,
  kNoDevice,  // a whole message, in which no Inverse3 (or not the one asked for) tells its position
  kBad,       // no JSON, or not of that form, or a number that can't be
};

/// Reads a message. `wanted_id`: of the device; "" takes the first. `state` changes with kOk only. Asks for memory.
HaplyReading ReadHaplyMessage(std::string_view text, const std::string& wanted_id, HaplyState& state);

/// The message that sets the force, N. `id` as it came.
std::string WriteHaplyForce(const std::string& id, const Vec3& f_H_N);

/// From the service's axes to frame D and back.
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
