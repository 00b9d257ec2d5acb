#include "lsmvs/colmap_adapter/prepare_workspace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "lsmvs/adapter_test/analytic_workspace.h"
#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/colmap_adapter/undistorted_masks.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// A project of one model, and shell scripts that stand in for colmap.
class PrepareWorkspaceTest : public testing::Test {
 protected:
  PrepareWorkspaceTest() {
    const TemporaryFolder source;
    MakeAnalyticWorkspace(source.path(), *MakePlane());
    fs::create_directories(project_ / "sparse");
    fs::copy(source.path() / "images", project_ / "images", fs::copy_options::recursive);
    fs::copy(source.path() / "sparse", project_ / "sparse" / "0", fs::copy_options::recursive);
  }

  ColmapRunner FakeColmap(const std::string& script) const {
    const fs::path path = folder_.path() / "fake colmap";
    WriteWholeFile(path, "#!/bin/sh\n" + script);
    fs::permissions(path, fs::perms::owner_all);
    return ColmapRunner(path);
  }
  // Does what image_undistorter does to images that are not distorted.
  static std::string CopyScript() {
    return "echo \"$@\"\nmkdir -p \"$7/stereo\" \"$7/sparse\"\ncp -r \"$3\" \"$7/images\"\n"
           "cp \"$5\"/*.bin \"$7/sparse/\"\n";
  }
  std::vector<DenseWorkspace> Prepare(const ColmapRunner& runner,
                                      const PrepareWorkspaceOptions& options = {}) const {
    return PrepareDenseWorkspaces(project_, runner, options, RunContext(1));
  }
  // Nothing of a failed attempt may be left but the log.
  void ExpectNoWorkspace() const {
    EXPECT_FALSE(fs::exists(project_ / "dense/0"));
    EXPECT_FALSE(fs::exists(project_ / "dense/.0.lsmvs-tmp"));
  }

  TemporaryFolder folder_;
  const fs::path project_ = folder_.path() / "my project";
  const fs::path log_ = project_ / "dense/image_undistorter-0.log";
};

TEST_F(PrepareWorkspaceTest, MakesTheWorkspaceOnce) {
  const auto made = Prepare(FakeColmap(CopyScript()), {.max_image_size = 1234, .image_folder = {}});
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].folder, project_ / "dense/0");
  EXPECT_TRUE(IsDenseWorkspace(made[0].folder));
  EXPECT_EQ(LoadScene(made[0]).num_views(), 6);
  EXPECT_THAT(ReadWholeFile(log_), HasSubstr("--max_image_size 1234"));
  EXPECT_FALSE(fs::exists(project_ / "dense/.0.lsmvs-tmp"));
  // The second time it is there, and colmap is not needed.
  EXPECT_EQ(Prepare(ColmapRunner("/no/such/colmap"))[0].folder, made[0].folder);
}

TEST_F(PrepareWorkspaceTest, LeftoverOfAKilledRunIsReplaced) {
  fs::create_directories(project_ / "dense/.0.lsmvs-tmp/images");
  WriteWholeFile(project_ / "dense/.0.lsmvs-tmp/images/half.png", "x");
  Prepare(FakeColmap(CopyScript()));
  EXPECT_FALSE(fs::exists(project_ / "dense/0/images/half.png"));
  EXPECT_FALSE(fs::exists(project_ / "dense/.0.lsmvs-tmp"));
}

// COLMAP would take the name of a photo to end at the blank.
TEST_F(PrepareWorkspaceTest, ColmapGetsABinaryCopyOfATextModel) {
  SparseModel model = ReadSparseModel(project_ / "sparse/0");
  const std::string old_name = model.images[2].name;
  model.images[2].name = "photo (3) of 6.png";
  fs::rename(project_ / "images" / old_name, project_ / "images" / model.images[2].name);
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    fs::remove(project_ / "sparse/0" / name);
  }
  WriteSparseModel(project_ / "sparse/0", model, SparseFormat::kText);
  const auto made = Prepare(FakeColmap(CopyScript()));
  const SparseModel undistorted = ReadSparseModel(made[0].SparseFolder());
  ExpectSameModel(undistorted, model);
  EXPECT_EQ(LoadScene(made[0]).views[2].name, "photo (3) of 6.png");
  EXPECT_FALSE(fs::exists(project_ / "dense/.0-sparse.lsmvs-tmp"));
}

