#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// A gently curved strip of 31 x 21 vertices from x = `begin` on, red and seen by view 0, or green
// and seen by view 1.
TriangleMesh Strip(double begin, int color, const Eigen::Vector3d& shift = {0, 0, 0}) {
  TriangleMesh mesh;
  for (int v = 0; v < 31 * 21; ++v) {
    const int column = v % 31, row = v / 31;
    const double x = begin + column, y = row;
    mesh.vertices.push_back(Eigen::Vector3d(x, y, 0.02 * x * y / 20 + std::sin(0.2 * x)) + shift);
    mesh.vertex_colors.emplace_back(color == 0 ? 255 : 0, color == 1 ? 255 : 0, 0);
  }
  for (int f = 0; f < 30 * 20; ++f) {
    const int a = f / 30 * 31 + f % 30;
    mesh.faces.emplace_back(a, a + 1, a + 32);
    mesh.faces.emplace_back(a, a + 32, a + 31);
  }
  return mesh;
}

void Write(const fs::path& path, const TriangleMesh& mesh, std::optional<uint32_t> view) {
  WriteMeshPly(path, mesh);
  if (!view) return;
  PointViews views;
  views.begin = {0};
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    views.view_idxs.push_back(*view);
    views.begin.push_back(views.view_idxs.size());
  }
  WriteVisibility(path.string() + ".vis", views.begin, views.view_idxs);
}

std::vector<std::string> Arguments(const std::vector<fs::path>& inputs, const fs::path& output,
                                   const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"mesh_merger", "--output_path", output.string()};
  for (const fs::path& input : inputs) {
    arguments.insert(arguments.end(), {"--input_path", input.string()});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(MeshMergerProgram, CarriesColoursAndViewsInAnyOrder) {
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a.ply", b = folder.path() / "b.ply",
                 output = folder.path() / "merged.ply";
  Write(a, Strip(0, 0), 0u);
  Write(b, Strip(18.3, 1), 1u);
  ExpectSuccess(RunProgram("lsmvs", Arguments({a, b}, output)));
  const TriangleMesh mesh = ReadMeshPly(output);
  ExpectValidMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.num_components, 1u);
  EXPECT_EQ(inspection.euler_characteristic, 1);
  const PointViews views = ReadVisibility(output.string() + ".vis", mesh.vertices.size());
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    ASSERT_EQ(views.begin[v + 1], v + 1);
    EXPECT_EQ(mesh.vertex_colors[v][static_cast<int>(views.view_idxs[v])], 255);
    if (mesh.vertices[v].x() < 17) {
      EXPECT_EQ(views.view_idxs[v], 0u);
    }
    if (mesh.vertices[v].x() > 31) {
      EXPECT_EQ(views.view_idxs[v], 1u);
    }
  }
  const std::string first = ReadText(output), first_vis = ReadText(output.string() + ".vis");
  ExpectError(RunProgram("lsmvs", Arguments({a, b}, output)), 6, {"merged.ply", "--overwrite"});
  for (const auto& more : std::vector<std::vector<std::string>>{
           {"--overwrite"}, {"--overwrite", "--num_threads", "1"}}) {
    ExpectSuccess(RunProgram("lsmvs", Arguments({b, a}, output, more)));
    EXPECT_EQ(ReadText(output), first);
    EXPECT_EQ(ReadText(output.string() + ".vis"), first_vis);
  }
  for (const char* method : {"tetrahedra", "surface"}) {
    ExpectSuccess(RunProgram(
        "lsmvs", Arguments({a, b}, output, {"--overwrite", "--MeshMerging.method", method})));
    ExpectValidMesh(ReadMeshPly(output));
    EXPECT_EQ(Inspect(ReadMeshPly(output)).num_components, 1u);
  }
}

// Vertices far from the seam keep their bytes, also in double precision.
TEST(MeshMergerProgram, KeepsLargeCoordinates) {
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a.ply", b = folder.path() / "b.ply",
                 output = folder.path() / "merged.ply";
  const Eigen::Vector3d utm(500000.123, 5400000.456, 321.7);
  const TriangleMesh mesh_a = Strip(0, 0), mesh_b = Strip(18.3, 1);
  WriteMeshPly(a, mesh_a, utm);
  WriteMeshPly(b, mesh_b, utm);
  ExpectSuccess(RunProgram("lsmvs", Arguments({a, b}, output)));
  const TriangleMesh mesh = ReadMeshPly(output), input = ReadMeshPly(a);
  ExpectValidMesh(mesh);
  size_t num_found = 0;
  for (const Eigen::Vector3d& x : input.vertices) {
    num_found += std::find(mesh.vertices.begin(), mesh.vertices.end(), x) != mesh.vertices.end();
  }
  EXPECT_GT(num_found, 250u);
}

