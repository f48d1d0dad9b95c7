// Scene texts for the tests of this folder.
#pragma once

#include <string>

#include "kerf/error.h"
#include "session/scene/scene.h"
#include "support/message_of.h"

namespace kerf::test {

/// Returns a short valid scene that ends in an open table of strokes, so that `key = value` lines may follow.
inline std::string ShortScene() {
  return "[bone]\n"
         "model = \"block\"\n"
         "[[path.stroke]]\n"
         "start_mm = [0, 0, 0]\n"
         "end_mm = [1, 0, 0]\n"
         "feed_mm_per_s = 3\n"
         "disc_normal = [0, 1, 0]\n";
}

/// Returns the error message of ParseScene() for a text; "" if it accepts the text.
inline std::string MessageFor(const std::string& text, const std::string& file = "s.toml") {
  return test::MessageOf([&] { ParseScene(text, file); });
}

}  // namespace kerf::test
