#include "scene/toml_document.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <string_view>

#include "kerf/error.h"

namespace kerf {
namespace {

void SetPosition(TomlNode& node, const toml::source_region& source) {
  node.line = static_cast<int>(source.begin.line);
  node.column = static_cast<int>(source.begin.column);
}

TomlNode Convert(const toml::node& source) {
  TomlNode node;
  SetPosition(node, source.source());
  if (const toml::table* table = source.as_table()) {
    node.kind = TomlNode::Kind::kTable;
    for (const auto& [key, value] : *table) {
      TomlNode child = Convert(value);
      child.key = std::string(key.str());
      // The children of a [table] stand where their key stands; a [table] itself where its header does.
      if (key.source().begin.line > 0) SetPosition(child, key.source());
      node.children.push_back(std::move(child));
    }
    std::stable_sort(node.children.begin(), node.children.end(), [](const TomlNode& a, const TomlNode& b) {
      return a.line != b.line ? a.line < b.line : a.column < b.column;
    });
  } else if (const toml::array* array = source.as_array()) {
    node.kind = TomlNode::Kind::kArray;
    for (const toml::node& item : *array) node.children.push_back(Convert(item));
  } else if (const auto* text = source.as_string()) {
    node.kind = TomlNode::Kind::kText;
    node.text = text->get();
  } else if (const auto* integer = source.as_integer()) {
    node.kind = TomlNode::Kind::kInteger;
    node.integer = integer->get();
    node.real = static_cast<double>(node.integer);
  } else if (const auto* real = source.as_floating_point()) {
    node.kind = TomlNode::Kind::kReal;
    node.real = real->get();
  } else if (const auto* boolean = source.as_boolean()) {
    node.kind = TomlNode::Kind::kBool;
    node.boolean = boolean->get();
  } else {
    node.kind = TomlNode::Kind::kOther;
    node.text = source.is_date() ? "a date" : source.is_time() ? "a time" : "a date and time";
  }
  return node;
}

}  // namespace

const TomlNode* TomlNode::Find(const std::string& child_key) const {
  for (const TomlNode& child : children) {
    if (child.key == child_key) return &child;
  }
  return nullptr;
}

std::string TomlNode::Show() const {
  switch (kind) {
    case Kind::kTable:
      return "a table";
    case Kind::kArray:
      return "a list";
    case Kind::kText:
      return text.size() > 60 ? fmt::format("\"{}...\"", text.substr(0, 60)) : fmt::format("\"{}\"", text);
    case Kind::kInteger:
      return fmt::format("{}", integer);
    case Kind::kReal:
      return fmt::format("{}", real);
    case Kind::kBool:
      return boolean ? "true" : "false";
    case Kind::kOther:
      return text;
  }
  return text;
}

TomlNode ParseToml(const std::string& text, const std::string& file) {
  try {
    const toml::table table = toml::parse(text, file);
    TomlNode root = Convert(table);
    root.line = 1;
    root.column = 1;
    return root;
  } catch (const toml::parse_error& e) {
    const toml::source_position at = e.source().begin;
    std::string what(e.description());
    std::replace(what.begin(), what.end(), '\n', ' ');
    throw Error(fmt::format("{}:{}:{}: not valid TOML: {}", file, at.line, at.column, what));
  }
}

}  // namespace kerf
