#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> Arguments(const SmallWorkspace& workspace, const std::string& output,
                                   const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"mesh_texturer",
                                        "--workspace_path",
                                        workspace.text(),
                                        "--input_path",
                                        (workspace / "gt_mesh.ply").string(),
                                        "--output_path",
                                        (workspace / output).string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(MeshTexturerProgram, WritesAMeshWithItsPages) {
  const SmallWorkspace workspace;
  const std::vector<std::string> whole_faces = {"--MeshTextureMapping.max_face_width", "0"};
  ExpectSuccess(RunProgram("lsmvs", Arguments(workspace, "textured", whole_faces)));
  const TexturedMesh textured = ReadTexturedPly(workspace / "textured/mesh.ply");
  std::string error;
  EXPECT_TRUE(textured.Check(&error)) << error;
  ASSERT_EQ(textured.pages.size(), 1u);
  EXPECT_EQ(textured.pages[0].filename(), "texture.png");
  EXPECT_EQ(textured.mesh.faces.size(), ReadMeshPly(workspace / "gt_mesh.ply").faces.size());
  EXPECT_EQ(ReadColors(textured.pages[0]).width, textured.page_width);
  const ProgramResult again = RunProgram("lsmvs", Arguments(workspace, "textured", whole_faces));
  ExpectSuccess(again);
  EXPECT_THAT(again.out, HasSubstr("up to date"));
}

TEST(MeshTexturerProgram, TakesColmapsArgumentsAndGivesTheSameBytesForThreads) {
  const SmallWorkspace workspace;
  const std::vector<std::string> options = {"--MeshTextureMapping.max_page_size", "256",
                                            "--MeshTextureMapping.texture_scale_factor", "3"};
  auto one = options, three = options;
  one.insert(one.end(), {"--num_threads", "1", "--max_memory", "500MB",
                         "--MeshTextureMapping.inpaint_radius", "5"});
  three.insert(three.end(), {"--num_threads", "3"});
  const ProgramResult result = RunProgram("lsmvs", Arguments(workspace, "one", one));
  ExpectSuccess(result);
  EXPECT_THAT(result.err, HasSubstr("inpaint_radius"));
  ExpectSuccess(RunProgram("lsmvs", Arguments(workspace, "three", three)));
  size_t num_files = 0;
  for (const auto& entry : fs::directory_iterator(workspace / "one")) {
    EXPECT_EQ(ReadText(entry.path()), ReadText(workspace / "three" / entry.path().filename()));
    ++num_files;
  }
  EXPECT_GT(num_files, 3u);  // several pages
  // Pages that a later run does not need go.
  ExpectSuccess(RunProgram("lsmvs", Arguments(workspace, "three")));
  EXPECT_FALSE(fs::exists(workspace / "three/texture_1.png"));
  EXPECT_TRUE(FindLeftovers(workspace.path()).empty());
}

TEST(MeshTexturerProgram, IsTheLastStageOfAWholeRun) {
  const SmallWorkspace workspace;
  const std::vector<std::string> arguments = {workspace.text(), "--texture"};
  ExpectSuccess(RunProgram("lsmvs-mesher", arguments));
  EXPECT_TRUE(fs::exists(workspace / "textured/mesh.ply"));
  EXPECT_TRUE(fs::exists(workspace / "textured/texture.png"));
  const ProgramResult again = RunProgram("lsmvs-mesher", arguments);
  ExpectSuccess(again);
  EXPECT_THAT(again.out, HasSubstr("everything is up to date"));
  fs::remove(workspace / "textured/texture.png");
  ExpectSuccess(RunProgram("lsmvs-mesher", arguments));
  EXPECT_TRUE(fs::exists(workspace / "textured/texture.png"));
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--texture", "--to", "stereo_fusion"}),
              2, {"--texture", "--to"});
}

