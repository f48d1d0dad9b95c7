#include "session/project/zip_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <set>

#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;

/// Digest of bytes that arrive in blocks; the same as CalcDigest() of all.
class RunningDigest {
 public:
  RunningDigest() {
    CalcDigest("");  // sets up libsodium
    crypto_generichash_init(&state_, nullptr, 0, sizeof(Digest));
  }
  void Add(std::string_view bytes) {
    crypto_generichash_update(&state_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  }
  Digest Finish() {
    Digest digest;
    crypto_generichash_final(&state_, digest.data(), digest.size());
    return digest;
  }

 private:
  crypto_generichash_state state_{};
};

/// Text of an error of libzip.
std::string ZipErrorText(zip_error_t* error) {
  std::string text = zip_error_strerror(error);
  zip_error_fini(error);
  return text;
}

bool IsPlainName(std::string_view name) {
  return !name.empty() && name.size() <= 255 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 0x7f && c != '\\'; });
}

/// Destination of libzip: a file that already exists, under whatever name.
class FileSink {
 public:
  explicit FileSink(const std::string& path) : file_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
    if (file_ < 0) throw Error(FormatErrno(errno));
    zip_error_init(&error_);
  }
  ~FileSink() {
    close(file_);
    zip_error_fini(&error_);
  }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  static zip_int64_t Handle(void* self, void* data, zip_uint64_t size, zip_source_cmd_t command) {
    return static_cast<FileSink*>(self)->Handle(data, size, command);
  }

 private:
  zip_int64_t Fail(int code) {
    zip_error_set(&error_, code, errno);
    return -1;
  }
  zip_int64_t Seek(void* data, zip_uint64_t size) {
    const zip_source_args_seek_t* args = ZIP_SOURCE_GET_ARGS(zip_source_args_seek_t, data, size, &error_);
    if (args == nullptr) return -1;
    return lseek(file_, args->offset, args->whence) < 0 ? Fail(ZIP_ER_SEEK) : 0;
  }
  zip_int64_t Handle(void* data, zip_uint64_t size, zip_source_cmd_t command) {
    switch (command) {
      case ZIP_SOURCE_SUPPORTS:
        return ZIP_SOURCE_SUPPORTS_WRITABLE;
      case ZIP_SOURCE_STAT: {
        // The file counts as missing until it has been written.
        zip_error_set(&error_, ZIP_ER_READ, ENOENT);
        return -1;
      }
      case ZIP_SOURCE_ERROR:
        return zip_error_to_data(&error_, data, size);
      case ZIP_SOURCE_BEGIN_WRITE:
        if (ftruncate(file_, 0) != 0 || lseek(file_, 0, SEEK_SET) != 0) return Fail(ZIP_ER_WRITE);
        return 0;
      case ZIP_SOURCE_WRITE: {
        const char* bytes = static_cast<const char*>(data);
        for (zip_uint64_t done = 0; done < size;) {
          const ssize_t count = write(file_, bytes + done, size - done);
          if (count < 0 && errno == EINTR) continue;
          if (count <= 0) return Fail(ZIP_ER_WRITE);
          done += static_cast<zip_uint64_t>(count);
        }
        return static_cast<zip_int64_t>(size);
      }
      case ZIP_SOURCE_SEEK:
      case ZIP_SOURCE_SEEK_WRITE:
        return Seek(data, size);
      case ZIP_SOURCE_TELL:
      case ZIP_SOURCE_TELL_WRITE:
        return lseek(file_, 0, SEEK_CUR);
      case ZIP_SOURCE_READ: {
        const ssize_t count = read(file_, data, size);
        return count < 0 ? Fail(ZIP_ER_READ) : count;
      }
      default:  // opening, closing, committing, discarding, removing, freeing: the owner of the file does that
        return 0;
    }
  }

  int file_;
  zip_error_t error_{};
};

}  // namespace

struct ZipReader::State {
  std::string path;
  zip_t* archive = nullptr;
  std::vector<ZipMember> members;

  ~State() {
    if (archive != nullptr) zip_discard(archive);
  }

  void Open(zip_source_t* source, zip_error_t* error) {
    archive = source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, error);
    if (archive == nullptr) {
      const std::string text = ZipErrorText(error);
      if (source != nullptr) zip_source_free(source);
      throw Error(fmt::format("{}: is not a complete ZIP file: {}", path, text));
    }
    zip_error_fini(error);
    const zip_int64_t count = zip_get_num_entries(archive, 0);
    if (count < 0 || count > static_cast<zip_int64_t>(kMaxZipMembers)) {
      throw Error(
          fmt::format("{}: contains {} members; the largest possible number is {}", path, count, kMaxZipMembers));
    }
    std::set<std::string> names;
    for (zip_int64_t i = 0; i < count; ++i) members.push_back(CheckMember(static_cast<zip_uint64_t>(i), names));
  }

  ZipMember CheckMember(zip_uint64_t i, std::set<std::string>& names) const {
    const char* raw = zip_get_name(archive, i, ZIP_FL_ENC_RAW);
    const std::string name = raw == nullptr ? "" : raw;
    if (!IsPlainName(name)) throw Error(fmt::format("{}: member {} has no valid name", path, i + 1));
    if (!names.insert(name).second) throw Error(fmt::format("{}: two members are named '{}'", path, name));
    zip_stat_t stat;
    constexpr zip_uint64_t kNeeded =
        ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if (zip_stat_index(archive, i, 0, &stat) != 0 || (stat.valid & kNeeded) != kNeeded) {
      throw Error(fmt::format("{}: is damaged: the header of '{}' can't be read", path, name));
    }
    if (stat.encryption_method != ZIP_EM_NONE) throw Error(fmt::format("{}: '{}' is encrypted", path, name));
    if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE) {
      throw Error(fmt::format("{}: '{}' is compressed in an unknown way", path, name));
    }
    if (stat.size > kFreeZipBytes && stat.size / kMaxZipRatio > stat.comp_size) {
      throw Error(fmt::format("{}: '{}' would be more than {} times as large when unpacked", path, name, kMaxZipRatio));
    }
    return {.name = name, .bytes = stat.size};
  }
};

