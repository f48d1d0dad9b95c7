#include "session/scene/edit_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "base/toml/toml_document.h"
#include "kerf/error.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

constexpr std::string_view kMark = "# kerf tune: ";

std::vector<std::string> SplitLines(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end == std::string::npos ? end : end - at));
    if (end == std::string::npos) break;
    at = end + 1;
  }
  return lines;
}

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

const TomlNode* FindTable(const TomlNode& root, const std::string& path) {
  const TomlNode* node = &root;
  std::size_t at = 0;
  while (node != nullptr && at <= path.size()) {
    const std::size_t end = std::min(path.find('.', at), path.size());
    node = node->Find(path.substr(at, end - at));
    at = end + 1;
  }
  return node;
}

std::size_t FindHeader(const std::vector<std::string>& lines, const std::string& table) {
  const std::string header = "[" + table + "]";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t first = lines[i].find_first_not_of(" \t");
    if (first != std::string::npos && lines[i].compare(first, header.size(), header) == 0) return i;
  }
  return lines.size();
}

/// Sets the value and returns the index of the line that holds the key.
std::size_t SetValue(std::vector<std::string>& lines, const std::string& file, const SceneEdit& edit) {
  const TomlNode root = ParseToml(JoinLines(lines), file);
  const TomlNode* table = FindTable(root, edit.table);
  const TomlNode* old = table ? table->Find(edit.key) : nullptr;
  if (old != nullptr) {
    const auto number = static_cast<std::size_t>(old->line - 1);
    std::string& line = lines.at(number);
    const std::size_t from = line.find('=', static_cast<std::size_t>(old->column - 1));
    if (from == std::string::npos) return number;  // the caller detects that the value was not set
    const std::size_t value = line.find_first_not_of(" \t", from + 1);
    if (value == std::string::npos) return number;
    const std::size_t end = std::min(line.find_first_of(" \t#\r,}", value), line.size());
    line.replace(value, end - value, edit.value);
    return number;
  }
  const std::string line = edit.key + " = " + edit.value;
  const std::size_t header = FindHeader(lines, edit.table);
  if (header < lines.size()) {
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(header) + 1, line);
    return header + 1;
  }
  if (!lines.empty() && !lines.back().empty()) lines.emplace_back();
  lines.push_back("[" + edit.table + "]");
  lines.push_back(line);
  return lines.size() - 1;
}

void ListValues(const TomlNode& node, const std::string& path, std::map<std::string, std::string>& values) {
  if (node.kind != TomlNode::Kind::kTable && node.kind != TomlNode::Kind::kArray) values[path] = node.Show();
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    const TomlNode& child = node.children[i];
    const std::string name = node.kind == TomlNode::Kind::kArray ? fmt::format("[{}]", i) : child.key;
    ListValues(child, path.empty() ? name : fmt::format("{}.{}", path, name), values);
  }
}

/// Returns all values by their full key, such as "bone.block.voxel_mm".
std::map<std::string, std::string> ListValues(const TomlNode& root) {
  std::map<std::string, std::string> values;
  ListValues(root, "", values);
  return values;
}

Error Refuse(const std::string& file, const std::vector<SceneEdit>& edits) {
  std::string values;
  for (const SceneEdit& edit : edits) values += fmt::format("\n  [{}] {} = {}", edit.table, edit.key, edit.value);
  return Error(fmt::format("{}: these values can't be set automatically; edit the file to set:{}", file, values));
}

/// Throws kerf::Error if the value is not one in TOML.
std::string ShowValue(const SceneEdit& edit) {
  try {
    return ParseToml("x = " + edit.value, "").Find("x")->Show();
  } catch (const Error&) {
    throw Error(fmt::format("the value of {}.{} is not valid TOML: {} (a text needs quotes)", edit.table, edit.key,
                            edit.value));
  }
}

}  // namespace

std::string EditSceneText(const std::string& text, const std::string& file, const std::vector<SceneEdit>& edits,
                          const std::string& note) {
  std::vector<std::string> lines = SplitLines(text);
  std::erase_if(lines, [](const std::string& line) { return line.compare(0, kMark.size(), kMark) == 0; });
  // A new key is inserted directly after its table's header, so the edits are applied in reverse order.
  for (auto edit = edits.rbegin(); edit != edits.rend(); ++edit) SetValue(lines, file, *edit);
  if (!note.empty() && !edits.empty()) {
    std::vector<std::string> probe = lines;
    std::size_t at = lines.size();
    for (const SceneEdit& edit : edits) at = std::min(at, SetValue(probe, file, edit));
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), std::string(kMark) + note);
  }
  std::string edited = JoinLines(lines);
  // Check that each value is set and that all others are unchanged.
  std::map<std::string, std::string> expected = ListValues(ParseToml(text, file));
  for (const SceneEdit& edit : edits) {
    expected[edit.table + "." + edit.key] = ShowValue(edit);
  }
  if (ListValues(ParseToml(edited, file)) != expected) throw Refuse(file, edits);
  return edited;
}

std::string EditScene(const std::string& text, const std::string& file, const std::vector<SceneEdit>& edits,
                      const std::string& note) {
  ParseScene(text, file);  // throws if the text is not a scene
  try {
    std::string edited = EditSceneText(text, file, edits, note);
    ParseScene(edited, file);
    return edited;
  } catch (const Error&) {
    throw Refuse(file, edits);
  }
}

}  // namespace kerf
