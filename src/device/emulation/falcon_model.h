// A Novint Falcon made of numbers: the serial port on USB, the boot loader behind it, the firmware once it is loaded,
// encoders, motors and legs. What is known of the real one: devices/falcon/*.h and docs/falcon.md.
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
  bool firmware_is_there = false;           // loaded before by another program, and the Falcon kept its power
  std::vector<std::uint8_t> firmware;       // that alone runs; empty: any that is 1 kB or longer
  bool homed = false;                       // from the start, where the firmware is there
  bool keeps_power = false;                 // when it is unplugged from USB: it has a supply of its own
  int wrong_echoes = 0;                     // uploads that come back with a byte changed, before one goes well
  bool zero_before_answer = false;          // the boot loader's 00
  int short_report_every = 0;               // every so many reports, one of 14 bytes; 0: none
  int split_report_every = 0;               // and one in two USB packets
  double answer_after_s = 0;                // from a command to its report
  FalconCounts zero_offset{317, -208, 95};  // of the encoders before homing, arbitrary
  double motor_counts_per_Nmm = -10;        // as the driver's
};

/// Homing: a leg's encoder finds its zero when, with the homing bit on, its arm has been further out than
/// kFalconHomingOut counts and then comes further in than kFalconHomingIn. Where the real marks are is not known.
/// On the axis: 36 mm towards the user, 31 mm away.
inline constexpr int kFalconHomingOut = 600;
inline constexpr int kFalconHomingIn = -900;

class FalconModel final : public UsbModel {
 public:
  /// The mechanism must outlive the model. A handle out of the legs' reach leaves the encoders where they were.
  FalconModel(Mechanism& mechanism, FalconModelOptions options);

  std::vector<std::uint8_t> descriptors() const override;
  void Advance(double dt_s) override;
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data) override;
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) override;
  /// The serial port forgets all; so does the rest, unless it keeps its power.
  void PowerOn() override;

  // ---- what no host can see
  bool runs() const { return state_ == State::kRun; }
  bool homed() const { return homed_ == kFalconAllHomed; }
  const std::vector<std::uint8_t>& loaded() const { return loaded_; }  // of the upload that is running or was last
  int uploads() const { return uploads_; }
  const FalconCommand& last_command() const { return command_; }
  std::uint64_t commands() const { return commands_; }
  Vec3 f_D_N() const { return f_D_N_; }  // of the motors at the grip, now
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

  // The serial port.
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

  // The Falcon.
  State state_ = State::kBoot;
  std::size_t greeted_ = 0;
  std::vector<std::uint8_t> loaded_;
  int uploads_ = 0;
  FalconPacketStream stream_;
  FalconCommand command_;
  std::uint64_t commands_ = 0;
  std::uint64_t reports_ = 0;
  FalconCounts counts_{};  // true
  std::uint8_t was_out_ = 0;
  std::uint8_t homed_ = 0;
  Vec3 f_D_N_{0};
  bool saw_homing_off_ = false;
};

}  // namespace kerf