TEST_F(PrepareWorkspaceTest, FailureQuotesTheLog) {
  const ColmapRunner runner = FakeColmap("echo one\necho 'E: no memory'\nexit 3\n");
  try {
    Prepare(runner);
    ADD_FAILURE();
  } catch (const ExternalToolError& error) {
    EXPECT_EQ(error.code(), ExitCode::kExternalTool);
    EXPECT_THAT(error.what(), HasSubstr("colmap image_undistorter failed with code 3: one | E: no "
                                        "memory; see " +
                                        log_.string()));
  }
  ExpectNoWorkspace();
}

TEST_F(PrepareWorkspaceTest, MissingColmapHasARemedy) {
  try {
    Prepare(ColmapRunner("/no/such/colmap"));
    ADD_FAILURE();
  } catch (const ExternalToolError& error) {
    EXPECT_THAT(error.what(), HasSubstr("set COLMAP to its path"));
  }
  ExpectNoWorkspace();
}

TEST_F(PrepareWorkspaceTest, ImagesThatDidNotComeOutAreNamed) {
  // image_undistorter returns 0 when it could not read an image.
  const ColmapRunner runner = FakeColmap(CopyScript() + "rm \"$7/images/view3.png\"\n");
  EXPECT_THAT(InputErrorOf([&] { Prepare(runner); }),
              HasSubstr("images/view3.png: could not be undistorted"));
  ExpectNoWorkspace();
  const ColmapRunner full_disk =
      FakeColmap(CopyScript() + "truncate -s 5000 \"$7/images/view3.png\"\n");
  EXPECT_THAT(InputErrorOf([&] { Prepare(full_disk); }), HasSubstr("view3.png: is cut off"));
  ExpectNoWorkspace();
}

TEST_F(PrepareWorkspaceTest, MissingPhotosAreNamedBeforeTheRun) {
  fs::remove(project_ / "images/view2.png");
  const ColmapRunner runner = FakeColmap("exit 1\n");
  EXPECT_THAT(InputErrorOf([&] { Prepare(runner); }),
              AllOf(HasSubstr("images: 1 of the model's 6 photos is missing: view2.png"),
                    HasSubstr("--skip_missing_images"), HasSubstr("--image_path")));
  EXPECT_FALSE(fs::exists(log_));
}

TEST_F(PrepareWorkspaceTest, MissingPhotosMayBeLeftOut) {
  SparseModel model = ReadSparseModel(project_ / "sparse/0");
  AddTrivialRigsAndFrames(&model);
  WriteSparseModel(project_ / "sparse/0", model);
  fs::remove(project_ / "images/view2.png");
  PrepareWorkspaceOptions options;
  options.skip_missing_images = true;
  const auto made = Prepare(FakeColmap(CopyScript()), options);
  const SparseModel left = ReadSparseModel(made[0].SparseFolder());
  EXPECT_EQ(left.images.size(), 5u);
  EXPECT_EQ(left.frames.size(), 5u);
  EXPECT_TRUE(left.warnings.empty());
  EXPECT_EQ(LoadScene(made[0]).num_views(), 5);
}

TEST_F(PrepareWorkspaceTest, AModelOfOnePhotoIsRefusedBeforeTheRun) {
  SparseModel model = ReadSparseModel(project_ / "sparse/0");
  model.images.resize(1);
  WriteSparseModel(project_ / "sparse/0", model);
  EXPECT_THAT(InputErrorOf([&] { Prepare(FakeColmap("exit 1\n")); }),
              HasSubstr("sparse/0: has one photo"));
  EXPECT_FALSE(fs::exists(log_));
}

