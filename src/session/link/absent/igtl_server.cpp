// Without KERF_WITH_DEVICES there is no network.
#include "session/link/igtl_server.h"
#include "base/core/not_built.h"

namespace kerf {

struct IgtlServer::State {};

IgtlServer::IgtlServer(const IgtlServerOptions&, Calls) {
  FailNotBuilt("OpenIGTLink", "KERF_WITH_DEVICES");
}
IgtlServer::~IgtlServer() = default;
int IgtlServer::port() const {
  return 0;
}
void IgtlServer::Send(int, std::shared_ptr<const std::string>) {}
void IgtlServer::WaitUntilSent(std::chrono::milliseconds) {}
IgtlCounts IgtlServer::counts() const {
  return {};
}

}  // namespace kerf
