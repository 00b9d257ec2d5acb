// Photos that share too few sparse points with others to tell their neighbours by them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

using testing::HasSubstr;

// Takes one image out of all tracks, as soft texture would.
void CutTracks(const std::filesystem::path& folder, size_t image) {
  SparseModel model = ReadSparseModel(folder);
  const ImageId image_id = model.images.at(image).image_id;
  for (SparseModel::Point3d& point : model.points3d) {
    std::erase_if(point.track, [&](const auto& element) { return element.image_id == image_id; });
  }
  for (SparseModel::Point2d& point : model.images.at(image).points2d) {
    point.point3d_id = SparseModel::kNoPoint3d;
  }
  WriteSparseModel(folder, model);
}

double ShareWithDepth(const SmallWorkspace& workspace, const std::string& name) {
  const DenseWorkspace dense{workspace.path()};
  const Scene scene = LoadScene(dense, {});
  for (const View& view : scene.views) {
    if (view.name != name) continue;
    const auto depths = ReadDepthMap(dense, view, DepthMapKind::kGeometric).depth.pixels;
    const auto num_known =
        std::count_if(depths.begin(), depths.end(), [](float d) { return d > 0; });
    return static_cast<double>(num_known) / static_cast<double>(depths.size());
  }
  ADD_FAILURE() << "no photo " << name;
  return 0;
}

TEST(LonelyPhoto, GetsNeighboursByOverlapAndThePlanSaysSo) {
  const SmallWorkspace whole, cut;
  const std::string name = ReadSparseModel(cut / "sparse").images.at(2).name;
  CutTracks(cut / "sparse", 2);
  const auto run = [](const SmallWorkspace& workspace) {
    return RunProgram("lsmvs", {"patch_match_stereo", "--workspace_path", workspace.text()});
  };
  const ProgramResult before = run(whole), after = run(cut);
  ExpectSuccess(before);
  ExpectSuccess(after);
  EXPECT_THAT(before.out, testing::Not(HasSubstr("by overlap")));
  EXPECT_THAT(after.out, HasSubstr("1 photo that shares too few sparse points"));
  EXPECT_THAT(after.out, HasSubstr(name));
  const double full = ShareWithDepth(whole, name);
  EXPECT_GT(full, 0.3);
  EXPECT_GT(ShareWithDepth(cut, name), 0.9 * full);
}

}  // namespace
}  // namespace lsmvs
