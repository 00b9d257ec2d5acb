#include "lsmvs/colmap_adapter/joined_models.h"

#include <gtest/gtest.h>

#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

TEST(JoinedModels, HaveTheImagesInRegisteredOrderUnderNewNumbers) {
  const SparseModel plain = SmallModel(false), with_rigs = SmallModel(true);
  const SparseModel joined = JoinSparseModels({plain, with_rigs});
  ASSERT_EQ(joined.images.size(), 6u);
  const std::vector<size_t> order = RegisteredImageOrder(with_rigs);
  EXPECT_NE(order.front(), 0u);  // the model with rigs has another order than its file
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(joined.images[i].name, "1/" + plain.images[i].name);
    EXPECT_EQ(joined.images[3 + i].name, "2/" + with_rigs.images[order[i]].name);
    EXPECT_EQ(joined.images[3 + i].cam_from_world.translation,
              with_rigs.images[order[i]].cam_from_world.translation);
  }
  EXPECT_EQ(joined.cameras.size(), 4u);
  EXPECT_EQ(joined.points3d.size(), 4u);
  EXPECT_EQ(joined.points3d[2].track.size(), 2u);
  EXPECT_NO_THROW(RegisteredImageOrder(joined));
}

TEST(JoinedModels, TracksNameTheSameViews) {
  const SparseModel model = SmallModel(true);
  const Scene alone = MakeScene(model, "x", true);
  const Scene joined = MakeScene(JoinSparseModels({model, model}), "x", true);
  const int num_views = alone.num_views();
  ASSERT_EQ(joined.points.size(), 2 * alone.points.size());
  for (size_t p = 0; p < alone.points.size(); ++p) {
    EXPECT_EQ(joined.points[p].view_idxs, alone.points[p].view_idxs);
    std::vector<int> moved = alone.points[p].view_idxs;
    for (int& v : moved) v += num_views;
    EXPECT_EQ(joined.points[alone.points.size() + p].view_idxs, moved);
  }
}

// Far from the origin, every part is shifted as the whole is.
TEST(JoinedModels, PartsHaveTheFrameOfTheWhole) {
  const TemporaryFolder folder;
  SparseModel model = SmallModel(false);
  const Eigen::Vector3d utm(500000, 5400000, 100);
  for (SparseModel::Image& image : model.images) {
    image.cam_from_world.translation -= image.cam_from_world.rotation * utm;
  }
  for (SparseModel::Point3d& point : model.points3d) point.x_in_world += utm;
  std::vector<DenseWorkspace> workspaces;
  for (const char* name : {"a", "b"}) {
    workspaces.push_back({folder.path() / name});
    WriteSparseModel(folder.path() / name / "sparse", model);
  }
  const JoinedScene joined = LoadJoinedScene(workspaces, true);
  EXPECT_FALSE(joined.whole.world_offset.isZero(0.0));
  ASSERT_EQ(joined.parts.size(), 2u);
  size_t v = 0;
  for (const Scene& part : joined.parts) {
    EXPECT_EQ(part.world_offset, joined.whole.world_offset);
    EXPECT_EQ(part.views.front().name, "b.jpg");
    for (const View& view : part.views) {
      EXPECT_EQ(view.cam_from_world.translation,
                joined.whole.views[v++].cam_from_world.translation);
    }
  }
  EXPECT_EQ(v, joined.whole.views.size());
}

}  // namespace
}  // namespace lsmvs
