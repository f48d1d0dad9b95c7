// Reads planes of 3D Slicer: from a file, from all files of a folder, or from those of a saved scene.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/core/printable.h"
#include "base/files/files.h"
#include "base/files/markups.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"
#include "session/plan/plan.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMarkups = ".mrk.json";
constexpr std::string_view kScene = ".mrml";
constexpr std::string_view kBundle = ".mrb";
constexpr std::string_view kOtherBone = "FibulaPlane";
constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;

void AppendUtf8(char32_t code, std::string& text) {
  const auto add = [&text](char32_t byte) { text += static_cast<char>(static_cast<unsigned char>(byte)); };
  if (code < 0x80) return add(code);
  const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;  // bytes after the first
  constexpr char32_t kFirst[] = {0, 0xC0, 0xE0, 0xF0};
  add(kFirst[more] | code >> (6 * more));
  for (int i = more - 1; i >= 0; --i) add(0x80 | (code >> (6 * i) & 0x3F));
}

/// Returns the character that a reference of XML stands for, given the text between '&' and ';'.
std::optional<char32_t> FindReferenced(std::string_view reference) {
  constexpr std::pair<std::string_view, char32_t> kNames[] = {
      {"quot", '"'}, {"apos", '\''}, {"lt", '<'}, {"gt", '>'}, {"amp", '&'}};
  for (const auto& [name, letter] : kNames) {
    if (reference == name) return letter;
  }
  if (!reference.starts_with('#')) return {};
  const bool hexadecimal = reference.starts_with("#x");
  const std::string_view digits = reference.substr(hexadecimal ? 2 : 1);
  std::uint32_t code = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, hexadecimal ? 16 : 10);
  const bool is_character = code > 0 && code < 0x110000 && (code < 0xD800 || code > 0xDFFF);
  if (error != std::errc() || end != digits.data() + digits.size() || !is_character) return {};
  return static_cast<char32_t>(code);
}

/// Returns the value of an attribute of XML with its references replaced.
std::string ReplaceReferences(std::string_view text) {
  std::string replaced;
  while (!text.empty()) {
    const std::size_t end = text.front() == '&' ? text.find(';') : std::string_view::npos;
    const auto code = end == std::string_view::npos ? std::nullopt : FindReferenced(text.substr(1, end - 1));
    if (code) {
      AppendUtf8(*code, replaced);
      text.remove_prefix(end + 1);
    } else {
      replaced += text.front();
      text.remove_prefix(1);
    }
  }
  return replaced;
}

/// Returns the text with the escapes of a URL replaced, in which a scene writes file names.
std::string Unescape(std::string text) {
  for (std::size_t at = 0; (at = text.find('%', at)) != std::string::npos; ++at) {
    unsigned int code = 0;
    const char* digits = text.data() + at + 1;
    if (at + 2 >= text.size() || std::from_chars(digits, digits + 2, code, 16).ptr != digits + 2) continue;
    text.replace(at, 3, 1, static_cast<char>(code));
  }
  return text;
}

/// Returns the markups files that a scene refers to, in its order.
std::vector<std::string> ListSceneFiles(const std::string& path) {
  const std::string text = ReadTextFile(path, kMaxFileBytes);
  if (text.find("<MRML") == std::string::npos) throw Error(fmt::format("{}: is not a scene of 3D Slicer", path));
  if (text.find("</MRML>") == std::string::npos) throw Error(fmt::format("{}: is cut off: </MRML> is missing", path));
  constexpr std::string_view kKey = "fileName=\"";
  std::vector<std::string> files;
  for (std::size_t at = 0; (at = text.find(kKey, at)) != std::string::npos;) {
    at += kKey.size();
    const std::string name = Unescape(ReplaceReferences(std::string_view(text).substr(at, text.find('"', at) - at)));
    if (!name.ends_with(kMarkups)) continue;
    std::string file = (fs::path(path).parent_path() / name).string();
    // A view that is saved in the scene refers to them again.
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(std::move(file));
  }
  return files;
}

std::vector<std::string> ListFolderFiles(const std::string& path) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().string().ends_with(kMarkups)) files.push_back(entry->path().string());
  }
  if (error) throw Error(fmt::format("{}: cannot be read: {}", path, error.message()));
  std::sort(files.begin(), files.end());
  return files;
}

/// Returns the name of a plane without one: that of its file, with '?' for what is no text.
std::string MakeName(const std::string& file) {
  const std::string name = fs::path(file).filename().string();
  return Printable(name.substr(0, name.size() - std::min(name.size(), kMarkups.size())));
}

}  // namespace

bool IsPlanesPath(const std::string& path) {
  std::error_code none;
  return path.ends_with(kMarkups) || path.ends_with(kScene) || path.ends_with(kBundle) || fs::is_directory(path, none);
}

std::vector<std::string> ListPlaneFiles(const std::string& path) {
  std::error_code none;
  if (fs::is_directory(path, none)) return ListFolderFiles(path);
  if (path.ends_with(kScene)) return ListSceneFiles(path);
  if (path.ends_with(kBundle)) {
    throw Error(fmt::format("{}: is a bundle of 3D Slicer; unpack it, and give the scene (.mrml) in it", path));
  }
  return {path};
}

std::vector<PlannedPlane> ReadPlannedPlanes(const std::string& path, std::vector<std::string>* skipped) {
  const std::vector<std::string> files = ListPlaneFiles(path);
  const bool one_file = files == std::vector{path};
  std::vector<PlaneMarkup> planned, as_cut;
  std::vector<std::string> of_skipped;
  for (const std::string& file : files) {
    const std::string text = ReadTextFile(file, kMaxFileBytes);
    std::vector<PlaneMarkup> markups = ParsePlanes(text, file);
    if (markups.empty() && one_file) markups = ParsePlaneMarkupList(text, file);  // a plane through points
    for (PlaneMarkup& markup : markups) {
      if (markup.name.empty()) markup.name = MakeName(file);
      if (!one_file && markup.name.starts_with(kOtherBone)) continue;
      markup.name = Printable(markup.name);
      if (skipped != nullptr && markup.name.ends_with(kAsCut))
        of_skipped.push_back(fmt::format("{}: '{}'", file, markup.name));
      (markup.name.ends_with(kAsCut) ? as_cut : planned).push_back(std::move(markup));
    }
  }
  if (planned.empty()) planned.swap(as_cut);
  if (planned.size() > kMaxPlanned) throw Error(fmt::format("{}: has more than {} planes", path, kMaxPlanned));
  Plan plan;
  for (const PlaneMarkup& markup : planned) {
    plan.planes.push_back({.name = MakeUniquePlaneName(plan, markup.name), .plane = markup.plane, .margin_mm = 1});
  }
  if (skipped != nullptr && !as_cut.empty()) *skipped = std::move(of_skipped);
  if (plan.planes.empty()) {
    throw Error(
        fmt::format("{}: contains no plane of 3D Slicer (a markup of type Plane in a file {})", path, kMarkups));
  }
  return plan.planes;
}

}  // namespace kerf
