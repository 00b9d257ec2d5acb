#include "lsmvs/refinement/photo/pair_selection.h"

#include <gtest/gtest.h>

#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

// A town of which a photo shows a part, with all pairs of photos.
struct TownPairs {
  TownPairs() {
    SyntheticSceneOptions options;
    options.shape = ShapeName::kTown;
    options.num_views = 25;
    options.width = 160;
    options.height = 120;
    s = MakeScene(options, RunContext(2));
    mesh = s.shape->Mesh(1);
    regions = GrowFaceRegions(mesh, 256);
    for (const View& view : s.scene.views) views.push_back({view.camera, view.cam_from_world});
    for (int i = 0; i < s.scene.num_views(); ++i) {
      for (int j = 0; j < s.scene.num_views(); ++j) {
        if (i != j) candidates.push_back({i, j});
      }
    }
  }

  FacePairs Select(const PairSelectionOptions& options, int num_threads) const {
    return SelectFacePairs(views, candidates, mesh, regions, options, RunContext(num_threads));
  }

  SyntheticScene s;
  TriangleMesh mesh;
  FaceRegions regions;
  std::vector<PosedCamera> views;
  std::vector<ViewPair> candidates;
};

const TownPairs& Town() {
  static const TownPairs town;
  return town;
}

Eigen::Vector3d Middle(const TriangleMesh& mesh, size_t f) {
  const Eigen::Vector3i& v = mesh.faces[f];
  return (mesh.vertices[v[0]] + mesh.vertices[v[1]] + mesh.vertices[v[2]]) / 3.0;
}

// As its definition says, by rays to the exact shape.
bool Sees(const TownPairs& town, int view_idx, size_t f, double min_cosine) {
  const PosedCamera& view = town.views[static_cast<size_t>(view_idx)];
  const Eigen::Vector3d middle = Middle(town.mesh, f), x = view.cam_from_world * middle;
  if (x.z() <= 0 || !view.camera.Contains(view.camera.Project(x))) return false;
  const Eigen::Vector3d center = view.cam_from_world.OriginInSource();
  const Eigen::Vector3d to_camera = (center - middle).normalized();
  if (to_camera.dot(FaceNormalTimesTwiceArea(town.mesh, f).normalized()) < min_cosine) return false;
  const auto hit = town.s.shape->Intersect(center, -to_camera);
  return hit && hit->distance > 0.99 * (center - middle).norm();
}

TEST(SelectFacePairs, BothViewsSeeTheFaceAtUsefulAngles) {
  const PairSelectionOptions options;
  const FacePairs pairs = Town().Select(options, 2);
  size_t num_pairs = 0, num_wrong = 0;
  for (size_t f = 0; f < Town().mesh.faces.size(); ++f) {
    for (int k = 0; k < pairs.per_face; ++k) {
      const int32_t p =
          pairs.of_face[f * static_cast<size_t>(pairs.per_face) + static_cast<size_t>(k)];
      if (p < 0) break;
      const ViewPair& pair = pairs.pairs[static_cast<size_t>(p)];
      ++num_pairs;
      // Coarse maps judge what is hidden: some faces at edges are seen as far as they know.
      num_wrong += !Sees(Town(), pair.i, f, options.min_cosine) ||
                   !Sees(Town(), pair.j, f, options.min_cosine);
    }
  }
  EXPECT_GT(num_pairs, Town().mesh.faces.size());
  EXPECT_LT(num_wrong, num_pairs / 20);
}

TEST(SelectFacePairs, FindsAPairWhereTwoViewsSeeTheFace) {
  const PairSelectionOptions options;
  const FacePairs pairs = Town().Select(options, 2);
  size_t num_seen = 0, num_missed = 0;
  for (size_t f = 0; f < Town().mesh.faces.size(); f += 3) {
    std::vector<Eigen::Vector3d> directions;
    bool useful = false;
    for (int v = 0; v < Town().s.scene.num_views(); ++v) {
      if (!Sees(Town(), v, f, options.min_cosine + 0.05)) continue;
      const Eigen::Vector3d center =
          Town().views[static_cast<size_t>(v)].cam_from_world.OriginInSource();
      directions.push_back((center - Middle(Town().mesh, f)).normalized());
      for (const Eigen::Vector3d& d : directions) {
        const double angle = std::acos(std::min(1.0, d.dot(directions.back()))) * 57.3;
        useful |= angle > options.min_angle_deg + 0.5 && angle < options.max_angle_deg - 0.5;
      }
    }
    num_seen += useful;
    num_missed += useful && !pairs.Seen(f);
  }
  EXPECT_GT(num_seen, 300u);
  EXPECT_LT(num_missed, num_seen / 200);
}

TEST(SelectFacePairs, NeitherThreadsNorTheBudgetChangeAnything) {
  PairSelectionOptions tight;
  tight.map_budget_bytes = 4 * 40 * 30 * 3;  // three maps
  const FacePairs all = Town().Select({}, 1), few = Town().Select(tight, 2);
  EXPECT_EQ(all.of_face, few.of_face);
  EXPECT_EQ(all.pixel_size, few.pixel_size);
  EXPECT_EQ(all.area_px, few.area_px);
}

}  // namespace
}  // namespace lsmvs
