#define GL_GLEXT_PROTOTYPES
#include "view/ui/ui_prop.h"

#include <GL/glcorearb.h>
#include <backends/imgui_impl_opengl3.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>

#include <cstdint>
#include <map>

namespace kerf {

vtkStandardNewMacro(UiProp);

struct UiProp::State {
  struct Slot {
    GLuint id = 0;
    std::uint64_t version = 0;
    bool stale = true;
    Image image;  // until it is uploaded
  };
  bool made = false;
  bool fonts_stale = true;
  // Dear ImGui refers to a texture by the address of its slot, because OpenGL's name is not known before the upload.
  std::map<std::string, Slot> slots;
};

UiProp::UiProp() : state_(std::make_unique<State>()) {}
UiProp::~UiProp() = default;

void UiProp::RenewFonts() {
  state_->fonts_stale = true;
}

ImTextureID UiProp::Texture(const std::string& slot, const Image& image, std::uint64_t version) {
  State::Slot& s = state_->slots[slot];
  if (s.image.pixels.empty() || s.version != version) {
    s.version = version;
    s.image = image;
    s.stale = true;
  }
  return reinterpret_cast<ImTextureID>(&s);
}

int UiProp::RenderOverlay(vtkViewport* viewport) {
  ImDrawData* data = ImGui::GetDrawData();
  auto* renderer = vtkOpenGLRenderer::SafeDownCast(viewport);
  if (renderer == nullptr || data == nullptr) return 0;
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetVTKWindow());
  if (window == nullptr) return 0;
  State& s = *state_;
  vtkOpenGLState& state = *window->GetState();
  window->GetShaderCache()->ReleaseCurrentShader();
  state.vtkglActiveTexture(GL_TEXTURE0);
  if (!s.made) {
    ImGui_ImplOpenGL3_Init("#version 330 core");
    s.made = true;
  }
  if (s.fonts_stale) {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
    s.fonts_stale = false;
  }
  ImGui_ImplOpenGL3_NewFrame();
  for (auto& [name, slot] : s.slots) {
    if (!slot.stale) continue;
    if (slot.id == 0) glGenTextures(1, &slot.id);
    glBindTexture(GL_TEXTURE_2D, slot.id);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, slot.image.width, slot.image.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                 slot.image.pixels.data());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
      glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
    }
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) {
      glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
    }
    glBindTexture(GL_TEXTURE_2D, 0);
    slot.stale = false;
  }
  for (int i = 0; i < data->CmdListsCount; ++i) {
    for (ImDrawCmd& command : data->CmdLists[i]->CmdBuffer) {
      for (auto& [name, slot] : s.slots) {
        if (command.TextureId == &slot) {
          // The backend of Dear ImGui takes OpenGL's name of a texture in place of an address.
          command.TextureId =
              reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(slot.id));  // NOLINT(performance-no-int-to-ptr)
        }
      }
    }
  }
  ImGui_ImplOpenGL3_RenderDrawData(data);
  state.Reset();
  return 1;
}

void UiProp::ReleaseGraphicsResources(vtkWindow* window) {
  State& s = *state_;
  for (auto& [name, slot] : s.slots) {
    if (slot.id != 0) glDeleteTextures(1, &slot.id);
  }
  s.slots.clear();
  if (s.made) ImGui_ImplOpenGL3_Shutdown();
  s.made = false;
  s.fonts_stale = true;
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace kerf
