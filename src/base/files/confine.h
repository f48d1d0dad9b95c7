// Restrictions on a process that reads untrusted files.
#pragma once

namespace kerf {

/// From now on, prevents this process from creating, writing, renaming or removing files, starting programs or
/// processes, and opening sockets: such calls fail with EPERM. Files that are already open stay usable. Cannot be
/// undone. Returns false and forbids nothing if the system has no such filter (a kernel without seccomp, a processor
/// other than x86-64).
bool ForbidSideEffects();

}  // namespace kerf
