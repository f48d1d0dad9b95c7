// Replacement for the pictures in a build without VTK.
#include "base/core/not_built.h"
#include "view/picture/image.h"
#include "view/picture/layout.h"
#include "view/picture/panel_sheet.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

[[noreturn]] void Fail() {
  FailNotBuilt("pictures", "KERF_WITH_PICTURES");
}

}  // namespace

const bool kPicturesBuilt = false;
std::string FindLackOfPictures() {
  return "No pictures: this kerf was built without them (KERF_WITH_PICTURES=OFF).";
}
Layout::Layout(const PictureSpec&) {
  Fail();
}
void WritePng(const Image&, const std::string&) {
  Fail();
}
Image RenderPicture(const PictureSpec&) {
  Fail();
}
void WritePicture(const PictureSpec&, const std::string&) {
  Fail();
}
Image RenderSheet(const SheetSpec&, std::vector<PanelPlace>*) {
  Fail();
}
void WriteSheet(const SheetSpec&, const std::string&) {
  Fail();
}

}  // namespace kerf
