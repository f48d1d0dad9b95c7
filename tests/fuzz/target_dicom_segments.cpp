#include <pthread.h>

#include <cstring>

#include "base/files/child.h"
#include "bone/import/dicom_segments.h"
#include "target.h"

// NOLINTBEGIN(bugprone-reserved-identifier): the names are the sanitizers'.
// The address sanitizer's interface; absent in a build without it.
extern "C" void __asan_set_error_report_callback(void (*)(const char*)) __attribute__((weak));
// Replaces a function of the undefined-behaviour sanitizer that is called at each report.
extern "C" void __ubsan_on_report(void);
// NOLINTEND(bugprone-reserved-identifier)

namespace kerf::fuzz {
namespace {

constexpr std::size_t kReportBytes = 16384;

/// A sanitizer's report in the child process, whose output is closed; empty if there is none.
char* Report() {
  static const SharedMemory shared(kReportBytes);
  return shared.data();
}

bool in_child = false;

void KeepReport(const char* text) {
  // GDCM requests the memory that a length states; without the sanitizer this throws std::bad_alloc.
  for (const char* what : {"out-of-memory", "allocation-size-too-big", "allocator is trying to allocate"}) {
    if (std::strstr(text, what) != nullptr) return;
  }
  std::strncpy(Report(), text, kReportBytes - 1);
}

}  // namespace

/// The file is read as the program reads it, in a child process that GDCM may end, but not a sanitizer.
KERF_FUZZ_TARGET(dicom_segments) {
  static const MemoryFolder folder;
  static const int watched = pthread_atfork(nullptr, nullptr, [] {
    in_child = true;
    if (__asan_set_error_report_callback != nullptr) __asan_set_error_report_callback(KeepReport);
  });
  if (watched != 0) Finding("the child process can't be watched");
  Report()[0] = '\0';
  const std::string path = folder.Write("f.dcm", bytes);
  Accepts([&] {
    const DicomSegments read = ReadDicomSegments(path);
    const std::size_t slice = static_cast<std::size_t>(read.size[0]) * static_cast<std::size_t>(read.size[1]);
    const std::size_t count = read.pixels.size() + read.labels.size();
    if (count != read.frames.size() * slice) Finding("the pixels are not those of the frames");
  });
  if (Report()[0] != '\0') Finding(fmt::format("in the child process: {}", Report()));
}

}  // namespace kerf::fuzz

extern "C" void __ubsan_on_report(void) {  // NOLINT(bugprone-reserved-identifier)
  if (kerf::fuzz::in_child) std::strncpy(kerf::fuzz::Report(), "undefined behaviour", kerf::fuzz::kReportBytes - 1);
}
