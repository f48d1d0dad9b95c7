#include "session/run/bone_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <future>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "base/core/hash.h"
#include "base/files/disk_space.h"
#include "base/files/files.h"
#include "base/files/installed.h"
#include "base/files/memory.h"
#include "base/files/user_folders.h"
#include "base/realtime/realtime.h"
#include "kerf/bone_file.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr double kMinFreeBytes = 4e9;  // of the disk; with less, nothing is kept

/// Set by SetBoneCache().
std::string cache_folder;

/// The last bone that is being kept, which waits for those before it, and the keys of all of them.
std::shared_future<void> keeping;
std::set<std::string> kept_keys;
std::mutex keeping_mutex;

/// The bone that was begun, until it is taken.
struct Begun {
  std::vector<double> values;  // of the parameters
  std::future<Bone> bone;
};
std::optional<Begun> begun;
std::mutex begun_mutex;

std::vector<double> ListValues(MandibleParams params) {
  std::vector<double> values;
  Describe(params, [&values](const char* /*key*/, const auto& value, Range, const char* /*help*/) {
    values.push_back(static_cast<double>(value));
  });
  return values;
}

/// Returns the bone that was begun with these parameters, without waiting for it; an invalid future if there is none.
std::future<Bone> TakeBegun(const MandibleParams& params) {
  const std::lock_guard lock(begun_mutex);
  if (!begun || begun->values != ListValues(params)) return {};
  return std::move(std::exchange(begun, std::nullopt)->bone);
}

std::uint64_t HashBytes(std::string_view bytes, std::uint64_t hash) {
  for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(8, bytes.size()))) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), std::min<std::size_t>(8, bytes.size()));
    hash = MixHash(hash ^ word);
  }
  return MixHash(hash ^ bytes.size());
}

/// Returns a hash of the running program's file. Throws kerf::Error if it cannot be read.
std::uint64_t HashProgram() {
  const std::string program = FindProgram();
  if (program.empty()) throw Error("the system does not report the program's file");
  return HashBytes(ReadTextFile(program), 0);
}

/// Returns what the names of a bone's files begin with.
std::string MakeKey(const MandibleParams& params) {
  static const std::uint64_t program = HashProgram();
  std::uint64_t hash = program;
  MandibleParams described = params;
  Describe(described, [&hash](const char* key, const auto& value, Range, const char*) {
    hash = MixHash(HashBytes(key, hash) ^ std::bit_cast<std::uint64_t>(static_cast<double>(value)));
  });
  return fmt::format("mandible-{:016x}-", hash);
}

struct KeptFile {
  fs::path path;
  fs::file_time_type used;
  double bytes = 0;
};

/// Returns whether a file has a name that Keep() gives.
bool IsKept(const std::string& name) {
  constexpr std::string_view kPattern = "mandible-################-################.vdb";
  return std::equal(name.begin(), name.end(), kPattern.begin(), kPattern.end(), [](char c, char pattern) {
    return pattern == '#' ? std::string_view("0123456789abcdef").find(c) != std::string_view::npos : c == pattern;
  });
}

/// Returns the cache's files, the last used one first. Other files are left alone.
std::vector<KeptFile> ListFiles() {
  std::vector<KeptFile> files;
  if (!fs::is_directory(cache_folder)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(cache_folder)) {
    std::error_code error;
    if (!IsKept(entry.path().filename().string()) || entry.symlink_status(error).type() != fs::file_type::regular) {
      continue;
    }
    const KeptFile file{entry.path(), entry.last_write_time(error), static_cast<double>(entry.file_size(error))};
    if (!error) files.push_back(file);
  }
  std::sort(files.begin(), files.end(), [](const KeptFile& a, const KeptFile& b) { return a.used > b.used; });
  return files;
}

/// Returns the files of a bone.
std::vector<KeptFile> FindFiles(const std::string& key) {
  std::vector<KeptFile> files = ListFiles();
  std::erase_if(files, [&](const KeptFile& file) { return !file.path.filename().string().starts_with(key); });
  return files;
}

/// Returns the kept bone, without the materials and notes of its maker; nothing if there is none or it is damaged.
std::optional<Bone> Read(const std::string& key) {
  for (const KeptFile& file : FindFiles(key)) {
    const std::string name = file.path.stem().string();
    std::error_code ignored;
    try {
      Bone bone = ReadBone(file.path.string());
      if (fmt::format("{}{:016x}", key, bone.CalcHash()) == name) {
        fs::last_write_time(file.path, fs::file_time_type::clock::now(), ignored);
        return bone;
      }
    } catch (const Error&) {
    }
    fs::remove(file.path, ignored);
  }
  return std::nullopt;
}

