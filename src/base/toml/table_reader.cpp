#include "base/toml/table_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/core/nearest_name.h"

namespace kerf {
namespace {

using Kind = TomlNode::Kind;

const char* KindName(Kind kind) {
  switch (kind) {
    case Kind::kTable:
      return "a table";
    case Kind::kArray:
      return "a list";
    case Kind::kText:
      return "a string";
    case Kind::kInteger:
    case Kind::kReal:
      return "a number";
    case Kind::kBool:
      return "true or false";
    case Kind::kOther:
      return "a date or time";
  }
  return "something else";
}

/// Returns the valid key that `key` probably means, or "". The most common mistake is to leave out the unit.
std::string FindIntendedKey(const std::string& key, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word.size() > key.size() && word.compare(0, key.size() + 1, key + "_") == 0) return word;
  }
  return FindNearestName(key.substr(0, 100), words);
}

bool IsNumber(const TomlNode& node) {
  return node.kind == Kind::kInteger || node.kind == Kind::kReal;
}

}  // namespace

TableReader::TableReader(const TomlNode& table, std::string name, Faults& faults)
    : table_(table), name_(std::move(name)), faults_(faults) {}

bool TableReader::Known(const char* key) const {
  return std::find(known_.begin(), known_.end(), key) != known_.end();
}

const TomlNode* TableReader::Take(const char* key) {
  if (!Known(key)) known_.emplace_back(key);
  return table_.Find(key);
}

void TableReader::WrongType(const TomlNode& node, const std::string& wanted) {
  const bool plain = node.kind != Kind::kTable && node.kind != Kind::kArray && node.kind != Kind::kOther;
  faults_.Add(node.line, node.column,
              plain ? fmt::format("{} = {} is {}; it must be {}", node.key, node.Show(), KindName(node.kind), wanted)
                    : fmt::format("{} is {}; it must be {}", node.key, KindName(node.kind), wanted));
}

bool TableReader::CheckNumber(const TomlNode& at, const std::string& shown_key, const TomlNode& node, Range range,
                              std::string_view unit) {
  const std::string fault = FindRangeFault(node.real, range, unit);
  if (!fault.empty()) faults_.Add(at.line, at.column, fmt::format("{} = {} {}", shown_key, node.Show(), fault));
  return fault.empty();
}

void TableReader::operator()(const char* key, double& value, Range range, const char*) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return;
  const std::string_view unit = UnitOfKey(key);
  if (!IsNumber(*node)) return WrongType(*node, fmt::format("a number from {}", ShowRange(range, unit)));
  if (CheckNumber(*node, key, *node, range, unit)) value = node->real + 0.0;  // makes 0 of -0, which would be shown
}

void TableReader::operator()(const char* key, int& value, Range range, const char*) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return;
  const std::string_view unit = UnitOfKey(key);
  if (node->kind != Kind::kInteger) {
    return WrongType(*node, fmt::format("a whole number from {}", ShowRange(range, unit)));
  }
  if (CheckNumber(*node, key, *node, range, unit)) value = static_cast<int>(node->integer);
}

void TableReader::operator()(const char* key, bool& value, const char*) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return;
  if (node->kind != Kind::kBool) return WrongType(*node, "true or false");
  value = node->boolean;
}

bool TableReader::ReadNumbers(const char* key, double* values, std::size_t count, Range range,
                              const std::string& wanted) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return false;
  if (node->kind != Kind::kArray) {
    WrongType(*node, wanted);
    return false;
  }
  if (node->children.size() != count) {
    faults_.Add(node->line, node->column,
                fmt::format("{} has {} items; it must be {}", key, node->children.size(), wanted));
    return false;
  }
  bool good = true;
  for (std::size_t i = 0; i < count; ++i) {
    const TomlNode& item = node->children[i];
    const std::string shown_key = fmt::format("{}[{}]", key, i);
    if (!IsNumber(item)) {
      faults_.Add(
          item.line, item.column,
          fmt::format("{} = {} is {}; {} must be {}", shown_key, item.Show(), KindName(item.kind), key, wanted));
      good = false;
    } else if (!CheckNumber(item, shown_key, item, range, UnitOfKey(key))) {
      good = false;
    } else {
      values[i] = item.real;
    }
  }
  return good;
}

