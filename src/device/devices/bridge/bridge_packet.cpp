#include "device/devices/bridge/bridge_packet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace kerf {
namespace {

// ---- Byte offsets.
constexpr std::size_t kMagicAt = 0, kVersionAt = 4, kKindAt = 6, kSessionAt = 8, kSequenceAt = 12, kTimeAt = 16,
                      kFlagsAt = 24, kAnswerToAt = 28, kCrcAt = 124;
constexpr std::size_t kForceAt = 32, kTorqueAt = 44, kAnchorAt = 56, kStiffnessAt = 68, kDampingAt = 72, kValidAt = 76;
constexpr std::size_t kPositionAt = 32, kOrientationAt = 44, kButtonsAt = 60, kActualForceAt = 64;
constexpr std::size_t kNameAt = 32, kNameBytes = 32, kFiguresAt = 64, kDrivenAt = 100;
constexpr std::size_t kReasonAt = 32, kUsedVersionAt = 36, kTextAt = 40, kTextBytes = 80;

constexpr std::uint32_t kMagic = 0x4752424b;  // "KBRG"
constexpr std::uint32_t kEngaged = 1;
constexpr std::uint32_t kHomed = 1, kReady = 2;
constexpr std::uint32_t kMaxValid_ms = 1000;
constexpr double kMaxFigure = 1e6;

constexpr std::array<std::uint32_t, 256> MakeCrcTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0);
    table[i] = crc;
  }
  return table;
}

template <typename T>
T Get(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{bytes[at + i]} << (8 * i);
  return static_cast<T>(value);
}

