// Options of the commands that can be linked to 3D Slicer (session/link).
#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "session/link/slicer_link.h"

namespace kerf::cli {

struct LinkOption {
  bool links = false;
  IgtlServerOptions server;
};

/// Adds --igtl and the options that belong to it. Returns --igtl.
CLI::Option* AddLinkOption(CLI::App& command, LinkOption& option);
/// Listens, and prints where. Returns null if the option was not given. Throws kerf::Error.
std::shared_ptr<SlicerLink> OpenLink(const LinkOption& option);
/// Prints what was sent and received.
void SayLinkCounts(const SlicerLink& link);

}  // namespace kerf::cli
