// Surfaces that do not fit into the memory that is allowed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <string>

#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/synthetic/shuffled_cloud.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"
#include "lsmvs/util/scratch_memory.h"
#include "parts_support.h"
#include "plan_figures.h"
#include "program_runner.h"
#include "small_disk.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// A town of about 140,000 vertices, which takes about 145 MB, made once.
class SurfaceParts : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    TownOptions options;
    options.num_points = 6e5;
    WriteTown(folder_->path(), Town(options), 3, RunContext(2));
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static ProgramResult Mesh(const std::string& output, std::vector<std::string> more,
                            const ProgramOptions& options = {}) {
    std::vector<std::string> arguments = {"visibility_mesher", "--input_path",
                                          folder_->path().string(), "--output_path",
                                          Path(output).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram("lsmvs", arguments, options);
  }

  static void ExpectSameMesh(const std::string& a, const std::string& b) {
    ExpectSameBytes(Path(a), Path(b));
    ExpectSameBytes(Path(a + ".vis"), Path(b + ".vis"));
  }

  // Made by the first test that needs it.
  static void MakeWhole() {
    if (!fs::exists(Path("whole.ply"))) ExpectSuccess(Mesh("whole.ply", {}));
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* SurfaceParts::folder_ = nullptr;

TEST_F(SurfaceParts, AnyNumberGivesTheBytesOfTheWhole) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  for (const std::string num_parts : {"2", "7", "64"}) {
    const std::string output = "parts" + num_parts + ".ply";
    const ProgramResult result =
        Mesh(output, {"--num_parts", num_parts, "--num_threads", num_parts == "7" ? "1" : "2"});
    ExpectSuccess(result);
    EXPECT_THAT(result.out, testing::HasSubstr("scratch file"));
    ExpectSameMesh(output, "whole.ply");
  }
}

TEST_F(SurfaceParts, DividesByItselfAndStaysBelowMaxMemory) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const ProgramResult result = Mesh("small.ply", {"--max_memory", "145MB"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, testing::HasSubstr("scratch file"));
  EXPECT_LT(result.peak_bytes, 145e6);
  ExpectSameMesh("small.ply", "whole.ply");
}

TEST_F(SurfaceParts, TooLittleForAnyPartIsRefused) {
  SKIP_WITH_SANITIZERS;
  ExpectError(Mesh("tiny.ply", {"--max_memory", "70MB"}), 5, {"visibility_mesher", "--max_memory"});
}

TEST_F(SurfaceParts, ScratchFolderThatIsMissingIsRefused) {
  ExpectError(Mesh("x.ply", {"--num_parts", "2", "--scratch_path", Path("no").string()}), 3,
              {Path("no").string(), "--scratch_path"});
}

TEST_F(SurfaceParts, DiskThatFillsUpEndsWithAMessageAndLosesNothing) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  ProgramOptions options;
  // The first arrays fit into a file of that size, the later ones do not.
  options.before_exec = [] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {60 << 20, 60 << 20};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  ExpectError(Mesh("full.ply", {"--num_parts", "4"}, options), 4, {"scratch", "--scratch_path"});
  EXPECT_FALSE(fs::exists(Path("full.ply")));
  ExpectSuccess(Mesh("full.ply", {"--num_parts", "4"}));
  ExpectSameMesh("full.ply", "whole.ply");
}

// As the one before, where the disk is full, at several moments.
TEST_F(SurfaceParts, FullDiskEndsWithAMessageAndLosesNothing) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  for (const std::string size : {"3m", "12m", "30m"}) {
    const SmallDisk disk(size);
    if (!disk.mounted()) GTEST_SKIP() << "cannot mount a file system: " << disk.reason();
    const std::vector<std::string> arguments = {"--num_parts", "4", "--scratch_path",
                                                disk.path().string()};
    // Refused by the plan, or started all the same.
    ExpectError(Mesh("disk.ply", arguments), 4, {disk.path().string(), "--scratch_path"});
    std::vector<std::string> nevertheless = arguments;
    nevertheless.insert(nevertheless.end(), {"--ignore_disk_space", "1"});
    ExpectError(Mesh("disk.ply", nevertheless), 4, {disk.path().string(), "No space left"});
    EXPECT_FALSE(fs::exists(Path("disk.ply")));
  }
  ExpectSuccess(Mesh("disk.ply", {"--num_parts", "4"}));
  ExpectSameMesh("disk.ply", "whole.ply");
}

