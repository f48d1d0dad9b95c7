#include "session/run/session_recorder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "base/core/hash.h"
#include "base/files/files.h"
#include "base/table/run_info.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/run/run_scene.h"

namespace kerf {
namespace {

std::string DescribeMachine() {
  const RunInfo run = ReadRunInfo();
  std::string processor = run.cpu.empty() ? "unknown processor" : run.cpu;
  utsname system{};
  if (uname(&system) != 0) return processor;
  return fmt::format("{}, {} {} {}", processor, system.sysname, system.release, system.machine);
}

class Mixer {
 public:
  void Mix(double x) { hash_ = MixHash(hash_ ^ std::bit_cast<std::uint64_t>(x)); }
  void Mix(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) Mix(v[axis]);
  }
  void Mix(const Quat& q) {
    for (const double x : {q.w, q.x, q.y, q.z}) Mix(x);
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

TickToRecord MakeTickToRecord(const TickInputs& in, std::uint64_t hash, std::uint64_t voxel_hash, const Vec3& p_WT_mm,
                              const Vec3& f_N, const TeethOutput& out) {
  TickToRecord record{{in, CheckOf(hash), CheckOf(voxel_hash)}, hash, voxel_hash, {}};
  record.state.p_WT_mm = p_WT_mm;
  record.state.f_N = f_N;
  record.state.removed_mm3 = out.removed_mm3;
  record.state.engaged_teeth = out.engaged_teeth;
  return record;
}

}  // namespace

RecordingHeader MakeRecordingHeader(const Scene& scene, const std::string& scene_file, RecordedKind kind,
                                    const Bone& bone, const Pose& X_WT_start) {
  RecordingHeader header;
  header.kind = kind;
  header.scene_name = scene.name;
  // A synthetic scene has no file.
  if (!scene_file.empty()) header.scene_file = std::filesystem::absolute(scene_file).lexically_normal().string();
  header.scene_toml = ResolvedToml(scene);
  header.bone_hash = bone.CalcHash();
  header.material_hash = bone.CalcMaterialHash();
  header.voxel_mm = bone.voxel_mm();
  header.rate_hz = kind == RecordedKind::kLoop ? scene.loop.rate_hz : scene.simulation.rate_hz;
  header.X_WT_start = X_WT_start;
  // At 4 kHz the checks alone would take a megabyte per minute. With 8 bits, one difference in 256 is missed, but the
  // next check is likely to find it.
  header.check_bits = header.rate_hz > 1500 ? 8 : 16;
  header.state_every_steps = std::max(1, static_cast<int>(std::lround(header.rate_hz / 100)));
  header.version = VersionString();
  header.commit = CommitString();
  header.compiler = CompilerString();
  header.machine = DescribeMachine();
  header.created = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                               fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  return header;
}

std::map<std::string, std::string> ReadSceneFiles(const Scene& scene, const std::string& scene_file,
                                                  const std::map<std::string, std::string>& known) {
  std::map<std::string, std::string> files;
  for (const std::string& name : ListInputs(scene, scene_file)) {
    if (name.empty() || name == scene_file || name == scene.bone.file) continue;
    const auto found = known.find(name);
    files[name] = found != known.end() ? found->second : ReadTextFile(name, kMaxFileBytes / 2);
  }
  return files;
}

/// Returns the bone with a hash in the unpacked project that contains the recording; empty if there is none.
std::string FindProjectBone(const std::string& recording, std::uint64_t hash) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::absolute(recording).lexically_normal().parent_path().parent_path();
  if (const fs::path file = folder / "bones" / fmt::format("{:016x}.vdb", hash); fs::exists(file)) return file.string();
  for (const char* name : {"bone.vdb", "cut.vdb"}) {
    const fs::path file = folder / name;
    if (fs::exists(file) && ReadBone(file.string()).CalcHash() == hash) return file.string();
  }
  return {};
}

RecordedScene OpenRecordedScene(RecordingReader& recording, const std::string& bone_file) {
  const RecordingHeader& header = recording.header();
  RecordedScene recorded;
  recorded.files = std::make_unique<FileShelf>(recording.ReadFiles());
  recorded.scene =
      ParseScene(header.scene_toml, header.scene_file.empty() ? header.scene_name + ".toml" : header.scene_file);
  recorded.scene.name = header.scene_name;
  if (!bone_file.empty()) {
    recorded.scene.bone.source = BoneSource::kFile;
    recorded.scene.bone.file = std::filesystem::absolute(bone_file).lexically_normal().string();
  }
  std::string& bone = recorded.scene.bone.file;
  if (recorded.scene.bone.source == BoneSource::kFile && !std::filesystem::exists(bone)) {
    if (std::string found = FindProjectBone(recording.path(), header.bone_hash); !found.empty())
      bone = std::move(found);
  }
  if (recorded.scene.bone.source == BoneSource::kFile && !std::filesystem::exists(bone)) {
    throw Error(fmt::format("{}: its bone is not at {}; give its location with --bone FILE", recording.path(), bone));
  }
  return recorded;
}

std::vector<std::string> FindDamageWarnings(const RecordingReader& recording) {
  const RecordingDamage& damage = recording.damage();
  std::vector<std::string> warnings;
  if (!damage.sentence.empty()) warnings.push_back(damage.sentence);
  if (damage.whole_steps < damage.known_steps) {
    warnings.push_back(
        fmt::format("the replay ends at {:.3f} s: bone and forces after that depend on the missing data; 'kerf log' "
                    "shows what else was read",
                    damage.whole_s));
  }
  return warnings;
}

TickToRecord MakeTickToRecord(const LoopTick& tick) {
  const CoupledOutput& out = tick.coupled;
  Mixer mixer;
  mixer.Mix(tick.force.f_H_W_N);
  mixer.Mix(out.f_H_W_N);
  mixer.Mix(out.tau_H_W_Nmm);
  mixer.Mix(out.f_cut_W_N);
  mixer.Mix(out.X_WT.p_AB);
  mixer.Mix(out.X_WT.R_AB);
  mixer.Mix(out.removed_mm3);
  mixer.Mix(static_cast<double>(out.status));
  return MakeTickToRecord(tick.in, mixer.hash(), tick.voxel_hash, out.X_WT.p_AB, out.f_H_W_N, out);
}

TickToRecord MakeTickToRecord(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) {
  Mixer mixer;
  mixer.Mix(out.f_T_W_N);
  mixer.Mix(out.tau_TG_W_Nmm);
  mixer.Mix(out.removed_mm3);
  mixer.Mix(out.engaged_teeth);
  mixer.Mix(static_cast<double>(out.status));
  const TickInputs inputs{.X = in.X_WT, .dt_s = in.dt_s, .rpm = in.rpm};
  return MakeTickToRecord(inputs, mixer.hash(), voxel_hash, in.X_WT.p_AB, out.f_T_W_N, out);
}

SessionRecorder::SessionRecorder(const std::string& path, const RecordingHeader& header,
                                 const std::map<std::string, std::string>& files)
    : rate_hz_(header.rate_hz),
      check_mask_(MaskOf(header.check_bits)),
      state_every_(header.state_every_steps),
      hash_every_(header.hash_every_steps) {
  writer_.emplace(path, header, files, ReadKeyFile());
  bytes_ = writer_->bytes();
}

template <typename Do>
void SessionRecorder::Try(Do&& act) {
  if (!writer_) return;
  try {
    act();
    bytes_ = writer_->bytes();
  } catch (const Error& e) {
    steps_ = writer_->written_steps();
    failure_ = fmt::format("the recording ended at {:.3f} s: {}", writer_->written_s(), e.what());
    writer_.reset();
  }
}

void SessionRecorder::Take(const TickToRecord& tick) {
  Try([&] {
    time_s_ += CalcElapsed(tick.step, rate_hz_);
    RecordedStep step = tick.step;
    step.force_check &= check_mask_;
    step.bone_check &= check_mask_;
    writer_->Add(step, time_s_);
    ++steps_;
    force_hash_ = MixHash(force_hash_ ^ tick.hash);
    voxel_hash_ = tick.voxel_hash;
    removed_mm3_ += tick.state.removed_mm3;
    if (steps_ % static_cast<std::uint64_t>(state_every_) == 0) {
      RecordedState state = tick.state;
      state.time_s = time_s_;
      state.removed_mm3 = removed_mm3_;
      writer_->AddState(state);
    }
    if (steps_ % static_cast<std::uint64_t>(hash_every_) == 0) writer_->AddHash(force_hash_, voxel_hash_);
  });
}

void SessionRecorder::TakeSetDown(const Pose& X) {
  Try([&] {
    RecordedStep step;
    step.X = X;
    step.dt_s = 0;
    step.flags = kRecordedSetDown;
    writer_->Add(step, time_s_);
    ++steps_;
  });
}

void SessionRecorder::Lose(std::uint64_t ticks) {
  Try([&] {
    writer_->Flush();
    throw Error(fmt::format("{}: {} ticks arrived faster than they could be written", writer_->path(), ticks));
  });
}

void SessionRecorder::AddEvent(const std::string& what, const std::string& name, std::uint32_t number) {
  Try([&] { writer_->AddEvent({0, 0, what, name, number}); });
}

void SessionRecorder::AddPiece(std::uint32_t number, const std::string& bytes) {
  Try([&] { writer_->AddPiece(number, bytes); });
}

void SessionRecorder::FlushAt(double now_s) {
  constexpr double kLongest_s = 0.35;
  if (bytes_ != flushed_bytes_) {
    flushed_bytes_ = bytes_;
    flushed_at_s_ = now_s;
  }
  if (now_s - flushed_at_s_ > kLongest_s) Try([&] { writer_->Flush(); });
}

void SessionRecorder::Finish(const std::string& why, std::optional<std::uint64_t> bone_hash) {
  Try([&] { writer_->Finish({steps_, time_s_, force_hash_, voxel_hash_, bone_hash, why}); });
}

}  // namespace kerf
