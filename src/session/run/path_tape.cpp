#include "session/run/path_tape.h"

#include "kerf/error.h"
#include "session/scene/path.h"

namespace kerf {

const RecordedStep* RunReplay::Next(bool set_down) {
  if (verify_ && steps_.divergence()) return nullptr;
  const RecordedStep* next = steps_.Next();
  if (next != nullptr && ((next->flags & kRecordedSetDown) != 0) != set_down) {
    throw Error("the recording does not match its scene: the tool is set down at another tick");
  }
  return next;
}

bool RunReplay::SetDown(Pose& X) {
  const RecordedStep* next = Next(true);
  if (next != nullptr) X = next->X;
  return next != nullptr;
}

bool RunReplay::Begin(TickInput& in) {
  const RecordedStep* next = Next(false);
  if (next != nullptr) in = {next->X, next->dt_s, next->rpm};
  return next != nullptr;
}

RunTape::RunTape(const RunSession& session, const Scene& scene, RecordedKind kind, const Bone& bone)
    : replay_(session.replay), recording_failure_(session.recording_failure) {
  if (replay_ != nullptr) CheckReplays(replay_->recording(), bone);
  if (session.record.empty()) return;
  recorder_.emplace(session.record,
                    MakeRecordingHeader(scene, session.scene_file, kind, bone, MakePath(scene).CalcPose(0, 0)),
                    ReadSceneFiles(scene, session.scene_file));
}

RunTape::~RunTape() {
  if (recorder_) recorder_->Finish("an early end", std::nullopt);
}

void RunTape::Finish(std::optional<std::uint64_t> bone_hash) {
  if (!recorder_) return;
  recorder_->Finish("the path's end", bone_hash);
  const std::string failure = recorder_->failure();
  recorder_.reset();
  if (failure.empty()) return;
  if (recording_failure_ == nullptr) throw Error(failure);
  *recording_failure_ = failure;
}

}  // namespace kerf