TEST_F(SurfaceParts, KillsAtRandomMomentsLeaveNothingBehind) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const ProgramResult undisturbed = Mesh("kill0.ply", {"--num_parts", "4"});
  ExpectSuccess(undisturbed);
  std::mt19937 random(5);
  const auto longest = static_cast<int>(undisturbed.seconds * 0.9e6);
  int num_kills = 0;
  for (int attempt = 0; attempt < 100 && num_kills < 20; ++attempt) {
    ProgramOptions options;
    options.signal_after =
        std::chrono::microseconds(std::uniform_int_distribution(1000, longest)(random));
    const ProgramResult result = Mesh("kill.ply", {"--num_parts", "4"}, options);
    num_kills += (result.signal == SIGKILL);
    if (result.signal == SIGKILL) continue;
    // It came to its end, behind steps that were kept: once more from the start.
    ExpectSuccess(result);
    ExpectSameMesh("kill.ply", "whole.ply");
    fs::remove(Path("kill.ply"));
    fs::remove(Path("kill.ply.vis"));
  }
  EXPECT_EQ(num_kills, 20);
  ExpectSuccess(Mesh("kill.ply", {"--num_parts", "4"}));
  ExpectSameMesh("kill.ply", "whole.ply");
  for (const auto& entry : fs::directory_iterator(Path("lsmvs"))) {
    EXPECT_THAT(entry.path().filename().string(),
                testing::AnyOf("run.json", "run.lock", testing::StartsWith("report")));
  }
}

// Killed behind one step after the other, each start goes on behind the last one that was finished.
TEST_F(SurfaceParts, GoesOnBehindTheStepsThatWereFinished) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const fs::path scratch = Path("scratch");
  fs::create_directories(scratch);
  const std::vector<std::string> arguments = {"--num_parts", "4", "--scratch_path",
                                              scratch.string()};
  KillBehindEach({"merged", "labels", "surface"}, scratch, [&](const ProgramOptions& options) {
    return Mesh("steps.ply", arguments, options);
  });
  EXPECT_EQ(CountOf(folder_->path(), "visibility_mesher", Path("steps.ply"), "steps_found"),
            2);  // merged and surface
  ExpectSameMesh("steps.ply", "whole.ply");
}

TEST_F(SurfaceParts, StepsOfOtherOptionsAreNotUsedAndRemoved) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  ProgramOptions options;
  options.signal_when = [&] { return HasKept(Path("lsmvs"), "labels"); };
  const std::vector<std::string> smooth = {"--num_parts", "4",
                                           "--VisibilityMeshing.quality_regularization", "2"};
  EXPECT_EQ(Mesh("other.ply", smooth, options).signal, 9);
  EXPECT_EQ(CountCheckpoints(Path("lsmvs")), 1u);
  // Whole, and with other options.
  ExpectSuccess(Mesh("other.ply", {}));
  EXPECT_EQ(CountOf(folder_->path(), "visibility_mesher", Path("other.ply"), "steps_found"), 0);
  EXPECT_EQ(CountCheckpoints(Path("lsmvs")), 0u);
  ExpectSameMesh("other.ply", "whole.ply");
}

// As a run leaves them that was killed when its results were there and its steps not yet removed.
TEST_F(SurfaceParts, StepsOfWhatIsUpToDateAreRemoved) {
  SKIP_WITH_SANITIZERS;
  const fs::path scratch = Path("left");
  fs::create_directories(scratch);
  const std::vector<std::string> arguments = {"--num_parts", "4", "--scratch_path",
                                              scratch.string()};
  ProgramOptions options;
  options.signal_when = [&] { return HasKept(scratch, "merged"); };
  EXPECT_EQ(Mesh("left.ply", arguments, options).signal, 9);
  fs::copy(scratch, Path("kept"), fs::copy_options::recursive);
  ExpectSuccess(Mesh("left.ply", arguments));
  EXPECT_EQ(CountCheckpoints(scratch), 0u);
  fs::copy(Path("kept"), scratch, fs::copy_options::recursive);
  EXPECT_EQ(CountCheckpoints(scratch), 1u);
  ExpectSuccess(Mesh("left.ply", arguments));
  EXPECT_EQ(CountCheckpoints(scratch), 0u);
}

