// Software model of a Novint Falcon: the serial port on USB, its boot loader, the firmware once it is loaded, the
// encoders, motors and legs. What is known about the real device is described in devices/falcon/*.h and docs/falcon.md.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "device/devices/falcon/falcon_kinematics.h"
#include "device/devices/falcon/falcon_packet.h"
#include "device/emulation/mechanism.h"
#include "device/emulation/usb_model.h"

namespace kerf {

struct FalconModelOptions {
  bool firmware_is_there = false;      // already loaded by another program, and the Falcon stayed powered
  std::vector<std::uint8_t> firmware;  // the only firmware that runs; empty: any of at least 1 kB
  bool homed = false;                  // homed from the start; requires firmware_is_there
  bool keeps_power = false;            // has its own power supply, so it keeps its state when unplugged from USB
  int wrong_echoes = 0;                // number of uploads that are echoed with one byte changed, before one succeeds
  bool zero_before_answer = false;     // the boot loader sends a byte 00 before its answer
  int short_report_every = 0;          // every n-th report has only 14 bytes; 0: none
  int split_report_every = 0;          // every n-th report is split into two USB packets; 0: none
  double answer_after_s = 0;           // delay from a command to its report
  FalconCounts zero_offset{317, -208, 95};  // arbitrary offset of the encoders before homing
  double motor_counts_per_Nmm = -10;        // as in the driver
};

/// Homing: with the homing bit set, the encoder of a leg finds its zero when the arm has been further out than
/// kFalconHomingOut counts and then moves further in than kFalconHomingIn. The real positions are unknown. On the axis,
/// the grip is then 36 mm towards the user and 31 mm away from the user, respectively.
inline constexpr int kFalconHomingOut = 600;
inline constexpr int kFalconHomingIn = -900;

class FalconModel final : public UsbModel {
 public:
  /// The mechanism must outlive the model. While the handle is out of the legs' reach, the encoders keep their counts.
  FalconModel(Mechanism& mechanism, FalconModelOptions options);

  std::vector<std::uint8_t> descriptors() const override;
  void Advance(double dt_s) override;
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data) override;
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override;
  /// Resets the serial port. Resets everything else too, unless the device keeps its power.
  void PowerOn() override;

  // ---- not visible to a host
  bool runs() const { return state_ == State::kRun; }
  bool homed() const { return homed_ == kFalconAllHomed; }
  const std::vector<std::uint8_t>& loaded() const { return loaded_; }  // bytes of the current or last upload
  int uploads() const { return uploads_; }
  const FalconCommand& last_command() const { return command_; }
  std::uint64_t commands() const { return commands_; }
  Vec3 f_D_N() const { return f_D_N_; }  // current force of the motors at the grip
  bool saw_homing_off() const { return saw_homing_off_; }

 private:
  enum class State : std::uint8_t { kBoot, kGreeted, kLoading, kLoaded, kRun };
  void PlugIn();
  void SwitchOn();
  void BootByte(std::uint8_t byte);
  void RunByte(std::uint8_t byte);
  void ReadEncoders();
  void SetForce();
  void Answer();
  void Send(std::uint8_t byte);

  Mechanism& mechanism_;
  FalconModelOptions options_;

  // Serial port.
  std::uint16_t baud_ = 0;
  std::uint16_t format_ = 8;
  std::uint16_t flow_ = 0;
  std::uint16_t latency_ms_ = 16;
  bool dtr_ = false;
  bool rts_ = false;
  struct Byte {
    std::uint8_t value = 0;
    double at_s = 0;
    bool ends_packet = false;
  };
  std::deque<Byte> to_host_;
  double now_s_ = 0;
  double last_packet_s_ = 0;

  // Falcon.
  State state_ = State::kBoot;
  std::size_t greeted_ = 0;
  std::vector<std::uint8_t> loaded_;
  int uploads_ = 0;
  FalconPacketStream stream_;
  FalconCommand command_;
  std::uint64_t commands_ = 0;
  std::uint64_t reports_ = 0;
  FalconCounts counts_{};  // true counts
  std::uint8_t was_out_ = 0;
  std::uint8_t homed_ = 0;
  Vec3 f_D_N_{0};
  bool saw_homing_off_ = false;
};

}  // namespace kerf
