// What a process that reads other people's files may not do.
#pragma once

namespace kerf {

/// From here on this process can't make, open for writing, rename or remove files, start programs or processes, or
/// open sockets: such calls fail with EPERM. What is open stays usable. Can't be undone. False when the system has no
/// such filter (a kernel without seccomp, another processor than x86-64): then nothing is forbidden.
bool ForbidSideEffects();

}  // namespace kerf