// Four photos of 480 x 360, or the same under more names.
void WriteRepeatedPhotos(const fs::path& folder, size_t num_photos) {
  const RunContext context(2);
  SyntheticScene scene = MakeScene(ShapeName::kRelief, 4, 480, 360);
  WriteWorkspace(folder, WorkspaceFormat::kDense, &scene, context);
  Scene repeated = scene.scene;
  const size_t num_rendered = repeated.views.size();
  while (repeated.views.size() < num_photos) {
    View view = repeated.views[repeated.views.size() % num_rendered];
    view.image_id = ImageId(static_cast<uint32_t>(repeated.views.size() + 1));
    const std::string source = view.name;
    view.name = "again" + std::to_string(repeated.views.size()) + ".png";
    fs::copy_file(folder / "images" / source, folder / "images" / view.name);
    repeated.views.push_back(view);
  }
  WriteSparseModel(folder / "sparse", MakeSparseModel(repeated));
}

TEST(MeshTexturerProgram, MemoryHardlyGrowsWithTheNumberOfPhotos) {
  const TemporaryFolder folder;
  const auto peak_bytes = [&](size_t num_photos) {
    const fs::path workspace = folder.path() / std::to_string(num_photos);
    WriteRepeatedPhotos(workspace, num_photos);
    const ProgramResult result =
        RunProgram("lsmvs", {"mesh_texturer", "--workspace_path", workspace.string(),
                             "--input_path", (workspace / "gt_mesh.ply").string(), "--output_path",
                             (workspace / "textured").string(), "--num_threads", "2"});
    ExpectSuccess(result);
    return static_cast<double>(result.peak_bytes);
  };
  EXPECT_LT(peak_bytes(150), peak_bytes(11) + 60e6);
}

TEST(MeshTexturerProgram, RefusesWhatItCannotUse) {
  const SmallWorkspace workspace;
  const auto refused = [&](const std::vector<std::string>& more, int code,
                           const std::vector<std::string>& texts) {
    ExpectError(RunProgram("lsmvs", Arguments(workspace, "textured", more)), code, texts);
    EXPECT_FALSE(fs::exists(workspace / "textured"));
  };
  refused({"--MeshTextureMapping.max_page_size", "100"}, 2, {"max_page_size", "256"});
  refused({"--MeshTextureMapping.unseen", "guess"}, 2, {"unseen", "fill"});
  refused({"--MeshTextureMapping.unseen_color", "red"}, 2, {"unseen_color", "red"});
  refused({"--output_type", "OBJ"}, 2, {"output_type"});
  refused({"--input_path", "/nowhere.ply"}, 3, {"/nowhere.ply"});
  TriangleMesh away = ReadMeshPly(workspace / "gt_mesh.ply");
  for (Eigen::Vector3d& x : away.vertices) x += Eigen::Vector3d(1000, 0, 0);
  WriteMeshPly(workspace / "away.ply", away);
  refused({"--input_path", (workspace / "away.ply").string()}, 3, {"away.ply", "no photo shows"});
  away.faces.clear();
  WriteMeshPly(workspace / "cloud.ply", away);
  refused({"--input_path", (workspace / "cloud.ply").string()}, 3, {"cloud.ply", "no faces"});
  fs::remove_all(workspace / "images");
  refused({}, 3, {"images"});
}

TEST(MeshTexturerProgram, LeavesFilesOfOthersAlone) {
  const SmallWorkspace workspace;
  WriteText(workspace / "textured/texture.png", "mine");
  ExpectError(RunProgram("lsmvs", Arguments(workspace, "textured")), 6, {"texture.png"});
  EXPECT_EQ(ReadText(workspace / "textured/texture.png"), "mine");
  WriteText(workspace / "more/texture_1.png", "mine");
  const std::vector<std::string> pages = {"--MeshTextureMapping.max_page_size", "256",
                                          "--MeshTextureMapping.texture_scale_factor", "3"};
  ExpectError(RunProgram("lsmvs", Arguments(workspace, "more", pages)), 6, {"texture_1.png"});
  EXPECT_EQ(ReadText(workspace / "more/texture_1.png"), "mine");
  EXPECT_FALSE(fs::exists(workspace / "more/mesh.ply"));
  auto overwrite = pages;
  overwrite.push_back("--overwrite");
  ExpectSuccess(RunProgram("lsmvs", Arguments(workspace, "more", overwrite)));
  EXPECT_THAT(ReadText(workspace / "more/texture_1.png"), Not("mine"));
}

}  // namespace
}  // namespace lsmvs
