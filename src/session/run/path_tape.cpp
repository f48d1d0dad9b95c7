#include "session/run/tick_interceptor.h"

#include "kerf/error.h"
#include "session/scene/path.h"

namespace kerf {

bool RunRecorder::SetDown(Pose& X) {
  recorder_.TakeSetDown(X);
  return true;
}

void RunRecorder::End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) {
  recorder_.Take(MakeTickToRecord(in, out, voxel_hash));
}

std::string RunRecorder::Finish(std::optional<std::uint64_t> bone_hash) {
  recorder_.Finish("the path's end", bone_hash);
  return recorder_.failure();
}

bool RunReplay::Next(bool set_down) {
  const RecordedStep* next = steps_.Peek();
  if (next == nullptr || (verify_ && check_.divergence())) return false;
  step_ = *next;
  if (((step_.flags & kRecordedSetDown) != 0) != set_down) {
    throw Error("the recording does not match its scene: the tool is set down at another tick");
  }
  check_.Expect(steps_, step_);
  steps_.Pop();
  return true;
}

bool RunReplay::SetDown(Pose& X) {
  if (!Next(true)) return false;
  X = step_.X;
  return true;
}

bool RunReplay::Begin(TickInput& in) {
  if (!Next(false)) return false;
  in = {step_.X, step_.dt_s, step_.rpm};
  return true;
}

void RunReplay::End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) {
  check_.Compare(MakeTickToRecord(in, out, voxel_hash), steps_.time_s());
}

Replayed RunReplay::MakeReport(std::uint64_t bone_hash) const {
  Replayed replayed{steps_.step(),       steps_.time_s(),     check_.divergence(),
                    check_.force_hash(), check_.voxel_hash(), bone_hash};
  CheckEnd(recording_, replayed);
  return replayed;
}

SessionInterceptor::SessionInterceptor(const RunSession& session, const Scene& scene, RecordedKind kind,
                                       const Bone& bone)
    : replay_(session.replay), recording_failure_(session.recording_failure) {
  if (replay_ != nullptr) CheckBone(replay_->header(), bone);
  if (session.record.empty()) return;
  recorder_.emplace(session.record,
                    MakeRecordingHeader(scene, session.scene_file, kind, bone, MakePath(scene).CalcPose(0, 0)),
                    ReadSceneFiles(scene, session.scene_file));
}

TickInterceptor* SessionInterceptor::tap() {
  if (replay_ != nullptr) return replay_;
  return recorder_ ? &*recorder_ : nullptr;
}

void SessionInterceptor::Finish(std::optional<std::uint64_t> bone_hash) {
  if (!recorder_) return;
  const std::string failure = recorder_->Finish(bone_hash);
  if (failure.empty()) return;
  if (recording_failure_ == nullptr) throw Error(failure);
  *recording_failure_ = failure;
}

}  // namespace kerf
