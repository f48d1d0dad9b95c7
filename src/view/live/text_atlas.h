// Words as pictures, drawn once each and kept together in one texture.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace kerf {

/// In the context that is current. Places are in texels of the texture.
class TextAtlas {
 public:
  static constexpr int kSide = 2048;

  struct Place {
    int left = 0;
    int top = 0;
    int width = 0;
    int height = 0;
    int offset_x = 0;  // from where the words begin to the picture's left edge, pixels
    int offset_y = 0;  // from the line's top to the picture's top
  };

  /// `size` in pixels. The place is good until a call of Find() that returns false in `kept`: then the texture was full
  /// and has been begun anew.
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
