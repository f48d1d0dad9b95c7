#include "app/window/bone_saver.h"

#include <utility>

#include "bone/vdb/bonefile.h"

namespace kerf {

BoneSaver::BoneSaver() : thread_([this] { Run(); }) {}

BoneSaver::~BoneSaver() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BoneSaver::Run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    writing_ = true;
    written_ = job;
    lock.unlock();
    std::string failure;
    try {
      WriteBone(*job.bone, job.path);
    } catch (const std::exception& e) {
      failure = e.what();
    }
    if (failure.empty()) job = {};  // frees the bone outside the lock
    lock.lock();
    writing_ = false;
    written_ = {};
    if (!failure.empty()) {
      failures_.push_back(std::move(failure));
      failed_.push_back(std::move(job));
    }
    changed_.notify_all();
  }
}

void BoneSaver::Save(std::shared_ptr<const Bone> bone, const std::string& path) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({std::move(bone), path});
  }
  changed_.notify_all();
}

std::vector<std::string> BoneSaver::TakeFailures() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failures_, {});
}

std::map<std::string, std::shared_ptr<const Bone>> BoneSaver::ListUnsaved() {
  const std::lock_guard lock(mutex_);
  std::map<std::string, std::shared_ptr<const Bone>> unsaved;
  for (const Job& job : failed_) unsaved[job.path] = job.bone;
  for (const Job& job : jobs_) unsaved[job.path] = job.bone;
  if (writing_) unsaved[written_.path] = written_.bone;
  return unsaved;
}

std::vector<std::string> BoneSaver::Finish() {
  std::unique_lock lock(mutex_);
  const auto idle = [this] { return jobs_.empty() && !writing_; };
  changed_.wait(lock, idle);
  failures_.clear();
  for (Job& job : std::exchange(failed_, {})) jobs_.push_back(std::move(job));
  changed_.notify_all();
  changed_.wait(lock, idle);
  return std::exchange(failures_, {});
}

}  // namespace kerf