// A run that has more memory than the one that was killed uses its steps all the same.
TEST_F(SurfaceParts, AWholeRunGoesOnBehindTheStepsOfADividedOne) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  ProgramOptions options;
  options.signal_when = [&] { return HasKept(Path("lsmvs"), "labels"); };
  const std::string filtered = Path("on.clean.ply").string();
  EXPECT_EQ(Mesh("on.ply", {"--num_parts", "4", "--filtered_cloud_path", filtered}, options).signal,
            9);
  ExpectSuccess(Mesh("on.ply", {"--filtered_cloud_path", filtered}));
  EXPECT_EQ(CountOf(folder_->path(), "visibility_mesher", Path("on.ply"), "steps_found"),
            2);  // merged and labels
  ExpectSameMesh("on.ply", "whole.ply");
  ExpectSuccess(Mesh("on2.ply", {"--filtered_cloud_path", Path("on2.clean.ply").string()}));
  ExpectSameMesh("on.clean.ply", "on2.clean.ply");
}

// Commands on a mesh that does not fit: with a scratch file the same bytes, or a refusal before the
// start.
TEST_F(SurfaceParts, LargeMeshesAreSimplifiedWithAScratchFile) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const auto simplify = [&](const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"mesh_simplifier",
                                          "--input_path",
                                          Path("whole.ply").string(),
                                          "--output_path",
                                          Path(output).string(),
                                          "--MeshSimplification.max_error",
                                          "0.1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram("lsmvs", arguments);
  };
  ExpectSuccess(simplify("simple.ply", {}));
  const ProgramResult small = simplify(
      "simple2.ply", {"--max_memory", "140MB", "--scratch_path", folder_->path().string()});
  ExpectSuccess(small);
  EXPECT_THAT(small.err, testing::HasSubstr("scratch file in " + folder_->path().string()));
  ExpectSameBytes(Path("simple.ply"), Path("simple2.ply"));
  ExpectError(simplify("x.ply", {"--max_memory", "60MB"}), 5, {"mesh_simplifier", "--max_memory"});
}

TEST_F(SurfaceParts, MeshesTooLargeToBeTracedAreRefusedBeforeTheStart) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const std::vector<std::string> evaluate = {"mesh_evaluator",
                                             "--input_path",
                                             Path("whole.ply").string(),
                                             "--ground_truth_path",
                                             Path("gt_mesh.ply").string(),
                                             "--max_memory",
                                             "90MB"};
  ExpectError(RunProgram("lsmvs", evaluate), 5,
              {"mesh_evaluator", "million faces", "--max_memory"});
  const std::vector<std::string> draw = {
      "mesh_renderer", "--input_path",         Path("whole.ply").string(),
      "--output_path", Path("x.png").string(), "--max_memory",
      "90MB"};
  ExpectError(RunProgram("lsmvs", draw), 5, {"mesh_renderer", "million faces", "--max_memory"});
  EXPECT_FALSE(fs::exists(Path("x.png")));
  const SmallWorkspace workspace;
  const std::vector<std::string> compare = {"mesh_comparer", "--workspace_path", workspace.text(),
                                            "--input_paths", Path("whole.ply").string()};
  const auto with_memory = [&](const std::string& max_memory) {
    std::vector<std::string> arguments = compare;
    arguments.insert(arguments.end(), {"--max_memory", max_memory});
    return RunProgram("lsmvs", arguments);
  };
  ExpectError(with_memory("150MB"), 5, {"mesh_comparer", "million faces", "--max_memory"});
  // What it asks for does.
  const ProgramResult enough = with_memory("250MB");
  ExpectSuccess(enough);
  EXPECT_THAT(enough.err, testing::Not(testing::HasSubstr("scratch file")));
  EXPECT_LT(enough.peak_bytes, 250e6);
}

