// Packets between kerf and a bridge: a user-supplied program that accesses a device through its maker's library.
// Packets have 128 bytes in both directions, are little-endian and have a checksum. docs/bridge.md defines every byte;
// tools/bridge is a client in C.
//
// Frame D (devices/driver.h). Units: mm, N, N mm, s unless named.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "kerf/geometry.h"

namespace kerf {

inline constexpr std::size_t kBridgeBytes = 128;
inline constexpr std::uint16_t kBridgeVersion = 1;
inline constexpr std::uint16_t kBridgePort = 47810;
using BridgeBytes = std::array<std::uint8_t, kBridgeBytes>;

enum class BridgeKind : std::uint16_t {
  kHello = 1,        // to the bridge: begins a session
  kDescription = 2,  // from the bridge: capabilities of the device
  kCommand = 3,      // to the bridge
  kState = 4,        // from the bridge, one per command
  kRefusal = 5,      // from the bridge, instead of another answer
  kBye = 6,          // to the bridge: ends the session, zero force
};

struct BridgeHeader {
  std::uint16_t version = kBridgeVersion;
  BridgeKind kind = BridgeKind::kHello;
  std::uint32_t session = 0;    // chosen by kerf, different each time
  std::uint32_t sequence = 0;   // increases by one with each packet of the sender; wraps around
  std::uint64_t time_ns = 0;    // on the sender's clock, which is monotonic
  std::uint32_t answer_to = 0;  // sequence number of the packet that this one answers; 0 in packets to the bridge
};

struct BridgeCommand {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  Vec3 p_D_mm{0};                 // position for which f_D_N was computed
  double stiffness_N_per_mm = 0;  // along f_D_N, 0 or more
  double damping_Ns_per_mm = 0;   // 0 or more
  std::uint32_t valid_ms = 50;    // time after its arrival at which the bridge sets the force to zero, 1 to 1000
  bool engaged = false;
};

struct BridgeState {
  Pose X_DH;
  std::uint32_t buttons = 0;
  Vec3 made_f_D_N{0};  // current force of the device
  bool homed = false;
  bool ready = false;  // motors on: the device can output force
};

/// A value of 0 means unknown, except that peak_force_N = 0 means a device without force.
struct BridgeDescription {
  std::string name;  // 1 to 31 printable ASCII characters
  double peak_force_N = 0;
  double continuous_force_N = 0;
  double peak_torque_Nmm = 0;
  double continuous_torque_Nmm = 0;
  double max_stiffness_N_per_mm = 0;
  double max_damping_Ns_per_mm = 0;
  double workspace_radius_mm = 0;
  double resolution_mm = 0;
  double rate_hz = 0;  // of the bridge's servo loop
  int driven = 3;      // degrees of freedom with motors: 0, 3 or 6
  bool senses_orientation = false;
  bool homes = false;  // the handle must first be moved as the maker specifies
  int buttons = 0;     // 0 to 32
};

enum class BridgeReason : std::uint32_t {
  kVersion = 1,    // the bridge has a different version
  kBusy = 2,       // the bridge serves another client
  kNoDevice = 3,   // the maker's library does not find the device
  kNoSession = 4,  // a command without a hello: the bridge was restarted
};

struct BridgeRefusal {
  BridgeReason reason = BridgeReason::kNoDevice;
  std::uint16_t version = 0;  // version of the bridge
  std::string text;           // up to 79 printable ASCII characters, for the user
};

/// Computes the ISO-HDLC CRC-32, as in zip, PNG and Ethernet: polynomial 0xedb88320 reflected, initial and final value
/// inverted.
std::uint32_t CalcCrc32(std::span<const std::uint8_t> bytes);

BridgeBytes WriteBridgeHello(const BridgeHeader& header);
BridgeBytes WriteBridgeBye(const BridgeHeader& header);
BridgeBytes WriteBridgeCommand(const BridgeHeader& header, const BridgeCommand& command);
BridgeBytes WriteBridgeState(const BridgeHeader& header, const BridgeState& state);
BridgeBytes WriteBridgeDescription(const BridgeHeader& header, const BridgeDescription& description);
BridgeBytes WriteBridgeRefusal(const BridgeHeader& header, const BridgeRefusal& refusal);

/// Returns the header if length, magic number and checksum are valid and the kind is known. Accepts other versions, so
/// that the caller can report them. Like the readers below, it accepts any bytes and never throws.
std::optional<BridgeHeader> ReadBridgeHeader(std::span<const std::uint8_t> bytes) noexcept;
/// Each of these functions also reads the header, and normalises quaternions. Returns nullopt if the header is invalid
/// or of another version or kind, if a value is not finite or is out of range, or if the length of a quaternion differs
/// from 1 by more than 1e-3.
std::optional<BridgeCommand> ReadBridgeCommand(std::span<const std::uint8_t> bytes) noexcept;
std::optional<BridgeState> ReadBridgeState(std::span<const std::uint8_t> bytes) noexcept;
/// Allocates.
std::optional<BridgeDescription> ReadBridgeDescription(std::span<const std::uint8_t> bytes);
std::optional<BridgeRefusal> ReadBridgeRefusal(std::span<const std::uint8_t> bytes);

/// Returns true if `sequence` comes after `last`, with wrap-around.
constexpr bool IsAfter(std::uint32_t sequence, std::uint32_t last) {
  return static_cast<std::int32_t>(sequence - last) > 0;
}

/// Computes the force that the bridge must output for a command at x_D_mm and v_D_mm_per_s, N: f_D_N minus the
/// stiffness term along it, never reversed, minus the damping term in all directions, limited to the peak (0: no
/// force).
Vec3 CalcFieldForce(const BridgeCommand& command, const Vec3& x_D_mm, const Vec3& v_D_mm_per_s, double peak_force_N);

}  // namespace kerf
