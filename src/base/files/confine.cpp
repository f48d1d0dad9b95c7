#include "base/files/confine.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kerf {
#if defined(__x86_64__)
namespace {

// System calls that are refused regardless of their arguments.
constexpr std::uint32_t kForbidden[] = {__NR_execve,
                                        __NR_execveat,
                                        __NR_fork,
                                        __NR_vfork,
                                        __NR_ptrace,
                                        __NR_kill,
                                        __NR_socket,
                                        __NR_socketpair,
                                        __NR_connect,
                                        __NR_bind,
                                        __NR_creat,
                                        __NR_unlink,
                                        __NR_unlinkat,
                                        __NR_rename,
                                        __NR_renameat,
                                        __NR_renameat2,
                                        __NR_link,
                                        __NR_linkat,
                                        __NR_symlink,
                                        __NR_symlinkat,
                                        __NR_mkdir,
                                        __NR_mkdirat,
                                        __NR_rmdir,
                                        __NR_mknod,
                                        __NR_mknodat,
                                        __NR_truncate,
                                        __NR_chmod,
                                        __NR_fchmod,
                                        __NR_fchmodat,
                                        __NR_chown,
                                        __NR_fchown,
                                        __NR_lchown,
                                        __NR_fchownat,
                                        __NR_utimensat,
                                        __NR_setxattr,
                                        __NR_mount,
                                        __NR_openat2,
                                        __NR_io_uring_setup,
                                        __NR_open_by_handle_at,
                                        __NR_process_vm_writev,
                                        __NR_shmget};

constexpr std::uint32_t kX32Calls = 0x40000000;  // the x32 ABI has the same calls under other numbers
constexpr std::uint32_t kWrites = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;

std::vector<sock_filter> MakeFilter() {
  const sock_filter refuse = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
  const sock_filter load_call = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  std::vector<sock_filter> filter = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      load_call,
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kX32Calls, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
  };
  for (const std::uint32_t call : kForbidden) {
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1));
    filter.push_back(refuse);
  }
  // The filter cannot read the flags of clone3, so clone3 appears to be missing; the C library then uses clone.
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_clone3, 0, 1));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS));
  // These calls are refused depending on their flags, which are in the lower half of an argument; that half is stored
  // first.
  const auto refuse_by_flags = [&](std::uint32_t call, unsigned argument, std::uint32_t flags, bool when_set) {
    const auto lower = static_cast<std::uint32_t>(offsetof(seccomp_data, args) + 8 * argument);
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4));
    filter.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, lower));
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, flags, static_cast<std::uint8_t>(when_set ? 0 : 1),
                              static_cast<std::uint8_t>(when_set ? 1 : 0)));
    filter.push_back(refuse);
    filter.push_back(load_call);
  };
  refuse_by_flags(__NR_open, 1, kWrites, true);
  refuse_by_flags(__NR_openat, 2, kWrites, true);
  refuse_by_flags(__NR_clone, 0, CLONE_THREAD, false);
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  return filter;
}

}  // namespace

bool ForbidSideEffects() {
  std::vector<sock_filter> filter = MakeFilter();
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

#else
bool ForbidSideEffects() {
  return false;
}
#endif

}  // namespace kerf
