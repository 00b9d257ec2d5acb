#include "lsmvs/util/error.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

namespace lsmvs {
namespace {

TEST(Error, InputErrorNamesFileFaultByteAndRemedyInOneLine) {
  const InputError error("a/b.bin", "ends too early", "copy it again", 17);
  EXPECT_STREQ(error.what(), "a/b.bin: ends too early (at byte 17); copy it again");
  EXPECT_EQ(error.code(), ExitCode::kBadInput);
  EXPECT_STREQ(InputError("a", "is empty", "").what(), "a: is empty");
}

TEST(Error, EachKindHasItsExitCode) {
  EXPECT_EQ(UsageError("x").code(), ExitCode::kUsage);
  EXPECT_EQ(FileSystemError("x", "write", ENOSPC).code(), ExitCode::kFileSystem);
  EXPECT_EQ(MemoryError("x").code(), ExitCode::kMemory);
  EXPECT_EQ(CancelledError().code(), ExitCode::kCancelled);
  EXPECT_EQ(static_cast<int>(ExitCode::kCancelled), 130);
}

TEST(Error, FileSystemErrorTellsTheReason) {
  const std::string message = FileSystemError("f", "write", ENOSPC).what();
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace lsmvs
