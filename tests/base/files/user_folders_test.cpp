// Folders of the user: from which variables they come, and which values are ignored.
#include "base/files/user_folders.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace kerf {
namespace {

/// Sets a variable, or removes it, until the end of a test.
class Variable {
 public:
  explicit Variable(const char* name) : name_(name), old_(GetVariable(name)), was_set_(std::getenv(name) != nullptr) {}
  ~Variable() { was_set_ ? Set(old_.c_str()) : Remove(); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  void Set(const char* value) { setenv(name_, value, 1); }
  void Remove() { unsetenv(name_); }

 private:
  const char* name_;
  std::string old_;
  bool was_set_;
};

TEST(UserFolders, ComeFromTheirVariableAndOtherwiseFromHome) {
  const struct {
    UserFolder folder;
    const char* variable;
    const char* in_home;
  } kCases[] = {{UserFolder::kConfig, "XDG_CONFIG_HOME", "/home of ida/.config"},
                {UserFolder::kData, "XDG_DATA_HOME", "/home of ida/.local/share"},
                {UserFolder::kCache, "XDG_CACHE_HOME", "/home of ida/.cache"}};
  Variable home("HOME");
  for (const auto& c : kCases) {
    SCOPED_TRACE(c.variable);
    Variable named(c.variable);
    home.Set("/home of ida");
    named.Set("/elsewhere");
    EXPECT_EQ(FindUserFolder(c.folder), "/elsewhere");
    for (const char* ignored : {"", "elsewhere", "./elsewhere"}) {
      named.Set(ignored);
      EXPECT_EQ(FindUserFolder(c.folder), c.in_home) << ignored;
    }
    named.Remove();
    EXPECT_EQ(FindUserFolder(c.folder), c.in_home);
    home.Set("home");
    EXPECT_EQ(FindUserFolder(c.folder), "");
    home.Remove();
    EXPECT_EQ(FindUserFolder(c.folder), "");
  }
}

}  // namespace
}  // namespace kerf
