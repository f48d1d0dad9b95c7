// Manifest and texts of a project's ZIP file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "session/project/zip_file.h"

namespace kerf::project_detail {

/// What the manifest states.
struct Manifest {
  std::string title;
  std::string scene_name;
  std::string created;
  std::string version;
  struct Member {
    std::string name;
    std::uint64_t bytes = 0;
    std::string digest;  // hexadecimal
  };
  std::vector<Member> members;
  std::vector<std::string> recordings;  // names of members, in order

  const Member* Find(std::string_view name) const {
    const auto found = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.name == name; });
    return found == members.end() ? nullptr : &*found;
  }
};

struct ProjectTexts {
  Manifest manifest;
  std::map<std::string, std::string, std::less<>> texts;  // by member

  /// Returns a text; empty if the project has no such member.
  std::string Get(std::string_view name) const {
    const auto found = texts.find(name);
    return found == texts.end() ? std::string() : found->second;
  }
};
/// Reads and checks the manifest, compares it with the members, and unpacks the texts. Throws kerf::Error with one
/// sentence; `path` is the name of the file in it.
ProjectTexts ReadProjectTexts(const ZipReader& zip, const std::string& path);
/// Throws kerf::Error if a member has not the digest that the manifest states.
void CheckMemberDigest(const Manifest& manifest, const std::string& name, const Digest& digest,
                       const std::string& path);

/// Texts of single members, with the same errors.
std::map<std::string, std::string> ParseSettings(const std::string& text, const std::string& path);

}  // namespace kerf::project_detail
