// The packets between kerf and a bridge: a program of the user's that speaks to a device by its maker's library. 128
// bytes each way, little-endian, with a check sum; docs/bridge.md has them byte by byte, tools/bridge a client in C.
//
// Frame D (devices/driver.h); mm, N, N mm, s unless named.
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
  kDescription = 2,  // from it: what the device can do
  kCommand = 3,      // to it
  kState = 4,        // from it, one for each command
  kRefusal = 5,      // from it, in place of any answer
  kBye = 6,          // to it: ends the session, no force
};

struct BridgeHeader {
  std::uint16_t version = kBridgeVersion;
  BridgeKind kind = BridgeKind::kHello;
  std::uint32_t session = 0;    // chosen by kerf, other each time
  std::uint32_t sequence = 0;   // goes up by one with each packet of the sender; goes round
  std::uint64_t time_ns = 0;    // by the sender's own clock, which only goes forward
  std::uint32_t answer_to = 0;  // sequence of the packet that this one answers; 0 to the bridge
};

struct BridgeCommand {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  Vec3 p_D_mm{0};                 // where f_D_N was worked out
  double stiffness_N_per_mm = 0;  // along f_D_N, 0 or more
  double damping_Ns_per_mm = 0;   // 0 or more
  std::uint32_t valid_ms = 50;    // after its coming; then the far side goes to zero by itself. 1 to 1000
  bool engaged = false;
};

struct BridgeState {
  Pose X_DH;
  std::uint32_t buttons = 0;
  Vec3 made_f_D_N{0};  // the force that the far side makes now
  bool homed = false;
  bool ready = false;  // motors on: it would make a force
};

/// Figures of 0 are not known, but for peak_force_N: 0 is a device that makes none.
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
  double rate_hz = 0;  // of the far side's servo loop
  int driven = 3;      // degrees of freedom with motors: 0, 3 or 6
  bool senses_orientation = false;
  bool homes = false;  // its handle has to be moved in some way first
  int buttons = 0;     // 0 to 32
};

enum class BridgeReason : std::uint32_t {
  kVersion = 1,    // the bridge speaks another one
  kBusy = 2,       // with another client
  kNoDevice = 3,   // the maker's library doesn't find it
  kNoSession = 4,  // a command without a hello before: the bridge was started anew
};

struct BridgeRefusal {
  BridgeReason reason = BridgeReason::kNoDevice;
  std::uint16_t version = 0;  // that the bridge speaks
  std::string text;           // up to 79 printable ASCII characters, for the user
};

/// CRC-32 of ISO-HDLC, as zip, PNG and Ethernet have it: polynomial 0xedb88320 reflected, start and end inverted.
std::uint32_t CalcCrc32(std::span<const std::uint8_t> bytes);

BridgeBytes WriteBridgeHello(const BridgeHeader& header);
BridgeBytes WriteBridgeBye(const BridgeHeader& header);
BridgeBytes WriteBridgeCommand(const BridgeHeader& header, const BridgeCommand& command);
BridgeBytes WriteBridgeState(const BridgeHeader& header, const BridgeState& state);
BridgeBytes WriteBridgeDescription(const BridgeHeader& header, const BridgeDescription& description);
BridgeBytes WriteBridgeRefusal(const BridgeHeader& header, const BridgeRefusal& refusal);

/// Length, magic and check sum are right and the kind is known; another version passes, for the reader to say so. Like
/// the readers below it reads any bytes, and never throws.
std::optional<BridgeHeader> ReadBridgeHeader(std::span<const std::uint8_t> bytes) noexcept;
/// Each looks at the header too: None when that is not whole, of another version or kind, or when a figure is not
/// finite or out of its range, a quaternion not of unit length (to 1e-3; it is made so).
std::optional<BridgeCommand> ReadBridgeCommand(std::span<const std::uint8_t> bytes) noexcept;
std::optional<BridgeState> ReadBridgeState(std::span<const std::uint8_t> bytes) noexcept;
/// Asks for memory.
std::optional<BridgeDescription> ReadBridgeDescription(std::span<const std::uint8_t> bytes);
std::optional<BridgeRefusal> ReadBridgeRefusal(std::span<const std::uint8_t> bytes);

/// Whether `sequence` comes after `last`, going round.
constexpr bool IsAfter(std::uint32_t sequence, std::uint32_t last) {
  return static_cast<std::int32_t>(sequence - last) > 0;
}

/// What the far side is to make of a command at x_D_mm and v_D_mm_per_s: f_D_N less the stiffness along it, never the
/// other way; less the damping in all directions; and not above the peak (0: none). N.
Vec3 CalcFieldForce(const BridgeCommand& command, const Vec3& x_D_mm, const Vec3& v_D_mm_per_s, double peak_force_N);

}  // namespace kerf
