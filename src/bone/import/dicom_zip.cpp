#include "bone/import/dicom_zip.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>
#include <vector>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "base/files/disk_space.h"
#include "base/files/files.h"
#include "bone/import/dicom_header.h"
#include "bone/import/limits.h"
#include "bone/import/unpack.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

struct PackedFile {
  zip_uint64_t index = 0;
  std::string name;
  std::uint64_t bytes = 0;
};

// Returns the name as a relative path that lies within a folder; empty if it is of no use.
std::string MakeSafeName(std::string name) {
  constexpr std::size_t kMaxPart = 100;  // bytes
  constexpr int kMaxDepth = 20;
  std::replace(name.begin(), name.end(), '\\', '/');
  fs::path safe;
  int depth = 0;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    std::string part = Printable(name.substr(begin, end - begin));
    begin = end + 1;
    if (part == "__MACOSX" || part.starts_with("._")) return "";
    if (part.empty() || part == "." || part == ".." || ++depth > kMaxDepth) continue;
    // The end of a name has its extension.
    if (part.size() > kMaxPart) part = Printable(part.substr(part.size() - kMaxPart));
    safe /= part;
  }
  return safe.string();
}

class ZipFile {
 public:
  explicit ZipFile(const std::string& path) : path_(path) {
    CheckIsRegularFile(path);
    int code = 0;
    archive_ = zip_open(path.c_str(), ZIP_RDONLY, &code);
    if (archive_ != nullptr) return;
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw Error(fmt::format("{}: is not a complete ZIP file: {}", path, why));
  }
  ~ZipFile() { zip_discard(archive_); }
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  // Adds to `left_out` large files that are no slices. Throws kerf::Error if the file exceeds a limit.
  std::vector<PackedFile> ListFiles(std::vector<LeftOutFile>& left_out) const {
    const zip_int64_t count = zip_get_num_entries(archive_, 0);
    if (count < 0 || static_cast<std::uint64_t>(count) > kMaxPackedFiles) {
      throw Error(
          fmt::format("{}: contains {} files, more than the {} that kerf unpacks", path_, count, kMaxPackedFiles));
    }
    std::vector<PackedFile> files;
    std::set<std::string> names;
    double all_bytes = 0;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
      zip_stat_t stat;
      constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_ENCRYPTION_METHOD;
      if (zip_stat_index(archive_, i, 0, &stat) != 0 || (stat.valid & kNeeded) != kNeeded) {
        throw Error(fmt::format("{}: is damaged: the header of file {} can't be read", path_, i + 1));
      }
      const std::string packed_name = stat.name;
      const std::string name = MakeSafeName(packed_name);
      if (name.empty() || packed_name.ends_with('/') || packed_name.ends_with('\\')) continue;
      if (stat.encryption_method != ZIP_EM_NONE) {
        throw Error(
            fmt::format("{}: '{}' is encrypted; unpack the file with its password and give the folder", path_, name));
      }
      const std::string head = static_cast<double>(stat.size) > kFreePackedBytes ? ReadHead(i) : "";
      if (!head.empty() && !BeginsLikeDicom(head)) {
        const std::string size = ShowThree(1e-6 * static_cast<double>(stat.size)) + " MB";
        left_out.push_back({name, fmt::format("{}, no DICOM file", size),
                            fmt::format("{}: '{}' of {} is no DICOM file", path_, name, size), false});
        continue;
      }
      all_bytes += static_cast<double>(stat.size);
      // Equal names are distinguished by a number.
      std::string own = name;
      for (int n = 2; !names.insert(own).second; ++n) own = fmt::format("{}_{}", name, n);
      files.push_back({i, own, stat.size});
    }
    std::error_code failed;
    const auto own_bytes = static_cast<double>(fs::file_size(path_, failed));
    if (all_bytes > kMaxPackedBytes || all_bytes > kFreePackedBytes + kMaxPackedRatio * own_bytes) {
      throw Error(
          fmt::format("{}: would take {:.1f} GB when unpacked, more than kerf allows for a file of {:.3f} GB; "
                      "unpack it and give the folder",
                      path_, all_bytes / 1e9, own_bytes / 1e9));
    }
    return files;
  }

  // Writes the file, whose length is as stated, at `target`. Calls `step` after each block. Returns the fault of a
  // damaged file.
  std::string Unpack(const PackedFile& packed, const fs::path& target,
                     const std::function<void(std::uint64_t)>& step) const {
    const auto fail = [&](const std::string& why) {
      return fmt::format("{}: is damaged: '{}' can't be unpacked: {}", path_, packed.name, why);
    };
    zip_file_t* const file = zip_fopen_index(archive_, packed.index, 0);
    if (file == nullptr) return fail(zip_strerror(archive_));
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> closer(file, zip_fclose);
    std::ofstream out(target, std::ios::binary);
    std::vector<char> block(std::size_t{1} << 18);
    std::uint64_t done = 0;
    while (true) {
      const zip_int64_t count = zip_fread(file, block.data(), block.size());  // checks the CRC at the end
      if (count < 0) return fail(zip_file_strerror(file));
      if (count == 0) break;
      done += static_cast<std::uint64_t>(count);
      if (done > packed.bytes) return fail("it is longer than its header states");
      out.write(block.data(), static_cast<std::streamsize>(count));
      step(static_cast<std::uint64_t>(count));
    }
    if (done != packed.bytes) return fail("it is shorter than its header states");
    if (!out.flush()) {
      throw Error(fmt::format("{}: '{}' can't be written to {}", path_, packed.name, target.parent_path().string()));
    }
    return "";
  }

 private:
  // Returns the first bytes of a packed file; nothing if it is damaged.
  std::string ReadHead(zip_uint64_t index) const {
    std::string head(132, '\0');
    zip_file_t* const file = zip_fopen_index(archive_, index, 0);
    if (file == nullptr) return "";
    const zip_int64_t count = zip_fread(file, head.data(), head.size());
    zip_fclose(file);
    return count == static_cast<zip_int64_t>(head.size()) ? head : "";
  }

  std::string path_;
  zip_t* archive_;
};

}  // namespace

