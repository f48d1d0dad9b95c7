#include "base/files/installed.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace kerf {
namespace {

namespace fs = std::filesystem;

TEST(Installed, ProgramFolderContainsTheTest) {
  EXPECT_TRUE(fs::exists(fs::path(FindProgramFolder()) / "files_test"));
}

// tests/library/installed.py tests an installed kerf.
TEST(Installed, InputsOfAProgramThatIsNotInstalledStayAsTheyAre) {
  for (const char* path : {"", "scenes/body_osteotomy.toml", "/scenes/none.toml", "../x.toml"}) {
    EXPECT_EQ(FindInput(path), path);
  }
}

}  // namespace
}  // namespace kerf
