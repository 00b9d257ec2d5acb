// Kinds of input that people have and that must simply work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/mesh/ply.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

size_t CountDepths(const DepthMap& map) {
  size_t count = 0;
  for (const float depth : map.depth.pixels) count += depth > 0;
  return count;
}

size_t CountOccurrences(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(InputKinds, OptionsOfColmapsThatHaveNoMeaningGiveOneWarning) {
  const SmallWorkspace workspace;
  const ProgramResult result = RunProgram(
      "lsmvs", {"patch_match_stereo", "--workspace_path", workspace.text(), "--workspace_format",
                "COLMAP", "--PatchMatchStereo.gpu_index", "0", "--PatchMatchStereo.cache_size",
                "32", "--PatchMatchStereo.geom_consistency", "true"});
  ExpectSuccess(result);
  EXPECT_THAT(result.err, HasSubstr("--PatchMatchStereo.cache_size, --PatchMatchStereo.gpu_index "
                                    "have no meaning here and are ignored"));
  EXPECT_EQ(CountOccurrences(result.err, "no meaning"), 1u);
  EXPECT_THAT(RunProgram("lsmvs", {"patch_match_stereo", "--help_all"}).out,
              HasSubstr("--PatchMatchStereo.gpu_index"));
  ExpectSuccess(
      RunProgram("lsmvs", {"stereo_fusion", "--workspace_path", workspace.text(), "--output_path",
                           (workspace / "fused.ply").string(), "--StereoFusion.use_cache", "1"}));
}

// As `colmap project_generator` writes it: options of all commands, -1 where COLMAP decides.
TEST(InputKinds, ProjectFilesOfColmapsAreTaken) {
  const SmallWorkspace workspace;
  const std::string ini = (workspace / "x.ini").string();
  WriteText(ini,
            "log_to_stderr=false\nrandom_seed=0\nlog_level=1\ndatabase_path=\nimage_path=\n"
            "[SiftExtraction]\nuse_gpu=true\n[PatchMatchStereo]\ngeom_consistency=true\n"
            "allow_missing_files=false\nwrite_consistency_graph=false\nmax_image_size=2400\n"
            "num_samples=15\ndepth_min=-1\ndepth_max=-1\nsigma_spatial=-1\nncc_sigma=0.6\n"
            "min_triangulation_angle=1\nincident_angle_sigma=0.9\ncache_size=32\ngpu_index=-1\n"
            "[StereoFusion]\nuse_cache=false\nnum_threads=-1\nmin_num_pixels=3\n"
            "max_traversal_depth=100\ncache_size=32\nmask_path=\n[DelaunayMeshing]\n"
            "num_threads=-1\nmax_proj_dist=20\nquality_regularization=1\n");
  ExpectSuccess(RunProgram("lsmvs", {"patch_match_stereo", "--project_path", ini,
                                     "--workspace_path", workspace.text()}));
  ExpectSuccess(
      RunProgram("lsmvs", {"stereo_fusion", "--project_path", ini, "--workspace_path",
                           workspace.text(), "--output_path", (workspace / "fused.ply").string()}));
  ExpectSuccess(
      RunProgram("lsmvs", {"visibility_mesher", "--project_path", ini, "--input_path",
                           workspace.text(), "--output_path", (workspace / "m.ply").string()}));
}

TEST(InputKinds, ACloudIsMeshedWithoutPhotos) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "stereo_fusion"}));
  fs::remove_all(workspace / "images");
  const std::string mesh = (workspace / "m.ply").string();
  ExpectSuccess(RunProgram(
      "lsmvs", {"visibility_mesher", "--input_path", workspace.text(), "--output_path", mesh}));
  EXPECT_GT(ReadMeshPly(mesh).faces.size(), 1000u);
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--from", "visibility_mesher", "--to",
                                            "visibility_mesher"}));
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text()}), 3, {"images"});
}

// COLMAP's own call for the mapper's model, whose cameras have distortion.
TEST(InputKinds, ASparseModelIsMeshedByItsFolder) {
  const SmallWorkspace workspace;
  SparseModel model = ReadSparseModel(workspace / "sparse");
  SparseModel::Camera& camera = model.cameras[0];
  camera.model_id = 2;  // SIMPLE_RADIAL
  camera.params = {camera.params[0], camera.params[2], camera.params[3], 0.01};
  const fs::path folder = workspace / "elsewhere/0";
  WriteSparseModel(folder, model);
  const std::string mesh = (workspace / "sparse.ply").string();
  ExpectSuccess(RunProgram("lsmvs", {"visibility_mesher", "--input_path", folder.string(),
                                     "--input_type", "sparse", "--output_path", mesh}));
  EXPECT_GT(ReadMeshPly(mesh).faces.size(), 100u);
}

TEST(InputKinds, HandMadeListsOfSourcesAreHonoured) {
  const SmallWorkspace workspace;
  WriteText(workspace / "stereo/patch-match.cfg",
            "0000.png\n0001.png\n0001.png\n__all__\n0002.png\n__auto__, 1\n");
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "patch_match_stereo",
                                            "--PatchMatchStereo.geom_consistency", "0"}));
  const DenseWorkspace dense{workspace.path()};
  const Scene scene = LoadScene(dense);
  for (const View& view : scene.views) {
    const size_t count = CountDepths(ReadDepthMap(dense, view, DepthMapKind::kPhotometric));
    if (view.name < "0003.png") {
      EXPECT_GT(count, 1000u) << view.name;
    } else {
      EXPECT_EQ(count, 0u) << view.name;
    }
  }
  // Another list makes another result, the same list none.
  const std::vector<std::string> arguments = {workspace.text(), "--to", "patch_match_stereo",
                                              "--PatchMatchStereo.geom_consistency", "0"};
  EXPECT_THAT(RunProgram("lsmvs-mesher", arguments).out, HasSubstr("up to date"));
  WriteText(workspace / "stereo/patch-match.cfg", "0003.png\n0004.png\n");
  ExpectSuccess(RunProgram("lsmvs-mesher", arguments));
  EXPECT_GT(CountDepths(ReadDepthMap(dense, scene.views[3], DepthMapKind::kPhotometric)), 1000u);
  EXPECT_EQ(CountDepths(ReadDepthMap(dense, scene.views[0], DepthMapKind::kPhotometric)), 0u);
}

TEST(InputKinds, MissingPhotosMayBeSkipped) {
  const SmallWorkspace workspace;
  fs::remove(workspace / "images/0004.png");
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text()}), 3,
              {"1 of the model's 5 photos is missing: 0004.png", "--skip_missing_images"});
  const ProgramResult result =
      RunProgram("lsmvs-mesher", {workspace.text(), "--skip_missing_images"});
  ExpectSuccess(result);
  EXPECT_THAT(result.err, HasSubstr("goes on without them"));
  EXPECT_GT(ReadMeshPly(workspace / "meshed-refined.ply").faces.size(), 1000u);
}

TEST(InputKinds, DepthMapsWithoutNormalMapsAreFused) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "patch_match_stereo"}));
  fs::remove_all(workspace / "stereo/normal_maps");
  fs::remove_all(workspace / "lsmvs");
  const std::string cloud = (workspace / "c.ply").string();
  ExpectSuccess(RunProgram(
      "lsmvs", {"stereo_fusion", "--workspace_path", workspace.text(), "--output_path", cloud}));
  EXPECT_GT(ReadMeshPly(cloud).vertices.size(), 5000u);
}

}  // namespace
}  // namespace lsmvs
