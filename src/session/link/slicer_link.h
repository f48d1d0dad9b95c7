// Live link of a session to 3D Slicer or any other program that speaks OpenIGTLink (docs/slicer.md): the tool, the
// force and the bone as it is being cut go out; changes of a plan and the pose of a tracked tool come in.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "kerf/bone.h"
#include "session/link/bone_inbox.h"
#include "session/link/igtl_server.h"
#include "session/link/plan_request.h"
#include "session/link/tracked_tool.h"
#include "session/run/session_controller.h"

namespace kerf {

/// What a frame shows.
struct LinkMoment {
  Pose X_WT;
  Vec3 f_H_W_N{0};
  std::vector<double> numbers;  // as in kerf_numbers
};

/// Sends, all in RAS as 3D Slicer has it, at the server's rate: the pose of the tool (TRANSFORM "kerf_tool"), the force
/// on the hand (SENSOR "kerf_force", N), time in s, volume that was cut in mm^3 (also if that was undone) and the
/// effects' channels (NDARRAY "kerf_numbers"), and all these with their names as text (STRING "kerf_values"). Once per
/// peer: the shape of the tool (POLYDATA "kerf_tool_shape") and the names of those numbers (STRING "kerf_names"). After
/// each change, at most twice per second: the bone (POLYDATA "kerf_bone"). STATUS "kerf" says what happens, and answers
/// GET_STATUS.
///
/// Takes IMAGE and POLYDATA "kerf_bone" for bone(), TRANSFORM "kerf_hand" for tracked_tool(), from one peer until it is
/// gone or silent, and all other TRANSFORM and POINT messages for plan(). What is refused is answered
/// with a STATUS of one sentence, at most once per second.
///
/// The link shows one session after another. A SessionController's functions and TakeTick() are called in the thread
/// that steps the session, never in the loop's; all others in one other thread.
class SlicerLink final : public SessionController {
 public:
  /// Throws kerf::Error if it cannot listen.
  explicit SlicerLink(const IgtlServerOptions& options);
  ~SlicerLink() override;

  /// Shows another session, which begins after this: the title of its scene and the shape of its tool, tool frame.
  void Show(const std::string& title, const TriangleMesh& tool_T);
  PlanInbox& plan() { return plan_; }
  BoneInbox& bone() { return bone_; }
  const std::shared_ptr<TrackedTool>& tracked_tool() const { return tracked_tool_; }
  /// Sends a STATUS of failure to all peers, unless it is the same as within the last second.
  void Refuse(const std::string& sentence);

  void Begin(const LoopInitialState& initial) override;
  void TakeLeaf(const LeafMessage& leaf) override;
  std::optional<LoopAction> NextAction() override { return {}; }
  void Done(const LoopAction&, const std::string&, std::optional<double>) override {}
  bool needs_undo() const override { return false; }
  void TakeTick(const LoopTick& tick, std::span<const double> channels);

  /// Sends the last state of the bone and a sentence, and waits until the peers have them, at most 2 s.
  void End(const std::string& sentence);

  int port() const { return server_->port(); }
  IgtlCounts counts() const { return server_->counts(); }
  std::uint64_t refusals() const;  // messages that were refused

 private:
  using Bytes = std::shared_ptr<const std::string>;
  Bytes MakeFrame();
  std::vector<Bytes> MakeWelcome();
  Bytes MakeStatus();
  Bytes Answer(IgtlServer::PeerNumber peer, const IgtlHeader& header, std::span<const std::uint8_t> content);
  void TakeHand(IgtlServer::PeerNumber peer, std::span<const std::uint8_t> content);
  std::size_t MaxBytes(const IgtlHeader& header) const;
  Bytes MakeRefusal(const std::string& sentence);
  void MeshInTurn();
  void EndMeshing();

  PlanInbox plan_;
  BoneInbox bone_;
  const std::shared_ptr<TrackedTool> tracked_tool_ = std::make_shared<TrackedTool>();
  ToolHolder hand_;  // used in the server's thread

  mutable std::mutex mutex_;  // protects everything up to the thread
  std::condition_variable changed_;
  std::optional<LinkMoment> moment_;  // none: already sent, or nothing has moved yet
  std::string names_;                 // of the numbers, one per line; empty before Begin()
  double cut_mm3_ = 0;
  std::optional<Bone> first_bone_;                               // until the thread takes it
  std::map<std::array<int, 3>, std::array<float, 512>> leaves_;  // changed since then, by index
  Bytes tool_bytes_;                                             // null: there is none yet
  Bytes bone_bytes_;                                             // the same
  std::string state_;                                            // sentence for STATUS
  bool meshes_ = false;                                          // the thread is at work
  bool hurries_ = false;                                         // the session has ended: no pauses
  bool end_ = false;
  std::string refusal_;  // last one
  std::uint64_t refusals_ = 0;
  std::chrono::steady_clock::time_point refused_at_;

  std::thread meshing_;
  std::unique_ptr<IgtlServer> server_;  // ends first: it calls the functions above
};

}  // namespace kerf
