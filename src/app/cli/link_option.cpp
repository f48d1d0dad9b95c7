#include "app/cli/link_option.h"

#include <fmt/ranges.h>

#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "base/core/number_text.h"

namespace kerf::cli {

CLI::Option* AddLinkOption(CLI::App& command, LinkOption& option) {
  CLI::Option* igtl = command.add_flag(
      "--igtl", option.links,
      "Show the session live in 3D Slicer or another program, by OpenIGTLink, and take what it sends (docs/slicer.md)");
  AddNumber(command, "--igtl-port", option.server, "port")->capture_default_str()->needs(igtl);
  AddNumber(command, "--igtl-rate", option.server, "rate_hz")->capture_default_str()->needs(igtl);
  command
      .add_option("--igtl-address", option.server.address,
                  "Numeric address of the interface on which it listens. Messages are neither encrypted nor signed: "
                  "with another address than that of this machine, anyone who can reach it can connect")
      ->capture_default_str()
      ->check(CLI::ValidIPV4)
      ->needs(igtl);
  return igtl;
}

std::shared_ptr<SlicerLink> OpenLink(const LinkOption& option) {
  if (!option.links) return nullptr;
  auto link = std::make_shared<SlicerLink>(option.server);
  Say("OpenIGTLink: listening on {}, port {}", option.server.address, link->port());
  return link;
}

void SayLinkCounts(const SlicerLink& link) {
  const IgtlCounts c = link.counts();
  Say("OpenIGTLink: peers {}, messages sent {}, frames skipped {}, messages received {}, of these refused {}", c.peers,
      c.sent, c.skipped, c.received, link.refusals());
  if (c.disconnected == 0) return;
  SayWarning("OpenIGTLink: {} disconnected: {}", FormatCount(c.disconnected, "peer was", "peers were"),
             fmt::join(c.reasons, "; "));
}

}  // namespace kerf::cli
