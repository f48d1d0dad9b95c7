#define GL_GLEXT_PROTOTYPES
#include "view/live/text_atlas.h"

#include <GL/glcorearb.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>

namespace kerf {

void TextAtlas::Begin() {
  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  const std::vector<std::uint8_t> blank(static_cast<std::size_t>(kSide) * kSide, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, kSide, kSide, 0, GL_RED, GL_UNSIGNED_BYTE, blank.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  places_.clear();
  row_top_ = row_height_ = next_left_ = 0;
}

TextAtlas::Place TextAtlas::Find(const std::string& text, int size, bool bold, bool upward, bool& kept) {
  kept = true;
  const auto key = std::make_tuple(text, size, bold, upward);
  if (const auto at = places_.find(key); at != places_.end()) return at->second;
  if (texture_ == 0) Begin();

  const vtkNew<vtkTextProperty> property;
  property->SetFontFamilyToArial();
  property->SetFontSize(size);
  property->SetBold(bold ? 1 : 0);
  property->SetColor(1, 1, 1);
  property->SetJustificationToLeft();
  property->SetVerticalJustificationToTop();
  property->SetOrientation(upward ? 90 : 0);
  const vtkNew<vtkImageData> image;
  int dims[2] = {0, 0};
  constexpr int kDpi = 72;  // makes a point equal a pixel
  vtkTextRenderer& renderer = *vtkTextRenderer::GetInstance();
  renderer.SetScaleToPowerOfTwo(false);
  const bool drawn = renderer.RenderString(property, vtkStdString(text), image, dims, kDpi);
  renderer.SetScaleToPowerOfTwo(true);  // as VTK's own text expects
  if (!drawn) return {};
  int extent[6];
  image->GetExtent(extent);
  Place place;
  place.width = std::min(kSide - 2, extent[1] - extent[0] + 1);
  place.height = std::min(kSide - 2, extent[3] - extent[2] + 1);
  if (place.width <= 0 || place.height <= 0) return {};
  // VTK counts rows upwards from the text's anchor, its top left.
  place.offset_x = extent[0];
  place.offset_y = -extent[3];
  if (next_left_ + place.width + 1 > kSide) {
    row_top_ += row_height_ + 1;
    row_height_ = 0;
    next_left_ = 0;
  }
  if (row_top_ + place.height + 1 > kSide) {
    kept = false;
    Begin();
  }
  place.left = next_left_;
  place.top = row_top_;
  next_left_ += place.width + 1;
  row_height_ = std::max(row_height_, place.height);

  std::vector<std::uint8_t> alpha(static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height));
  const auto* pixels = static_cast<const std::uint8_t*>(image->GetScalarPointer());
  const int bytes = image->GetNumberOfScalarComponents();
  const int stride = (extent[1] - extent[0] + 1) * bytes;
  const int rows = extent[3] - extent[2] + 1;
  for (int row = 0; row < place.height; ++row) {
    for (int column = 0; column < place.width; ++column) {
      alpha[static_cast<std::size_t>(row) * static_cast<std::size_t>(place.width) + static_cast<std::size_t>(column)] =
          pixels[(rows - 1 - row) * stride + column * bytes + bytes - 1];
    }
  }
  glBindTexture(GL_TEXTURE_2D, texture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, place.left, place.top, place.width, place.height, GL_RED, GL_UNSIGNED_BYTE,
                  alpha.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  places_[key] = place;
  return place;
}

void TextAtlas::Release() {
  if (texture_ != 0) glDeleteTextures(1, &texture_);
  texture_ = 0;
  places_.clear();
}

}  // namespace kerf
