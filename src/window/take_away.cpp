#include "window/take_away.h"

#include "files/files.h"

namespace kerf {

std::string DoTakeAway(TakeAwayOrder& order) {
  MakeFolder(order.folder);
  return order.folder;
}

}  // namespace kerf
