#include "lsmvs/refinement/photo/surface_map_cache.h"

#include <gtest/gtest.h>

#include <vector>

#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

class SurfaceMapCacheTest : public testing::Test {
 protected:
  SurfaceMapCacheTest() : scene_(MakeScene(ShapeName::kTerrain, 5, 160, 120)) {
    mesh_ = scene_.shape->Mesh(4 * scene_.gsd);
    for (const View& view : scene_.scene.views) {
      views_.push_back({view.camera, view.cam_from_world});
    }
  }

  SurfaceMapCache Cache(size_t budget_bytes, bool keeps_faces = true) const {
    return SurfaceMapCache(&views_, mesh_.vertices, mesh_.faces, budget_bytes, keeps_faces,
                           RunContext(1));
  }

  SurfaceMaps Drawn(int view_idx) const {
    const PosedCamera& view = views_[static_cast<size_t>(view_idx)];
    SurfaceMaps maps;
    RasterizeMesh(view.camera, view.cam_from_world, mesh_.vertices, mesh_.faces, {}, &maps);
    return maps;
  }

  SyntheticScene scene_;
  TriangleMesh mesh_;
  std::vector<PosedCamera> views_;
};

// With room for all maps, for one, and for none.
TEST_F(SurfaceMapCacheTest, MapsAreThoseOfTheRasterizerWhateverTheBudget) {
  for (const size_t budget : {size_t{1} << 30, size_t{160 * 120 * 8}, size_t{0}}) {
    SurfaceMapCache cache = Cache(budget);
    for (int view = 0; view < 5; ++view) {
      for (int use = 0; use < 3; ++use) cache.ExpectUse(view);
    }
    for (int view = 0; view < 5; ++view) {
      const SurfaceMaps expected = Drawn(view);
      EXPECT_EQ(cache.Depth((view + 2) % 5)->pixels, Drawn((view + 2) % 5).depth.pixels);
      const DrawnMaps maps = cache.Draw(view);
      EXPECT_EQ(maps.depth->pixels, expected.depth.pixels);
      EXPECT_EQ(maps.face->pixels, expected.face.pixels);
      EXPECT_EQ(cache.Depth(view)->pixels, expected.depth.pixels);
      for (int use = 0; use < 3; ++use) cache.EndUse(view);
    }
  }
}

TEST_F(SurfaceMapCacheTest, DepthIsDrawnOnceWhileThereIsRoom) {
  SurfaceMapCache cache = Cache(size_t{1} << 30);
  cache.ExpectUse(0);
  cache.ExpectUse(0);
  const auto first = cache.Draw(0).depth;
  EXPECT_EQ(cache.Depth(0), first);
  cache.EndUse(0);
  EXPECT_EQ(cache.Depth(0), first);
  cache.EndUse(0);
  EXPECT_EQ(first.use_count(), 1) << "kept behind its last use";
}

TEST_F(SurfaceMapCacheTest, WithoutBudgetTheLastMapAloneIsKept) {
  SurfaceMapCache cache = Cache(0, false);
  for (int view = 0; view < 2; ++view) cache.ExpectUse(view);
  const auto first = cache.Depth(0);
  EXPECT_EQ(cache.Depth(0), first);
  cache.Depth(1);
  EXPECT_EQ(first.use_count(), 1);
}

}  // namespace
}  // namespace lsmvs
