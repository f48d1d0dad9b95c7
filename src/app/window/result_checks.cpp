#include "app/window/result_checks.h"

#include <utility>

#include "app/window/is_ready.h"
#include "base/realtime/realtime.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/score/score.h"

namespace kerf {

void ResultChecks::Begin(const Scene& scene, const std::string& recording, const ScoreSheet& sheet) {
  End();
  work_ = std::make_shared<Work>();
  verified_.reset();
  failed_ = false;
  expert_.reset();
  running_.push_back(std::async(std::launch::async, [work = work_, experts = experts_, scene, recording, sheet] {
    LowerPriority();
    try {
      auto expert = experts->Get(scene, &work->stop);
      {
        const std::lock_guard lock(work->mutex);
        work->expert = std::move(expert);
      }
      RecordingReader reader(recording);
      ScoreOptions options;
      options.stop = &work->stop;
      const ScoreSheet replayed = ScoreRecording(reader, options, [&](const std::string&, double) {
        if (work->stop) throw Error("the verification was interrupted");
      });
      const std::lock_guard lock(work->mutex);
      work->verified = FormatSheetJson(replayed) == FormatSheetJson(sheet);
    } catch (const std::exception& e) {
      const std::lock_guard lock(work->mutex);
      work->failure = e.what();
    }
  }));
}

void ResultChecks::End() {
  if (work_) work_->stop = true;
  work_.reset();
}

ResultChecks::News ResultChecks::Take() {
  std::erase_if(running_, [](const std::future<void>& f) { return IsReady(f); });
  News news;
  if (!work_) return news;
  const std::lock_guard lock(work_->mutex);
  if (work_->expert && !expert_) {
    expert_ = work_->expert;
    news.expert = true;
  }
  if (work_->verified && !verified_) {
    verified_ = work_->verified;
    news.verified = true;
  }
  news.failure = std::exchange(work_->failure, {});
  failed_ = failed_ || !news.failure.empty();
  return news;
}

}  // namespace kerf