void TableReader::operator()(const char* key, Vec3& value, Range range, const char*) {
  std::array<double, 3> xyz{};
  const std::string wanted = fmt::format("a list of three numbers [x, y, z] from {}", ShowRange(range, UnitOfKey(key)));
  if (ReadNumbers(key, xyz.data(), xyz.size(), range, wanted)) value = {xyz[0], xyz[1], xyz[2]};
}

void TableReader::operator()(const char* key, Quat& value, const char*) {
  std::array<double, 4> wxyz{};
  if (!ReadNumbers(key, wxyz.data(), wxyz.size(), Range{-1.000001, 1.000001}, "a unit quaternion [w, x, y, z]")) return;
  const double length = std::hypot(std::hypot(wxyz[0], wxyz[1]), std::hypot(wxyz[2], wxyz[3]));
  if (std::abs(length - 1) > 1e-6) {
    return Fault(key, fmt::format("{} has length {:.7g}; it must be a unit quaternion [w, x, y, z]", key, length));
  }
  value = Quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

void TableReader::operator()(const char* key, std::string& value, const Choices& choices, const char*) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return;
  const std::string wanted = fmt::format("\"{}\"", fmt::join(choices.words, "\" or \""));
  if (node->kind != Kind::kText) return WrongType(*node, wanted);
  if (std::find(choices.words.begin(), choices.words.end(), node->text) == choices.words.end()) {
    faults_.Add(node->line, node->column, fmt::format("{} = {} is unknown; it must be {}", key, node->Show(), wanted));
    return;
  }
  value = node->text;
}

void TableReader::operator()(const char* key, std::string& value, TextLimit limit, const char*) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return;
  const std::string wanted = fmt::format("a string on one line of at most {} characters", limit.characters);
  if (node->kind != Kind::kText) return WrongType(*node, wanted);
  const bool one_line = std::all_of(node->text.begin(), node->text.end(),
                                    [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f; });
  if (node->text.size() > limit.characters || !one_line) {
    faults_.Add(node->line, node->column, fmt::format("{} must be {}", key, wanted));
    return;
  }
  value = node->text;
}

const TomlNode* TableReader::Table(const char* key) {
  const TomlNode* node = Take(key);
  if (node == nullptr) return nullptr;
  if (node->kind == Kind::kTable) return node;
  WrongType(*node, "a table");
  return nullptr;
}

std::vector<const TomlNode*> TableReader::Tables(const char* key, std::size_t limit) {
  std::vector<const TomlNode*> tables;
  const TomlNode* node = Take(key);
  if (node == nullptr) return tables;
  if (node->kind != Kind::kArray) {
    WrongType(*node, "a list of tables");
    return tables;
  }
  if (node->children.size() > limit) {
    Fault(key, fmt::format("{} tables '{}'; at most {} are allowed", node->children.size(), key, limit));
    return tables;
  }
  for (const TomlNode& item : node->children) {
    if (item.kind == Kind::kTable) {
      tables.push_back(&item);
    } else {
      faults_.Add(item.line, item.column, fmt::format("{} = {} must be a table", key, item.Show()));
    }
  }
  return tables;
}

void TableReader::Require(const char* key) {
  if (Take(key) == nullptr) faults_.Add(table_.line, table_.column, fmt::format("{} has no {}", name_, key));
}

void TableReader::Fault(const char* key, const std::string& what) {
  const TomlNode* node = Take(key);
  const TomlNode& at = node == nullptr ? table_ : *node;
  faults_.Add(at.line, at.column, what);
}

void TableReader::Finish() {
  for (const TomlNode& child : table_.children) {
    if (faults_.full()) return;
    if (std::find(known_.begin(), known_.end(), child.key) != known_.end()) continue;
    const std::string nearest = FindIntendedKey(child.key, known_);
    const std::string help = nearest.empty() ? fmt::format("valid keys: {}", fmt::join(known_, ", "))
                                             : fmt::format("the nearest valid key is \"{}\"", nearest);
    faults_.Add(child.line, child.column, fmt::format("unknown key \"{}\" in {}; {}", child.key, name_, help));
  }
}

}  // namespace kerf