ZipReader::ZipReader(const std::string& path) : state_(std::make_unique<State>()) {
  state_->path = path;
  // Refuses missing files, folders and pipes with clear sentences.
  CheckIsRegularFile(path);
  zip_error_t error;
  zip_error_init(&error);
  state_->Open(zip_source_file_create(path.c_str(), 0, -1, &error), &error);
}

ZipReader::ZipReader(std::string_view bytes, const std::string& name) : state_(std::make_unique<State>()) {
  state_->path = name;
  zip_error_t error;
  zip_error_init(&error);
  state_->Open(zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error), &error);
}

ZipReader::~ZipReader() = default;

const std::vector<ZipMember>& ZipReader::members() const {
  return state_->members;
}

Digest ZipReader::Unpack(std::size_t i, const std::function<void(std::string_view block)>& take) const {
  const ZipMember& member = state_->members.at(i);
  const auto fail = [&](const std::string& why) {
    throw Error(fmt::format("{}: is damaged: '{}' can't be unpacked: {}", state_->path, member.name, why));
  };
  zip_file_t* file = zip_fopen_index(state_->archive, i, 0);
  if (file == nullptr) fail(zip_strerror(state_->archive));
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> closer(file, zip_fclose);
  RunningDigest digest;
  std::vector<char> block(kBlock);
  std::uint64_t done = 0;
  while (true) {
    const zip_int64_t count = zip_fread(file, block.data(), block.size());  // checks the CRC at the end
    if (count < 0) fail(zip_file_strerror(file));
    if (count == 0) break;
    done += static_cast<std::uint64_t>(count);
    if (done > member.bytes) fail("it is longer than its header states");
    const std::string_view bytes(block.data(), static_cast<std::size_t>(count));
    digest.Add(bytes);
    take(bytes);
  }
  if (done != member.bytes) fail("it is shorter than its header states");
  return digest.Finish();
}

std::string ZipReader::UnpackText(std::size_t i, std::size_t max_bytes, Digest* digest) const {
  const ZipMember& member = state_->members.at(i);
  if (member.bytes > max_bytes) {
    throw Error(fmt::format("{}: '{}' has {} bytes; the largest possible size is {}", state_->path, member.name,
                            member.bytes, max_bytes));
  }
  std::string text;
  text.reserve(static_cast<std::size_t>(member.bytes));
  const Digest found = Unpack(i, [&](std::string_view block) { text += block; });
  if (digest != nullptr) *digest = found;
  return text;
}

struct ZipWriter::State {
  struct Member {
    std::string name;
    std::string text;
    std::string file;  // empty: the member is the text
    std::uint64_t bytes = 0;
  };
  std::vector<Member> members;
};

ZipWriter::ZipWriter() : state_(std::make_unique<State>()) {}
ZipWriter::~ZipWriter() = default;

void ZipWriter::AddText(const std::string& name, std::string text) {
  state_->members.push_back({.name = name, .text = std::move(text), .file = "", .bytes = 0});
}

void ZipWriter::AddFile(const std::string& name, const std::string& file, std::uint64_t bytes) {
  state_->members.push_back({.name = name, .text = "", .file = file, .bytes = bytes});
}

void ZipWriter::Write(const std::string& file) {
  FileSink sink(file);
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* target = zip_source_function_create(FileSink::Handle, &sink, &error);
  zip_t* archive = target == nullptr ? nullptr : zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, &error);
  if (archive == nullptr) {
    if (target != nullptr) zip_source_free(target);
    throw Error(ZipErrorText(&error));
  }
  zip_error_fini(&error);
  std::unique_ptr<zip_t, void (*)(zip_t*)> owner(archive, zip_discard);
  for (const State::Member& member : state_->members) {
    zip_source_t* source =
        member.file.empty() ? zip_source_buffer(archive, member.text.data(), member.text.size(), 0)
                            : zip_source_file(archive, member.file.c_str(), 0, static_cast<zip_int64_t>(member.bytes));
    const zip_int64_t index =
        source == nullptr ? -1 : zip_file_add(archive, member.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      if (source != nullptr) zip_source_free(source);
      throw Error(zip_strerror(archive));
    }
    const zip_int32_t method = member.file.empty() ? ZIP_CM_DEFLATE : ZIP_CM_STORE;
    if (zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0) != 0) {
      throw Error(zip_strerror(archive));
    }
  }
  if (zip_close(archive) != 0) throw Error(zip_strerror(archive));
  owner.release();  // zip_close() has freed it
}

FileDigest CalcFileDigest(const std::string& path) {
  CheckIsRegularFile(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: can't be read: {}", path, FormatErrno(errno)));
  RunningDigest digest;
  FileDigest out;
  std::vector<char> block(kBlock);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    digest.Add({block.data(), count});
    out.bytes += count;
  }
  CheckReadable(in, path);
  out.digest = digest.Finish();
  return out;
}

}  // namespace kerf