template <typename T>
void Put(std::span<std::uint8_t> bytes, std::size_t at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

double GetReal(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<double>(std::bit_cast<float>(Get<std::uint32_t>(bytes, at)));
}

void PutReal(std::span<std::uint8_t> bytes, std::size_t at, double value) {
  Put(bytes, at, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

Vec3 GetVec3(std::span<const std::uint8_t> bytes, std::size_t at) {
  return {GetReal(bytes, at), GetReal(bytes, at + 4), GetReal(bytes, at + 8)};
}

void PutVec3(std::span<std::uint8_t> bytes, std::size_t at, const Vec3& v) {
  for (int i = 0; i < 3; ++i) PutReal(bytes, at + 4 * static_cast<std::size_t>(i), v[i]);
}

bool IsFigure(double x) {
  return std::isfinite(x) && std::abs(x) <= kMaxFigure;
}
bool IsFigure(const Vec3& v) {
  return IsFigure(v.x) && IsFigure(v.y) && IsFigure(v.z);
}
bool IsPositiveOrZero(double x) {
  return IsFigure(x) && x >= 0;
}

bool IsPrintable(char c) {
  return c >= 0x20 && c < 0x7f;
}

/// Truncates the text to the size of the field minus one, and replaces non-printable characters by '?'.
void PutText(std::span<std::uint8_t> place, const std::string& text) {
  for (std::size_t i = 0; i < text.size() && i + 1 < place.size(); ++i) {
    place[i] = static_cast<std::uint8_t>(IsPrintable(text[i]) ? text[i] : '?');
  }
}

/// Returns nullopt if the text is not terminated or contains non-printable characters.
std::optional<std::string> GetText(std::span<const std::uint8_t> place) {
  std::string text;
  for (const std::uint8_t byte : place) {
    if (byte == 0) return text;
    if (!IsPrintable(static_cast<char>(byte))) return std::nullopt;
    text += static_cast<char>(byte);
  }
  return std::nullopt;
}

BridgeBytes Begin(const BridgeHeader& header, BridgeKind kind, std::uint32_t flags = 0) {
  BridgeBytes bytes{};
  Put(bytes, kMagicAt, kMagic);
  Put(bytes, kVersionAt, header.version);
  Put(bytes, kKindAt, static_cast<std::uint16_t>(kind));
  Put(bytes, kSessionAt, header.session);
  Put(bytes, kSequenceAt, header.sequence);
  Put(bytes, kTimeAt, header.time_ns);
  Put(bytes, kFlagsAt, flags);
  Put(bytes, kAnswerToAt, header.answer_to);
  return bytes;
}

BridgeBytes& End(BridgeBytes& bytes) {
  Put(bytes, kCrcAt, CalcCrc32(std::span(bytes).first(kCrcAt)));
  return bytes;
}

bool IsWhole(std::span<const std::uint8_t> bytes, BridgeKind kind) noexcept {
  const std::optional<BridgeHeader> header = ReadBridgeHeader(bytes);
  return header && header->version == kBridgeVersion && header->kind == kind;
}

}  // namespace

std::uint32_t CalcCrc32(std::span<const std::uint8_t> bytes) {
  static constexpr std::array<std::uint32_t, 256> kTable = MakeCrcTable();
  std::uint32_t crc = 0xffffffff;
  for (const std::uint8_t byte : bytes) crc = crc >> 8 ^ kTable[(crc ^ byte) & 0xff];
  return ~crc;
}

BridgeBytes WriteBridgeHello(const BridgeHeader& header) {
  BridgeBytes bytes = Begin(header, BridgeKind::kHello);
  return End(bytes);
}

BridgeBytes WriteBridgeBye(const BridgeHeader& header) {
  BridgeBytes bytes = Begin(header, BridgeKind::kBye);
  return End(bytes);
}

BridgeBytes WriteBridgeCommand(const BridgeHeader& header, const BridgeCommand& command) {
  BridgeBytes bytes = Begin(header, BridgeKind::kCommand, command.engaged ? kEngaged : 0);
  PutVec3(bytes, kForceAt, command.f_D_N);
  PutVec3(bytes, kTorqueAt, command.tau_D_Nmm);
  PutVec3(bytes, kAnchorAt, command.p_D_mm);
  PutReal(bytes, kStiffnessAt, command.stiffness_N_per_mm);
  PutReal(bytes, kDampingAt, command.damping_Ns_per_mm);
  Put(bytes, kValidAt, command.valid_ms);
  return End(bytes);
}

BridgeBytes WriteBridgeState(const BridgeHeader& header, const BridgeState& state) {
  BridgeBytes bytes = Begin(header, BridgeKind::kState, (state.homed ? kHomed : 0) | (state.ready ? kReady : 0));
  PutVec3(bytes, kPositionAt, state.X_DH.p_AB);
  const Quat& q = state.X_DH.R_AB;
  PutReal(bytes, kOrientationAt, q.w);
  PutVec3(bytes, kOrientationAt + 4, {q.x, q.y, q.z});
  Put(bytes, kButtonsAt, state.buttons);
  PutVec3(bytes, kActualForceAt, state.actual_f_D_N);
  return End(bytes);
}

BridgeBytes WriteBridgeDescription(const BridgeHeader& header, const BridgeDescription& description) {
  BridgeBytes bytes = Begin(header, BridgeKind::kDescription);
  PutText(std::span(bytes).subspan(kNameAt, kNameBytes), description.name);
  std::size_t at = kFiguresAt;
  for (const double figure :
       {description.peak_force_N, description.continuous_force_N, description.peak_torque_Nmm,
        description.continuous_torque_Nmm, description.max_stiffness_N_per_mm, description.max_damping_Ns_per_mm,
        description.workspace_radius_mm, description.resolution_mm, description.rate_hz}) {
    PutReal(bytes, at, figure);
    at += 4;
  }
  bytes[kDrivenAt] = static_cast<std::uint8_t>(description.driven);
  bytes[kDrivenAt + 1] = description.senses_orientation ? 1 : 0;
  bytes[kDrivenAt + 2] = description.homes ? 1 : 0;
  bytes[kDrivenAt + 3] = static_cast<std::uint8_t>(description.buttons);
  return End(bytes);
}

BridgeBytes WriteBridgeRefusal(const BridgeHeader& header, const BridgeRefusal& refusal) {
  BridgeBytes bytes = Begin(header, BridgeKind::kRefusal);
  Put(bytes, kReasonAt, static_cast<std::uint32_t>(refusal.reason));
  Put(bytes, kUsedVersionAt, std::uint32_t{refusal.version});
  PutText(std::span(bytes).subspan(kTextAt, kTextBytes), refusal.text);
  return End(bytes);
}

std::optional<BridgeHeader> ReadBridgeHeader(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() != kBridgeBytes || Get<std::uint32_t>(bytes, kMagicAt) != kMagic ||
      Get<std::uint32_t>(bytes, kCrcAt) != CalcCrc32(bytes.first(kCrcAt))) {
    return std::nullopt;
  }
  const auto kind = Get<std::uint16_t>(bytes, kKindAt);
  if (kind < static_cast<std::uint16_t>(BridgeKind::kHello) || kind > static_cast<std::uint16_t>(BridgeKind::kBye)) {
    return std::nullopt;
  }
  BridgeHeader header;
  header.version = Get<std::uint16_t>(bytes, kVersionAt);
  header.kind = static_cast<BridgeKind>(kind);
  header.session = Get<std::uint32_t>(bytes, kSessionAt);
  header.sequence = Get<std::uint32_t>(bytes, kSequenceAt);
  header.time_ns = Get<std::uint64_t>(bytes, kTimeAt);
  header.answer_to = Get<std::uint32_t>(bytes, kAnswerToAt);
  return header;
}

std::optional<BridgeCommand> ReadBridgeCommand(std::span<const std::uint8_t> bytes) noexcept {
  if (!IsWhole(bytes, BridgeKind::kCommand)) return std::nullopt;
  BridgeCommand command;
  command.f_D_N = GetVec3(bytes, kForceAt);
  command.tau_D_Nmm = GetVec3(bytes, kTorqueAt);
  command.p_D_mm = GetVec3(bytes, kAnchorAt);
  command.stiffness_N_per_mm = GetReal(bytes, kStiffnessAt);
  command.damping_Ns_per_mm = GetReal(bytes, kDampingAt);
  command.valid_ms = Get<std::uint32_t>(bytes, kValidAt);
  command.engaged = (Get<std::uint32_t>(bytes, kFlagsAt) & kEngaged) != 0;
  if (!IsFigure(command.f_D_N) || !IsFigure(command.tau_D_Nmm) || !IsFigure(command.p_D_mm) ||
      !IsPositiveOrZero(command.stiffness_N_per_mm) || !IsPositiveOrZero(command.damping_Ns_per_mm) ||
      command.valid_ms < 1 || command.valid_ms > kMaxValid_ms) {
    return std::nullopt;
  }
  return command;
}

std::optional<BridgeState> ReadBridgeState(std::span<const std::uint8_t> bytes) noexcept {
  if (!IsWhole(bytes, BridgeKind::kState)) return std::nullopt;
  BridgeState state;
  state.X_DH.p_AB = GetVec3(bytes, kPositionAt);
  const double w = GetReal(bytes, kOrientationAt);
  const Vec3 xyz = GetVec3(bytes, kOrientationAt + 4);
  state.buttons = Get<std::uint32_t>(bytes, kButtonsAt);
  state.actual_f_D_N = GetVec3(bytes, kActualForceAt);
  const auto flags = Get<std::uint32_t>(bytes, kFlagsAt);
  state.homed = (flags & kHomed) != 0;
  state.ready = (flags & kReady) != 0;
  const double length = std::sqrt(w * w + glm::dot(xyz, xyz));
  if (!IsFigure(state.X_DH.p_AB) || !IsFigure(state.actual_f_D_N) || !(std::abs(length - 1) <= 1e-3)) {
    return std::nullopt;
  }
  state.X_DH.R_AB = Quat(w / length, xyz.x / length, xyz.y / length, xyz.z / length);
  return state;
}

std::optional<BridgeDescription> ReadBridgeDescription(std::span<const std::uint8_t> bytes) {
  if (!IsWhole(bytes, BridgeKind::kDescription)) return std::nullopt;
  BridgeDescription description;
  const std::optional<std::string> name = GetText(bytes.subspan(kNameAt, kNameBytes));
  if (!name || name->empty()) return std::nullopt;
  description.name = *name;
  std::size_t at = kFiguresAt;
  for (double* figure :
       {&description.peak_force_N, &description.continuous_force_N, &description.peak_torque_Nmm,
        &description.continuous_torque_Nmm, &description.max_stiffness_N_per_mm, &description.max_damping_Ns_per_mm,
        &description.workspace_radius_mm, &description.resolution_mm, &description.rate_hz}) {
    *figure = GetReal(bytes, at);
    if (!IsPositiveOrZero(*figure)) return std::nullopt;
    at += 4;
  }
  description.driven = bytes[kDrivenAt];
  description.buttons = bytes[kDrivenAt + 3];
  if (bytes[kDrivenAt + 1] > 1 || bytes[kDrivenAt + 2] > 1 || description.buttons > 32) return std::nullopt;
  description.senses_orientation = bytes[kDrivenAt + 1] == 1;
  description.homes = bytes[kDrivenAt + 2] == 1;
  if (description.driven != 0 && description.driven != 3 && description.driven != 6) return std::nullopt;
  return description;
}

std::optional<BridgeRefusal> ReadBridgeRefusal(std::span<const std::uint8_t> bytes) {
  // Accept any version: the refusal may be about the version.
  const std::optional<BridgeHeader> header = ReadBridgeHeader(bytes);
  if (!header || header->kind != BridgeKind::kRefusal) return std::nullopt;
  const auto reason = Get<std::uint32_t>(bytes, kReasonAt);
  const auto version = Get<std::uint32_t>(bytes, kUsedVersionAt);
  const std::optional<std::string> text = GetText(bytes.subspan(kTextAt, kTextBytes));
  if (reason < 1 || reason > 4 || version > std::numeric_limits<std::uint16_t>::max() || !text) return std::nullopt;
  return BridgeRefusal{static_cast<BridgeReason>(reason), static_cast<std::uint16_t>(version), *text};
}

Vec3 CalcFieldForce(const BridgeCommand& command, const Vec3& x_D_mm, const Vec3& v_D_mm_per_s, double peak_force_N) {
  Vec3 f = -command.damping_Ns_per_mm * v_D_mm_per_s;
  const double force_N = glm::length(command.f_D_N);
  if (force_N > 0) {
    const Vec3 along = command.f_D_N / force_N;
    f += std::max(force_N - command.stiffness_N_per_mm * glm::dot(x_D_mm - command.p_D_mm, along), 0.0) * along;
  }
  const double sum_N = glm::length(f);
  if (!std::isfinite(sum_N)) return Vec3{0};
  return peak_force_N > 0 && sum_N > peak_force_N ? f * (peak_force_N / sum_N) : f;
}

}  // namespace kerf
