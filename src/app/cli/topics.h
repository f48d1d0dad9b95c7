// Help topics: `kerf help units`.
#pragma once

#include <span>
#include <string_view>

namespace kerf::cli {

struct Topic {
  const char* name;
  const char* summary;  // one line
  const char* text;     // lines of at most 80 columns, without the title
};

/// Returns all topics, in the order in which the help lists them.
std::span<const Topic> Topics();
/// Returns the topic called `name`; nullptr if there is none.
const Topic* FindTopic(std::string_view name);

}  // namespace kerf::cli