// The fake undistorter leaves photos as they are.
TEST_F(PrepareWorkspaceTest, MasksOfAProjectAreUndistortedOnce) {
  const ColmapRunner runner = FakeColmap(CopyScript());
  Prepare(runner);
  const WorkspaceEntry entry = FindDenseWorkspaces(project_).at(0);
  MaskOptions options{(project_ / "masks").string(), true};
  EXPECT_THAT(InputErrorOf([&] { PrepareMasks(entry, options, runner, RunContext(1)); }),
              HasSubstr("--mask_path"));
  ColorImage mask(320, 240, Color(7, 7, 7));
  for (int x = 0; x < 100; ++x) mask(x, 50) = Color::Zero();
  fs::create_directories(project_ / "masks");
  WritePng(project_ / "masks/view1.png.png", mask);
  WritePng(project_ / "masks/view3.png", mask);  // named after the stem
  const std::string folder = PrepareMasks(entry, options, runner, RunContext(1));
  EXPECT_EQ(folder, (entry.workspace.RunFolder() / "masks").string());
  for (const char* name : {"view1.png", "view3.png"}) {
    const ByteImage used = ReadMask(MaskPath(folder, name));
    EXPECT_EQ(used(99, 50), 0) << name;
    EXPECT_EQ(used(100, 50), 255) << name;
  }
  EXPECT_EQ(MaskPath(folder, "view2.png"), "");
  LoadScene(entry.workspace, {.mask_folder = folder});
  // Nothing is run as long as they stay; another mask is taken up.
  PrepareMasks(entry, options, ColmapRunner("/no/such/colmap"), RunContext(1));
  WritePng(project_ / "masks/view2.png.png", mask);
  PrepareMasks(entry, options, runner, RunContext(1));
  EXPECT_NE(MaskPath(folder, "view2.png"), "");
  WritePng(project_ / "masks/view2.png.png", ColorImage(32, 24, Color::Zero()));
  EXPECT_THAT(InputErrorOf([&] { PrepareMasks(entry, options, runner, RunContext(1)); }),
              AllOf(HasSubstr("view2.png.png"), HasSubstr("is 32 x 24 pixels, but its photo is")));
  // Masks of a dense workspace are those of its images.
  WorkspaceEntry dense = entry;
  dense.sparse_folder.clear();
  EXPECT_EQ(PrepareMasks(dense, options, runner, RunContext(1)), options.mask_folder);
}

TEST_F(PrepareWorkspaceTest, CancelStopsTheChildren) {
  const ColmapRunner runner =
      FakeColmap("trap '' TERM\necho $$ > \"$7/../pid\"\nsleep 600 & sleep 600\nwait\n");
  std::atomic<bool> cancel = false;
  RunContext context(1);
  context.cancel = &cancel;
  std::thread canceller([&] {
    while (!fs::exists(project_ / "dense/pid")) std::this_thread::yield();
    cancel = true;
  });
  EXPECT_THROW(PrepareDenseWorkspaces(project_, runner, {}, context), CancelledError);
  canceller.join();
  ExpectNoWorkspace();
}

TEST(ColmapRunnerTest, ReadsTheBanner) {
  const TemporaryFolder folder;
  const auto banner = [&](const std::string& text) {
    const fs::path path = folder.path() / "colmap";
    WriteWholeFile(path, "#!/bin/sh\necho '" + text + "'\n");
    fs::permissions(path, fs::perms::owner_all);
    return ColmapRunner(path);
  };
  const ColmapRunner debian = banner("COLMAP 3.8 -- SfM\n(Commit Unknown on Unknown without CUDA)");
  EXPECT_EQ(debian.Version(), "3.8");
  EXPECT_FALSE(debian.HasCuda());
  const ColmapRunner current = banner("COLMAP 4.1.1 (Commit abc on 2026-01-01 with CUDA)");
  EXPECT_EQ(current.Version(), "4.1.1");
  EXPECT_TRUE(current.HasCuda());
  EXPECT_EQ(banner("something else").Version(), "");
  EXPECT_EQ(ColmapRunner("/no/such").Version(), "");
}

TEST(ColmapRunnerTest, EnvironmentDecidesWhichExecutable) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "my-colmap";
  WriteWholeFile(path, "#!/bin/sh\n");
  fs::permissions(path, fs::perms::owner_all);
  ::setenv("COLMAP", path.c_str(), 1);
  EXPECT_EQ(ColmapRunner().executable(), path);
  ::setenv("COLMAP", "/no/such/colmap", 1);
  EXPECT_FALSE(ColmapRunner().available());
  ::unsetenv("COLMAP");
}

TEST(ColmapRunnerTest, DeathBySignalAndUnwritableLogAreReported) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "colmap";
  WriteWholeFile(path, "#!/bin/sh\nkill -9 $$\n");
  fs::permissions(path, fs::perms::owner_all);
  const ColmapRunner runner(path);
  try {
    runner.Run({"mapper"}, folder.path() / "log", RunContext(1));
    ADD_FAILURE();
  } catch (const ExternalToolError& error) {
    EXPECT_THAT(error.what(), HasSubstr("was ended by signal 9"));
  }
  EXPECT_THROW(runner.Run({"mapper"}, "/proc/no/log", RunContext(1)), FileSystemError);
}

}  // namespace
}  // namespace lsmvs
