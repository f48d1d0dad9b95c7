// Packets between kerf and a bridge: a user-supplied program that accesses a device through its maker's library.
// Packets are 128 bytes long in both directions, little-endian, and protected by a checksum. docs/bridge.md defines
// every byte; tools/bridge is a client in C.
//
// Vectors are in frame D (devices/driver.h). Units are mm, N, N mm and s, unless a name says otherwise.
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
  kBye = 6,          // to the bridge: ends the session and sets the force to zero
};

struct BridgeHeader {
  std::uint16_t version = kBridgeVersion;
  BridgeKind kind = BridgeKind::kHello;
  std::uint32_t session = 0;    // chosen by kerf, different for each session
  std::uint32_t sequence = 0;   // increases by one with each packet of the sender; wraps around
  std::uint64_t time_ns = 0;    // sending time on the sender's monotonic clock
  std::uint32_t answer_to = 0;  // sequence number of the packet that this one answers; 0 in packets to the bridge
};

struct BridgeCommand {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  Vec3 p_D_mm{0};                 // position for which f_D_N was computed
  double stiffness_N_per_mm = 0;  // along f_D_N, 0 or more
  double damping_Ns_per_mm = 0;   // 0 or more
  std::uint32_t valid_ms = 50;    // time from the command's arrival until the bridge sets the force to zero, 1 to 1000
  bool engaged = false;
};

struct BridgeState {
  Pose X_DH;
  std::uint32_t buttons = 0;
  Vec3 actual_f_D_N{0};  // current force of the device
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
  double rate_hz = 0;  // rate of the bridge's servo loop
  int driven = 3;      // degrees of freedom with motors: 0, 3 or 6
  bool senses_orientation = false;
  bool homes = false;  // the handle must first be moved as the maker specifies
  int buttons = 0;     // 0 to 32
};

enum class BridgeReason : std::uint32_t {
  kVersion = 1,    // the bridge has a different version
  kBusy = 2,       // the bridge serves another client
  kNoDevice = 3,   // the maker's library did not find the device
  kNoSession = 4,  // the bridge received a command without a hello, because it was restarted
};

struct BridgeRefusal {
  BridgeReason reason = BridgeReason::kNoDevice;
  std::uint16_t version = 0;  // version that the bridge uses
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

/// Returns the header if the length, the magic number and the checksum are valid and the kind is known. Packets of
/// other versions are accepted too, so that the caller can report them. Like the readers below, it can be given any
/// bytes.
std::optional<BridgeHeader> ReadBridgeHeader(std::span<const std::uint8_t> bytes) noexcept;
/// These functions also check the header and normalise quaternions. They return nullopt if the header is invalid or of
/// another kind or version (a refusal may have any version), if a value is not finite or is out of range, or if the
/// length of a quaternion differs from 1 by more than 1e-3.
std::optional<BridgeCommand> ReadBridgeCommand(std::span<const std::uint8_t> bytes) noexcept;
std::optional<BridgeState> ReadBridgeState(std::span<const std::uint8_t> bytes) noexcept;
/// The following two functions allocate.
std::optional<BridgeDescription> ReadBridgeDescription(std::span<const std::uint8_t> bytes);
std::optional<BridgeRefusal> ReadBridgeRefusal(std::span<const std::uint8_t> bytes);

/// Returns true if `sequence` comes after `last`. Sequence numbers may wrap around.
constexpr bool IsAfter(std::uint32_t sequence, std::uint32_t last) {
  return static_cast<std::int32_t>(sequence - last) > 0;
}

/// Computes the force that the bridge must output for a command when the handle is at x_D_mm and moves at v_D_mm_per_s,
/// N. It is f_D_N, minus the stiffness term along f_D_N (which never reverses the force), minus the damping term in all
/// directions, limited to the peak force (0: not limited).
Vec3 CalcFieldForce(const BridgeCommand& command, const Vec3& x_D_mm, const Vec3& v_D_mm_per_s, double peak_force_N);

}  // namespace kerf
