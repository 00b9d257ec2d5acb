#include "lsmvs/util/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

size_t CountFiles(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), {}));
}

// While it lives, files of this process cannot grow beyond `num_bytes`: a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t num_bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = num_bytes;
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit before_{};
  void (*old_handler_)(int);
};

TEST(AtomicFile, CopiesFilesOfAnySize) {
  const TemporaryFolder folder;
  for (const size_t size : {0u, 1u, 5u << 20}) {
    std::string content(size, 'a');
    for (size_t i = 0; i < size; ++i) content[i] = static_cast<char>(i * i >> 7);
    WriteFileAtomically(folder.path() / "from", content);
    CopyFileAtomically(folder.path() / "from", folder.path() / "to");
    EXPECT_EQ(ReadAll(folder.path() / "to"), content);
  }
  EXPECT_THROW(CopyFileAtomically(folder.path() / "none", folder.path() / "to"), InputError);
  EXPECT_EQ(ReadAll(folder.path() / "to").size(), size_t{5} << 20);
}

TEST(AtomicFile, AppearsOnlyWithCommit) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.txt";
  AtomicFile file(path);
  file.Write("hello ");
  file.WriteValue(uint16_t{0x2121});
  EXPECT_FALSE(fs::exists(path));
  file.Commit();
  EXPECT_EQ(ReadAll(path), "hello !!");
  EXPECT_EQ(CountFiles(folder.path()), 1u);
}

TEST(AtomicFile, WithoutCommitTheOldFileStaysAndNothingIsLeft) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.txt";
  WriteFileAtomically(path, "old");
  try {
    AtomicFile file(path);
    file.Write(std::string(3 << 20, 'x'));
    throw std::runtime_error("interrupted");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(ReadAll(path), "old");
  EXPECT_EQ(CountFiles(folder.path()), 1u);
}

TEST(AtomicFile, PiecesOfAnySizeKeepTheirOrder) {
  const TemporaryFolder folder;
  std::string expected;
  AtomicFile file(folder.path() / "a.bin");
  for (const size_t size : {0u, 1u, 1000u, 1u << 20, (1u << 20) - 1, 3u << 20, 7u}) {
    const std::string piece(size, static_cast<char>('a' + expected.size() % 26));
    file.Write(piece);
    expected += piece;
  }
  file.Commit();
  EXPECT_TRUE(ReadAll(folder.path() / "a.bin") == expected);
}

TEST(AtomicFile, OverwritesWhatWasWritten) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a";
  AtomicFile file(path);
  file.Write("0000");
  file.Write(std::string(3 << 20, 'x'));
  file.Overwrite(1, "23");
  file.Write("end");
  file.Overwrite(0, "1");
  file.Commit();
  EXPECT_EQ(ReadAll(path), "1230" + std::string(3 << 20, 'x') + "end");
}

TEST(AtomicFile, MakesFoldersAndReplacesLeftOvers) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "b" / "c" / "a.txt";
  fs::create_directories(path.parent_path());
  fs::path left_over = path;
  left_over += AtomicFile::kTemporarySuffix;
  std::ofstream(left_over) << "of a killed run, and longer than the new content";
  WriteFileAtomically(path, "new");
  EXPECT_EQ(ReadAll(path), "new");
  EXPECT_FALSE(fs::exists(left_over));
  WriteFileAtomically(folder.path() / "x" / "y.txt", "1");
  EXPECT_EQ(ReadAll(folder.path() / "x" / "y.txt"), "1");
}

TEST(AtomicFile, FullDiskIsReportedAndLeavesTheOldFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.bin";
  WriteFileAtomically(path, "old");
  // Small files fail when they are committed, large ones while they are written.
  for (const size_t size : {size_t{200000}, size_t{5} << 20}) {
    try {
      const FileSizeLimit limit(100000);
      WriteFileAtomically(path, std::string(size, 'x'));
      FAIL() << "no error";
    } catch (const FileSystemError& error) {
      EXPECT_EQ(error.code(), ExitCode::kFileSystem);
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("free space"), std::string::npos);
    }
    EXPECT_EQ(ReadAll(path), "old");
    EXPECT_EQ(CountFiles(folder.path()), 1u);
  }
}

TEST(AtomicFile, PlacesThatCannotBeWrittenAreNamed) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.path() / "file", "");
  EXPECT_THROW(AtomicFile(folder.path() / "file" / "below"), FileSystemError);
  fs::create_directory(folder.path() / "folder");
  // A folder stands where the file should go: found at the end, without damage.
  EXPECT_THROW(WriteFileAtomically(folder.path() / "folder", "x"), FileSystemError);
  EXPECT_TRUE(fs::is_directory(folder.path() / "folder"));
  EXPECT_EQ(CountFiles(folder.path()), 2u);
  EXPECT_THROW(AtomicFile("/proc/nowhere/file"), FileSystemError);
  try {
    AtomicFile file("/proc/cannot-write-here");
    FAIL() << "no error";
  } catch (const FileSystemError& error) {
    EXPECT_NE(std::string(error.what()).find("/proc/cannot-write-here"), std::string::npos);
  }
}

}  // namespace
}  // namespace lsmvs
