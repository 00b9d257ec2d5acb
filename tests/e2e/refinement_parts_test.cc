// Refinement of meshes that do not fit into the memory that is allowed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "parts_support.h"
#include "program_runner.h"
#include "small_disk.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// A relief in some photos, and a mesh of it with noise, so fine that its arrays go to the scratch
// file; made once.
class RefinementParts : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    SyntheticSceneOptions options;
    options.shape = ShapeName::kRelief;
    options.num_views = 6;
    options.width = 640;
    options.height = 480;
    SyntheticScene scene = MakeScene(options, RunContext(2));
    WriteWorkspace(folder_->path(), WorkspaceFormat::kDense, &scene, RunContext(2));
    // Without its back, which no photo sees.
    TriangleMesh mesh = scene.shape->Mesh(1.3 * scene.gsd);
    std::erase_if(mesh.faces, [&](const Eigen::Vector3i& face) {
      const Eigen::Vector3d& x = mesh.vertices[static_cast<size_t>(face[0])];
      return x.y() > 0.35 || x.z() < -0.05;
    });
    RemoveUnusedVertices(&mesh);
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      mesh.vertices[v] += 0.05 * scene.gsd * Random(7, v).Gaussian3();
    }
    ASSERT_GT(mesh.faces.size(), 300'000u);
    WriteMeshPly(Path("input.ply"), mesh, Eigen::Vector3d::Zero());
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static ProgramResult Refine(const std::string& output, std::vector<std::string> more,
                              const ProgramOptions& options = {}) {
    std::vector<std::string> arguments = {"mesh_refiner",
                                          "--workspace_path",
                                          folder_->path().string(),
                                          "--input_path",
                                          Path("input.ply").string(),
                                          "--output_path",
                                          Path(output).string(),
                                          "--MeshRefinement.num_levels",
                                          "2",
                                          "--MeshRefinement.max_num_iterations",
                                          "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram("lsmvs", arguments, options);
  }

  // Made by the first test that needs it.
  static void MakeWhole() {
    if (!fs::exists(Path("whole.ply"))) ExpectSuccess(Refine("whole.ply", {}));
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* RefinementParts::folder_ = nullptr;

TEST_F(RefinementParts, AnyNumberGivesTheBytesOfTheWhole) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  for (const std::string num_parts : {"3", "10"}) {
    const std::string output = "parts" + num_parts + ".ply";
    const ProgramResult result =
        Refine(output, {"--num_parts", num_parts, "--num_threads", num_parts == "3" ? "1" : "2"});
    ExpectSuccess(result);
    EXPECT_THAT(result.out, testing::HasSubstr("scratch file"));
    EXPECT_GT(CountOf(folder_->path(), "mesh_refiner", Path(output), "scratch_bytes"), 30e6);
    ExpectSameBytes(Path(output), Path("whole.ply"));
  }
}

TEST_F(RefinementParts, DividesByItselfAndStaysBelowMaxMemory) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const ProgramResult result = Refine("small.ply", {"--max_memory", "260MB"});
  ExpectSuccess(result);
  EXPECT_THAT(result.out, testing::HasSubstr("scratch file"));
  // What is taken within the 10 ms between two looks at the memory comes on top.
  EXPECT_LT(result.peak_bytes, 1.05 * 260e6);
  RecordProperty("peak_bytes", std::to_string(result.peak_bytes));
  ExpectSameBytes(Path("small.ply"), Path("whole.ply"));
}

TEST_F(RefinementParts, TooLittleForPhotosAndMapsIsRefused) {
  SKIP_WITH_SANITIZERS;
  ExpectError(Refine("tiny.ply", {"--max_memory", "90MB"}), 5, {"mesh_refiner", "--max_memory"});
}

// Killed behind one step after the other, each start goes on behind the last one that was finished.
TEST_F(RefinementParts, GoesOnBehindTheLevelsThatWereFinished) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const fs::path scratch = Path("scratch");
  fs::create_directories(scratch);
  const std::vector<std::string> arguments = {"--num_parts", "4", "--scratch_path",
                                              scratch.string()};
  KillBehindEach({"level_0", "level_1", "judged"}, scratch, [&](const ProgramOptions& options) {
    return Refine("steps.ply", arguments, options);
  });
  EXPECT_EQ(CountOf(folder_->path(), "mesh_refiner", Path("steps.ply"), "steps_found"), 3);
  ExpectSameBytes(Path("steps.ply"), Path("whole.ply"));
}

// The disk of scratch files is full at first, then that of the result: what stood there stays, and
// the steps that were finished are not done again.
TEST_F(RefinementParts, FullDisk) {
  SKIP_WITH_SANITIZERS;
  MakeWhole();
  const SmallDisk scratch("100m"), results("1m");
  if (!scratch.mounted()) GTEST_SKIP() << "cannot mount a file system: " << scratch.reason();
  const fs::path output = results.path() / "refined.ply";
  const std::string before = "what stood there before";
  WriteText(output, before);
  const auto refine = [&] {
    return Refine(output.string(), {"--num_parts", "2", "--scratch_path", scratch.path().string(),
                                    "--ignore_disk_space", "1", "--overwrite", "1"});
  };
  ExpectError(refine(), 4, {scratch.path().string(), "No space left", "--scratch_path"});
  EXPECT_EQ(ReadBytes(output), before);
  scratch.Resize("1g");
  ExpectError(refine(), 4, {results.path().string(), "No space left"});
  EXPECT_EQ(ReadBytes(output), before);
  EXPECT_TRUE(HasKept(scratch.path(), "judged"));
  results.Resize("100m");
  ExpectSuccess(refine());
  EXPECT_EQ(CountOf(folder_->path(), "mesh_refiner", output, "steps_found"), 3);
  EXPECT_EQ(CountCheckpoints(scratch.path()), 0u);
  ExpectSameBytes(output, Path("whole.ply"));
}

}  // namespace
}  // namespace lsmvs
