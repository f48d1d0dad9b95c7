// Reading and writing of ZIP files, with limits for files of unknown origin.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "loop/record/seal.h"

namespace kerf {

inline constexpr std::size_t kMaxZipMembers = 2000;
/// A member larger than kFreeZipBytes may have at most kMaxZipRatio times the size that it takes in the file.
inline constexpr std::uint64_t kFreeZipBytes = std::uint64_t{1} << 20;
inline constexpr std::uint64_t kMaxZipRatio = 200;

struct ZipMember {
  std::string name;  // printable ASCII without backslash
  std::uint64_t bytes = 0;
};

/// A ZIP file that is read. Throws kerf::Error with one sentence that begins with the path.
class ZipReader {
 public:
  /// Checks the directory: its consistency with the members' own headers, names, the number of members, and the ratio
  /// of sizes. Only members without encryption that are stored or deflated are accepted; names must differ.
  explicit ZipReader(const std::string& path);
  /// The same for a file in memory; `name` is its name in messages. The bytes must remain valid.
  ZipReader(std::string_view bytes, const std::string& name);
  ~ZipReader();
  ZipReader(const ZipReader&) = delete;
  ZipReader& operator=(const ZipReader&) = delete;

  const std::vector<ZipMember>& members() const;
  /// Unpacks member `i` in blocks and returns the digest of its bytes. Throws if its length or checksum is wrong.
  Digest Unpack(std::size_t i, const std::function<void(std::string_view block)>& take) const;
  /// Unpacks a member of at most `max_bytes`.
  std::string UnpackText(std::size_t i, std::size_t max_bytes, Digest* digest = nullptr) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A ZIP file that is written.
class ZipWriter {
 public:
  ZipWriter();
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  void AddText(const std::string& name, std::string text);  // compressed
  /// Stores the first `bytes` bytes of the file as they are. The file is read by Write().
  void AddFile(const std::string& name, const std::string& file, std::uint64_t bytes);
  /// Writes all members to an existing file. Throws kerf::Error that states only the reason. Call once.
  void Write(const std::string& file);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Digest of a file's content, and its length. Throws kerf::Error.
struct FileDigest {
  Digest digest{};
  std::uint64_t bytes = 0;
};
FileDigest CalcFileDigest(const std::string& path);

}  // namespace kerf