// Meshes in workspaces of their own: their photos are other numbers of the common workspace.
TEST(MeshMergerProgram, RenumbersViewsByThePhotosNames) {
  const SmallWorkspace common, own;
  const fs::path a = common / "a.ply", b = own / "b.ply", output = common / "merged.ply";
  // Photo 0 of the second workspace is photo 3 of the common one, and photo 3 photo 0.
  const std::string images = ReadText(own / "sparse/images.bin");
  const Scene scene = LoadScene(DenseWorkspace{common.path()});
  const std::string &first = scene.views[0].name, &fourth = scene.views[3].name;
  std::string swapped = images;
  ASSERT_EQ(first.size(), fourth.size());
  const size_t at_first = images.find(first), at_fourth = images.find(fourth);
  ASSERT_NE(at_first, std::string::npos);
  ASSERT_NE(at_fourth, std::string::npos);
  swapped.replace(at_first, first.size(), fourth);
  swapped.replace(at_fourth, fourth.size(), first);
  WriteText(own / "sparse/images.bin", swapped);
  Write(a, Strip(0, 0), 0u);
  Write(b, Strip(18.3, 1), 0u);
  ExpectSuccess(
      RunProgram("lsmvs", Arguments({a, b}, output, {"--workspace_path", common.text()})));
  const TriangleMesh mesh = ReadMeshPly(output);
  const PointViews views = ReadVisibility(output.string() + ".vis", mesh.vertices.size());
  const Scene own_scene = LoadScene(DenseWorkspace{own.path()});
  const auto named = [&](const std::string& name) {
    for (size_t i = 0; i < scene.views.size(); ++i) {
      if (scene.views[i].name == name) return static_cast<uint32_t>(i);
    }
    return 0xFFFFFFFFu;
  };
  const uint32_t number_of_b = named(own_scene.views[0].name);
  EXPECT_NE(number_of_b, 0u);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const bool is_red = mesh.vertex_colors[v][0] == 255;
    EXPECT_EQ(views.view_idxs[v], is_red ? 0u : number_of_b);
  }
}

TEST(MeshMergerProgram, TakesLittleMemory) {
  SKIP_WITH_SANITIZERS;
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a.ply", b = folder.path() / "b.ply",
                 output = folder.path() / "merged.ply";
  for (const auto& [path, shift] : {std::pair(a, 0.0), {b, 120.3}}) {
    TriangleMesh mesh;
    constexpr int kSize = 240;
    for (int v = 0; v < kSize * kSize; ++v) {
      const int column = v % kSize, row = v / kSize;
      const double x = shift + column, y = row;
      mesh.vertices.emplace_back(x, y, std::sin(0.05 * x) + 0.01 * y);
    }
    for (int f = 0; f < (kSize - 1) * (kSize - 1); ++f) {
      const int c = f / (kSize - 1) * kSize + f % (kSize - 1);
      mesh.faces.emplace_back(c, c + 1, c + kSize + 1);
      mesh.faces.emplace_back(c, c + kSize + 1, c + kSize);
    }
    WriteMeshPly(path, mesh);
  }
  ExpectSuccess(RunProgram("lsmvs", Arguments({a, b}, output)));
  const std::string first = ReadText(output);
  const auto with_memory = [&](const char* memory) {
    return RunProgram("lsmvs", Arguments({a, b}, output, {"--overwrite", "--max_memory", memory}));
  };
  ExpectSuccess(with_memory("0.2"));
  EXPECT_EQ(ReadText(output), first);
  ExpectError(with_memory("0.06"), 5, {"mesh_merger", "faces need about", "--max_memory"});
}

TEST(MeshMergerProgram, RefusesBadInput) {
  const TemporaryFolder folder;
  const fs::path a = folder.path() / "a.ply", b = folder.path() / "b.ply",
                 output = folder.path() / "merged.ply";
  Write(a, Strip(0, 0), 0u);
  const auto refused = [&](const std::vector<fs::path>& inputs, int code,
                           const std::vector<std::string>& texts,
                           const std::vector<std::string>& more = {}) {
    ExpectError(RunProgram("lsmvs", Arguments(inputs, output, more)), code, texts);
    EXPECT_FALSE(fs::exists(output));
    EXPECT_TRUE(FindLeftovers(folder.path()).empty());
  };
  refused({a}, 2, {"--input_path", "two or more"});
  refused({a, a}, 2, {"a.ply", "twice"});
  refused({a, "/nowhere.ply"}, 3, {"/nowhere.ply"});
  Write(b, Strip(18.3, 1), {});
  refused({a, b}, 2, {"MeshMerging.method"}, {"--MeshMerging.method", "magic"});
  refused({a, b}, 2, {"MeshMerging.max_offset"}, {"--MeshMerging.max_offset", "-1"});
  refused({a, b}, 3, {"/nowhere"}, {"--workspace_path", "/nowhere"});
  const std::string whole = ReadText(b);
  WriteText(b, whole.substr(0, whole.size() / 2));
  refused({a, b}, 3, {"b.ply"});
  TriangleMesh cloud;
  cloud.vertices = {{1, 2, 3}};
  Write(b, cloud, {});
  refused({a, b}, 3, {"b.ply", "has no faces"});
  // Far away, in another scale.
  Write(b, Strip(500, 1), {});
  refused({a, b}, 3, {"does not overlap", "a box of", "model_merger"});
  TriangleMesh scaled = Strip(18.3, 1);
  for (Eigen::Vector3d& x : scaled.vertices) x *= 30;
  Write(b, scaled, {});
  refused({a, b}, 3, {"edges of"});
  // Beside each other by more than what can be absorbed.
  Write(b, Strip(18.3, 1, {0, 0, 7}), {});
  refused({a, b}, 3, {"edge lengths", "model_aligner", "max_offset"});
  // Inside out.
  TriangleMesh flipped = Strip(18.3, 1);
  for (Eigen::Vector3i& face : flipped.faces) std::swap(face[0], face[1]);
  Write(b, flipped, {});
  refused({a, b}, 3, {"inside out", "%", "flip"});
  // Every other face inside out.
  TriangleMesh mixed = Strip(18.3, 1);
  for (size_t f = 0; f < mixed.faces.size(); f += 2)
    std::swap(mixed.faces[f][0], mixed.faces[f][1]);
  Write(b, mixed, {});
  refused({a, b}, 3, {"b.ply", "not oriented alike"});
  Write(b, Strip(18.3, 1), 1u);
  WriteText(b.string() + ".vis", ReadText(b.string() + ".vis").substr(0, 1000));
  refused({a, b}, 3, {"b.ply.vis"});
}

}  // namespace
}  // namespace lsmvs
