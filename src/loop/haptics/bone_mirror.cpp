#include "loop/haptics/bone_mirror.h"

#include "bone/grid/set_leaf.h"

namespace kerf {

std::size_t BoneMirror::Update(std::size_t at_most) {
  std::size_t taken = 0;
  for (; taken < at_most; ++taken) {
    const LeafMessage* message = stream_.Peek();
    if (message == nullptr) break;
    SetCut(bone_, message->index, message->values);
    if (listener_) listener_(*message);
    stream_.Pop();
  }
  return taken;
}

}  // namespace kerf
