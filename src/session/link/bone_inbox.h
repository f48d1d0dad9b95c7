// A bone that a peer sends, until the owner of the session takes it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "session/link/igtl_bone.h"
#include "session/link/igtl_message.h"

namespace kerf {

/// Returns whether a message contains a bone.
bool IsBoneMessage(const IgtlHeader& header);

/// A label map with the values 0 and 1, or a surface.
using SentBone = std::variant<Volume, TriangleMesh>;

/// Unit of the coordinates in messages.
inline constexpr const char* kSentUnits = "mm";

/// Writes the bone as a file of which `kerf import` makes a bone: a segmentation (.seg.nrrd, used as --mask without a
/// CT) or a surface (.ply). `path`: without its extension. Returns the path of the file. Throws kerf::Error.
std::string WriteSentBone(const SentBone& bone, const std::string& path);

/// Keeps the newest bone. All functions may be called in any thread.
class BoneInbox {
 public:
  static constexpr std::chrono::seconds kBetween{2};  // two bones

  /// From now on, bones are accepted.
  void Open();
  /// From now on, bones are refused. This is so at first.
  void Close();
  /// Throws kerf::Error with one sentence unless a bone would be accepted now.
  void Check() const;
  /// Keeps the bone of a message; it replaces an earlier one that still waits. Throws kerf::Error as Check() and the
  /// functions of igtl_bone.h do.
  void Take(const IgtlHeader& header, std::span<const std::uint8_t> content);
  /// Returns what waits.
  std::optional<SentBone> Fetch();

 private:
  using Clock = std::chrono::steady_clock;
  mutable std::mutex mutex_;
  bool open_ = false;
  Clock::time_point next_{};  // a bone is accepted from then on
  std::optional<SentBone> waiting_;
};

}  // namespace kerf