void Keep(const Bone& bone, const std::string& key) {
  MakeFolder(cache_folder);
  const std::string path = fmt::format("{}/{}{:016x}.vdb", cache_folder, key, bone.CalcHash());
  if (ReadFreeDiskBytes(path) < kMinFreeBytes) return;
  WriteBone(bone, path);
  double bytes = static_cast<double>(fs::file_size(path));
  for (const KeptFile& file : ListFiles()) {
    if (file.path == path) continue;
    bytes += file.bytes;
    if (bytes > kMaxBoneCacheBytes) fs::remove(file.path);
  }
}

/// The cache is only a convenience: whatever prevents its use, the bone can be made.
template <typename Use>
void Try(Use&& use) {
  try {
    use();
  } catch (const Error&) {
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
}

/// Keeps a copy of the bone in the background, after those before it. Without memory for that copy and for what writing
/// takes, nothing is kept: in the window a failed request would end the program (see ExitOnBadAlloc).
void BeginKeeping(const Bone& bone, const std::string& key) {
  Try([&] {
    if (ReadAvailableBytes() < 2 * bone.CalcMemoryBytes()) return;
    const std::lock_guard lock(keeping_mutex);
    keeping = std::async(std::launch::async, [bone = bone, key = key, before = keeping]() mutable {
                LowerPriority();
                // Otherwise the copy would exist as long as the future.
                const Bone kept = std::move(bone);
                if (before.valid()) std::exchange(before, {}).wait();
                Try([&] { Keep(kept, key); });
              }).share();
    kept_keys.insert(key);
  });
}

/// Waits if a bone with this key is being kept. Returns whether one was begun.
bool WaitIfKeeping(const std::string& key) {
  std::shared_future<void> last;
  {
    const std::lock_guard lock(keeping_mutex);
    if (!kept_keys.contains(key)) return false;
    last = keeping;
  }
  last.wait();
  return true;
}

/// Reads the bone from the cache, or makes it.
Bone ReadOrMake(const MandibleParams& params, const MaterialTable& materials,
                const std::function<void(double)>& progress) {
  if (cache_folder.empty()) return MakeMandible(params, materials, progress);
  std::string key;
  std::optional<Bone> kept;
  Try([&] {
    key = MakeKey(params);
    kept = Read(key);
    if (!kept && WaitIfKeeping(key)) kept = Read(key);
  });
  if (kept) {
    CheckMandibleRegions(materials);
    kept->set_materials(materials);
    DescribeMandible(params, *kept);
    if (progress) progress(1);
    return *std::move(kept);
  }
  Bone bone = MakeMandible(params, materials, progress);
  if (!key.empty()) BeginKeeping(bone, key);
  return bone;
}

}  // namespace

std::string FindBoneCache() {
  const std::string cache = FindUserFolder(UserFolder::kCache);
  return cache.empty() ? cache : cache + "/kerf/bones";
}

void SetBoneCache(const std::string& folder) {
  FinishKeepingBones();
  cache_folder = folder;
}

void FinishKeepingBones() {
  {
    const std::lock_guard lock(begun_mutex);
    begun.reset();  // waits
  }
  const std::lock_guard lock(keeping_mutex);
  if (keeping.valid()) keeping.wait();
}

Bone MakeCachedMandible(const MandibleParams& params, const MaterialTable& materials,
                        const std::function<void(double)>& progress) {
  std::future<Bone> taken = TakeBegun(params);
  if (!taken.valid()) return ReadOrMake(params, materials, progress);
  while (progress && taken.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) progress(0);
  Bone bone = taken.get();
  CheckMandibleRegions(materials);
  bone.set_materials(materials);
  if (progress) progress(1);
  return bone;
}

bool IsMandibleCached(const MandibleParams& params) {
  if (cache_folder.empty()) return false;
  bool found = false;
  Try([&] { found = !FindFiles(MakeKey(params)).empty(); });
  return found;
}

void BeginCachedMandible(const MandibleParams& params, const MaterialTable& materials) {
  const std::lock_guard lock(begun_mutex);
  begun.reset();  // waits
  Try([&] {
    begun =
        Begun{ListValues(params), std::async(std::launch::async, [=] { return ReadOrMake(params, materials, {}); })};
  });
}

}  // namespace kerf
