#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include "lsmvs/mesh/ply.h"
#include "program_runner.h"
#include "small_disk.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

size_t SizeOf(const fs::path& folder) {
  size_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += fs::file_size(entry.path()) + 4096;
  }
  return bytes;
}

// The next run, with room, ends the work: nothing half-written misleads it.
void ExpectNothingHalfWritten(const fs::path& workspace) {
  EXPECT_TRUE(FindLeftovers(workspace).empty());
  for (const char* name : {"meshed-visibility.ply", "meshed-refined.ply"}) {
    if (fs::exists(workspace / name)) ReadMeshPly(workspace / name);  // throws if it is cut off
  }
}

// What cannot fit is refused before anything is done.
TEST(WriteFailure, TooSmallADiskIsRefusedBeforeTheStart) {
  const SmallWorkspace original;
  const SmallDisk disk(std::to_string(SizeOf(original.path()) / 1024 + 300) + "k");
  if (!disk.mounted()) GTEST_SKIP() << "cannot mount a file system: " << disk.reason();
  fs::copy(original.path(), disk.workspace(), fs::copy_options::recursive);
  const auto before = ReadResults(disk.workspace());
  ExpectError(RunProgram("lsmvs-mesher", {disk.workspace().string()}), 4,
              {disk.workspace().string(), "MB of disk", "are free", "make room"});
  auto after = ReadResults(disk.workspace());
  after.erase("lsmvs/run.lock");
  EXPECT_EQ(after, before);
}

TEST(WriteFailure, FullDisk) {
  const SmallWorkspace original;
  // Room for the input and more and more of the results.
  for (const size_t extra : {20, 200, 500, 900}) {
    const SmallDisk disk(std::to_string(SizeOf(original.path()) / 1024 + extra) + "k");
    if (!disk.mounted()) GTEST_SKIP() << "cannot mount a file system: " << disk.reason();
    fs::copy(original.path(), disk.workspace(), fs::copy_options::recursive);
    ExpectError(RunProgram("lsmvs-mesher", {disk.workspace().string(), "--ignore_disk_space", "1"}),
                4, {disk.workspace().string(), "No space left"});
    ExpectNothingHalfWritten(disk.workspace());
  }
}

TEST(WriteFailure, ReadOnlyDisk) {
  const SmallWorkspace original;
  const SmallDisk disk("20m");
  if (!disk.mounted()) GTEST_SKIP() << "cannot mount a file system: " << disk.reason();
  fs::copy(original.path(), disk.workspace(), fs::copy_options::recursive);
  disk.MakeReadOnly();
  ExpectError(RunProgram("lsmvs-mesher", {disk.workspace().string()}), 4,
              {disk.workspace().string(), "Read-only"});
}

TEST(WriteFailure, FilesLimitedInSize) {
  const SmallWorkspace workspace;
  ProgramOptions options;
  options.before_exec = [] {
    const rlimit limit = {20000, 20000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::signal(SIGXFSZ, SIG_IGN);
  };
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text()}, options), 4,
              {workspace.text(), "too large"});
  ExpectNothingHalfWritten(workspace.path());
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
}

TEST(WriteFailure, OutputFolderThatCannotBeMade) {
  const SmallWorkspace workspace;
  WriteText(workspace / "file", "");
  ExpectError(
      RunProgram("lsmvs", {"visibility_mesher", "--input_path", workspace.text(), "--input_type",
                           "sparse", "--output_path", (workspace / "file/m.ply").string()}),
      4, {"file"});
}

}  // namespace
}  // namespace lsmvs
