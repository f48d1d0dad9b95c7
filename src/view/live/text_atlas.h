// Cache of rendered texts in one texture.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace kerf {

/// Text cache in the current OpenGL context. Positions are in texels of the texture.
class TextAtlas {
 public:
  static constexpr int kSide = 2048;

  struct Place {
    int left = 0;
    int top = 0;
    int width = 0;
    int height = 0;
    int offset_x = 0;  // from the text's origin to the image's left edge, pixels
    int offset_y = 0;  // from the line's top to the image's top
  };

  /// Returns the place of a text, rendering it if needed. `size` in pixels. Places stay valid until a call sets `kept`
  /// to false, which means that the texture was full and has been cleared.
  Place Find(const std::string& text, int size, bool bold, bool upward, bool& kept);
  std::uint32_t texture() const { return texture_; }
  void Release();

 private:
  void Begin();

  std::uint32_t texture_ = 0;
  std::map<std::tuple<std::string, int, bool, bool>, Place> places_;
  int row_top_ = 0;
  int row_height_ = 0;
  int next_left_ = 0;
};

}  // namespace kerf