// Outliers float in free space; what is near the surface stays.
TEST_F(SurfaceParts, FilteredCloudHasTheOutliersRemoved) {
  TownOptions options;
  options.num_points = 6e5;
  const Town town(options);
  const Scene views = town.MakeViews();
  ExpectSuccess(Mesh("filter.ply", {"--filtered_cloud_path", Path("clean.ply").string()}));
  const DenseWorkspace workspace{folder_->path()};
  const VisibilityCloud before = ReadFusedCloud(workspace.FusedPath(), views, workspace).cloud;
  const VisibilityCloud after = ReadFusedCloud(Path("clean.ply"), views, workspace).cloud;
  const auto count_far = [&](const VisibilityCloud& cloud) {
    size_t count = 0;
    for (const Eigen::Vector3f& x : cloud.positions)
      count += town.HeightAbove(x.cast<double>()) > 1;
    return count;
  };
  EXPECT_GT(after.size(), before.size() * 95 / 100);
  EXPECT_LT(after.size(), before.size());
  EXPECT_GT(count_far(before), 1000u);
  EXPECT_LT(count_far(after), count_far(before) / 10);
}

// The filter works in parts, too: same mesh, same cloud.
TEST_F(SurfaceParts, FilterOnCoarseLevelsGivesTheSameBytesInParts) {
  SKIP_WITH_SANITIZERS;
  const auto mesh = [&](const std::string& name, const std::string& num_parts) {
    const ProgramResult result =
        Mesh(name + ".ply", {"--VisibilityMeshing.filter_levels", "2", "--filtered_cloud_path",
                             Path(name + ".cloud.ply").string(), "--num_parts", num_parts,
                             "--num_threads", num_parts == "2" ? "1" : "2"});
    ExpectSuccess(result);
    EXPECT_GT(
        CountOf(folder_->path(), "visibility_mesher", Path(name + ".ply"), "filtered_vertices"), 0);
  };
  mesh("levels", "1");
  for (const std::string num_parts : {"2", "7"}) {
    const std::string name = "levels" + num_parts;
    mesh(name, num_parts);
    ExpectSameMesh(name + ".ply", "levels.ply");
    ExpectSameMesh(name + ".cloud.ply", "levels.cloud.ply");
  }
}

// A cloud of another program, with vertices far apart, so that it takes little time.
TEST(SurfacePartsOfRealScene, GiveTheBytesOfTheWhole) {
  SKIP_WITH_SANITIZERS;
  LSMVS_REQUIRE_SCENE("fountain-P11-fused");
  const TemporaryFolder folder;
  fs::copy(TestDataFolder() / "fountain-P11-fused", folder.path(), fs::copy_options::recursive);
  const auto mesh = [&](const std::string& output, const std::string& num_parts,
                        const std::string& cloud = "fused.ply") {
    ExpectSuccess(
        RunProgram("lsmvs", {"visibility_mesher", "--input_path", (folder.path() / cloud).string(),
                             "--output_path", (folder.path() / output).string(), "--num_parts",
                             num_parts, "--VisibilityMeshing.max_proj_dist", "6"}));
    return ReadBytes(folder.path() / output) + ReadBytes(folder.path() / (output + ".vis"));
  };
  const std::string whole = mesh("whole.ply", "1");
  EXPECT_GT(whole.size(), size_t{1} << 20);
  EXPECT_TRUE(mesh("parts.ply", "7") == whole);
  // In another order.
  const DenseWorkspace workspace{folder.path()};
  const Scene scene = LoadScene(workspace);
  const VisibilityCloud cloud = ReadFusedCloud(workspace.FusedPath(), scene, workspace).cloud;
  WriteFusedCloud(folder.path() / "shuffled.ply", Shuffle(cloud, 1).cloud, scene);
  EXPECT_TRUE(mesh("shuffled_whole.ply", "1", "shuffled.ply") == whole);
  EXPECT_TRUE(mesh("shuffled_parts.ply", "7", "shuffled.ply") == whole);
}

}  // namespace
}  // namespace lsmvs