bool IsZipFile(const std::string& path) {
  std::ifstream in = OpenImageFile(path);
  std::array<char, 4> head{};
  in.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(in.gcount()));
  return begin == "PK\3\4" || begin == "PK\5\6";  // the latter: without files
}

std::vector<LeftOutFile> UnpackZip(const std::string& path, const std::string& folder,
                                   const std::function<void(double)>& progress) {
  const ZipFile zip(path);
  std::vector<LeftOutFile> left_out;
  const std::vector<PackedFile> files = zip.ListFiles(left_out);
  double all_bytes = 0;
  for (const PackedFile& file : files) all_bytes += static_cast<double>(file.bytes);
  if (all_bytes > ReadFreeDiskBytes(folder)) {
    throw Error(fmt::format("{}: {} has too little space to unpack {:.2f} GB; unpack it elsewhere and give the folder",
                            path, fs::path(folder).parent_path().string(), all_bytes / 1e9));
  }
  std::size_t unpacked = 0;
  for (const PackedFile& file : files) {
    fs::path target = fs::path(folder) / file.name;
    std::error_code failed;
    fs::create_directories(target.parent_path(), failed);
    // A file may have the name of another one's folder.
    if (failed || fs::is_directory(target, failed)) target = fs::path(folder) / fmt::format("file_{}", file.index);
    const std::string fault = zip.Unpack(file, target, [&progress](std::uint64_t) {
      if (progress) progress(0);
    });
    if (fault.empty()) {
      ++unpacked;
      continue;
    }
    fs::remove(target, failed);
    left_out.push_back({target.string(), "damaged in the ZIP file", fault, true});
  }
  if (unpacked == 0 && !left_out.empty()) throw Error(left_out.front().fault);
  return left_out;
}

}  // namespace kerf
