#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// A flat square of 20 x 20 with a colour ramp at z = 1; vertex v is seen by view v % 3.
void WriteSquare(const fs::path& path, bool with_views) {
  TriangleMesh mesh;
  PointViews views;
  views.begin = {0};
  for (int v = 0; v < 21 * 21; ++v) {
    mesh.vertices.emplace_back(v % 21, v / 21, 1.0);
    mesh.vertex_colors.emplace_back(static_cast<uint8_t>(12 * (v % 21)), 0, 0);
    views.view_idxs.push_back(static_cast<uint32_t>(v % 3));
    views.begin.push_back(views.view_idxs.size());
  }
  for (int f = 0; f < 20 * 20; ++f) {
    const int a = f / 20 * 21 + f % 20;
    mesh.faces.emplace_back(a, a + 1, a + 22);
    mesh.faces.emplace_back(a, a + 22, a + 21);
  }
  WriteMeshPly(path, mesh);
  if (with_views) WriteVisibility(path.string() + ".vis", views.begin, views.view_idxs);
}

std::vector<std::string> Arguments(const fs::path& input, const fs::path& output,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"mesh_simplifier", "--input_path", input.string(),
                                        "--output_path", output.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(MeshSimplifierProgram, CarriesColoursAndViews) {
  const TemporaryFolder folder;
  const fs::path input = folder.path() / "square.ply", output = folder.path() / "simple.ply";
  WriteSquare(input, true);
  const auto arguments = Arguments(input, output, {"--MeshSimplification.max_error", "0.01"});
  ExpectSuccess(RunProgram("lsmvs", arguments));
  const TriangleMesh mesh = ReadMeshPly(output);
  ExpectValidMesh(mesh);
  EXPECT_LT(mesh.faces.size(), 60u);
  const PointViews views = ReadVisibility(output.string() + ".vis", mesh.vertices.size());
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_NEAR(mesh.vertex_colors[v][0], 12 * mesh.vertices[v].x(), 1);
    ASSERT_EQ(views.begin[v + 1], v + 1);
    const auto nearest = static_cast<uint32_t>(std::lround(mesh.vertices[v].x()) +
                                               21 * std::lround(mesh.vertices[v].y()));
    if ((mesh.vertices[v] - mesh.vertices[v].array().round().matrix()).norm() < 0.3) {
      EXPECT_EQ(views.view_idxs[v], nearest % 3);
    }
  }
  const std::string first = ReadText(output);
  ExpectError(RunProgram("lsmvs", arguments), 6, {"simple.ply", "--overwrite"});
  auto again = arguments;
  again.insert(again.end(), {"--overwrite", "--num_threads", "1"});
  ExpectSuccess(RunProgram("lsmvs", again));
  EXPECT_EQ(ReadText(output), first);
  WriteSquare(folder.path() / "bare.ply", false);
  ExpectSuccess(RunProgram(
      "lsmvs", Arguments(folder.path() / "bare.ply", output,
                         {"--MeshSimplification.target_face_ratio", "0.5", "--overwrite"})));
  EXPECT_EQ(ReadMeshPly(output).faces.size(), 400u);
  EXPECT_FALSE(fs::exists(output.string() + ".vis"));  // it was about the mesh before
}

TEST(MeshSimplifierProgram, CountsInPixelsOfTheWorkspace) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text()}));
  const fs::path input = workspace / "meshed-visibility.ply";
  size_t last = ReadMeshPly(input).faces.size();
  for (const char* error : {"0.1", "1"}) {
    const fs::path output = workspace / (std::string("simple-") + error + ".ply");
    ExpectSuccess(RunProgram("lsmvs", Arguments(input, output,
                                                {"--workspace_path", workspace.text(),
                                                 "--MeshSimplification.max_error", error})));
    const TriangleMesh mesh = ReadMeshPly(output);
    EXPECT_LT(mesh.faces.size(), last);
    ReadVisibility(output.string() + ".vis", mesh.vertices.size());
    last = mesh.faces.size();
  }
}

TEST(MeshSimplifierProgram, RefusesBadInput) {
  const TemporaryFolder folder;
  const fs::path input = folder.path() / "square.ply", output = folder.path() / "simple.ply";
  WriteSquare(input, true);
  const std::vector<std::string> error = {"--MeshSimplification.max_error", "0.01"};
  const auto refused = [&](const fs::path& path, const std::vector<std::string>& more, int code,
                           const std::vector<std::string>& texts) {
    ExpectError(RunProgram("lsmvs", Arguments(path, output, more)), code, texts);
    EXPECT_FALSE(fs::exists(output));
    EXPECT_TRUE(FindLeftovers(folder.path()).empty());
  };
  refused(input, {}, 2, {"--workspace_path", "--MeshSimplification.max_error"});
  refused(input, {"--MeshSimplification.max_error", "-1"}, 2, {"--MeshSimplification.max_error"});
  refused(input, {"--MeshSimplification.target_face_ratio", "2"}, 2, {"target_face_ratio"});
  refused("/nowhere.ply", error, 3, {"/nowhere.ply"});
  refused(input, {"--workspace_path", "/nowhere"}, 3, {"/nowhere"});
  WriteText(folder.path() / "cut.ply", ReadText(input).substr(0, 3000));
  refused(folder.path() / "cut.ply", error, 3, {"cut.ply"});
  TriangleMesh cloud;
  cloud.vertices = {{1, 2, 3}};
  WriteMeshPly(folder.path() / "cloud.ply", cloud);
  refused(folder.path() / "cloud.ply", error, 3, {"cloud.ply", "has no faces"});
  WriteText(input.string() + ".vis", ReadText(input.string() + ".vis").substr(0, 1000));
  refused(input, error, 3, {"square.ply.vis"});
  WriteVisibility(input.string() + ".vis", {0, 1}, {2});
  refused(input, error, 3, {"square.ply.vis", "1 points", "441"});
}

}  // namespace
}  // namespace lsmvs
