#include "base/toml/toml_document.h"

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

// Maximum depth of nested values; those of a scene are at most about ten deep. Each level uses a stack frame here and
// in every recursion over the tree.
constexpr int kMaxDepth = 64;

TomlNode Convert(const toml::node& source, const std::string& file, int depth = 0) {
  if (depth > kMaxDepth) {
    throw Error(fmt::format("{}:{}:{}: tables and lists are nested more than {} deep; no scene needs that", file,
                            source.source().begin.line, source.source().begin.column, kMaxDepth));
  }
  TomlNode node;
  SetPosition(node, source.source());
  if (const toml::table* table = source.as_table()) {
    node.kind = TomlNode::Kind::kTable;
    for (const auto& [key, value] : *table) {
      TomlNode child = Convert(value, file, depth + 1);
      child.key = std::string(key.str());
      // toml++ places a value at its key, but a [table] at its header.
      if (key.source().begin.line > 0) SetPosition(child, key.source());
      node.children.push_back(std::move(child));
    }
    std::stable_sort(node.children.begin(), node.children.end(), [](const TomlNode& a, const TomlNode& b) {
      return a.line != b.line ? a.line < b.line : a.column < b.column;
    });
  } else if (const toml::array* array = source.as_array()) {
    node.kind = TomlNode::Kind::kArray;
    for (const toml::node& item : *array) node.children.push_back(Convert(item, file, depth + 1));
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

// Maximum number of parts of a dotted key; the keys of a scene have few. toml++ allows 256 nested values, so with this
// limit the depth stays far below the roughly 20 000 at which its recursion overflows the stack.
constexpr int kMaxKeyParts = 16;

// Throws kerf::Error if a dotted key has more parts: toml++ creates a table for each and aborts the program if there
// are too many.
void CheckKeyLengths(const std::string& text, const std::string& file) {
  int line = 1;
  int column = 0;
  int dots = 0;
  int key_line = 0;  // 0: the position is not in a key
  int key_column = 0;
  std::size_t at = 0;
  const auto take = [&](std::size_t count) {
    for (; count > 0 && at < text.size(); --count, ++at) {
      if (text[at] == '\n') {
        ++line;
        column = 0;
      } else if ((static_cast<unsigned char>(text[at]) & 0xc0) != 0x80) {  // skips continuation bytes of UTF-8
        ++column;
      }
    }
  };
  const auto end_key = [&] {
    dots = 0;
    key_line = 0;
  };
  const auto begin_key = [&] {
    if (key_line != 0) return;
    key_line = line;
    key_column = column + 1;
  };
  while (at < text.size()) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      begin_key();
      const bool many_lines = text.compare(at, 3, std::string(3, c)) == 0;
      const std::string quotes(many_lines ? 3 : 1, c);
      take(quotes.size());
      while (at < text.size() && text.compare(at, quotes.size(), quotes) != 0 && (many_lines || text[at] != '\n')) {
        take(c == '"' && text[at] == '\\' ? 2 : 1);
      }
      if (at < text.size() && text[at] == c) take(quotes.size());
      // Up to two quotes before the closing three belong to the text.
      for (int n = 0; many_lines && n < 2 && at < text.size() && text[at] == c; ++n) take(1);
    } else if (c == '#') {
      end_key();
      while (at < text.size() && text[at] != '\n') take(1);
    } else if (c == '.') {
      begin_key();
      if (++dots >= kMaxKeyParts) {
        throw Error(fmt::format("{}:{}:{}: the key has more than {} parts joined by dots; no scene key is that long",
                                file, key_line, key_column, kMaxKeyParts));
      }
      take(1);
    } else if (c == ' ' || c == '\t') {
      take(1);
    } else if (c == '\n' || c == '\r' || c == ',' || c == '=' || c == '[' || c == ']' || c == '{' || c == '}') {
      end_key();
      take(1);
    } else {
      begin_key();
      take(1);
    }
  }
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

std::string TomlNode::PlaceOf(const std::string& child_key, const std::string& file) const {
  const TomlNode* child = Find(child_key);
  const TomlNode& at = child != nullptr ? *child : *this;
  return fmt::format("{}:{}:{}", file, at.line, at.column);
}

TomlNode ParseToml(const std::string& text, const std::string& file) {
  CheckKeyLengths(text, file);
  try {
    const toml::table table = toml::parse(text, file);
    TomlNode root = Convert(table, file);
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
