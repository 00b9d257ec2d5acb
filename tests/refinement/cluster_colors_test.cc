#include "lsmvs/refinement/regions/cluster_colors.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "lsmvs/synthetic/named_shapes.h"

namespace lsmvs {
namespace {

TEST(ColorClusters, WhatSharesAVertexIsOfOneClusterOrOfTwoColors) {
  const TriangleMesh mesh = MakeShape(ShapeName::kTorus, 0.01)->Mesh(0.05);
  const FaceRegions regions = GrowFaceRegions(mesh, 64);
  const ClusterColors colors = ColorClusters(mesh, regions, 1024);
  ASSERT_EQ(colors.of_region.size(), static_cast<size_t>(regions.count));
  EXPECT_GE(colors.num_colors, 2);
  EXPECT_LE(colors.num_colors, 6);
  // Regions of a colour that touch form a patch: none may be larger than a cluster.
  std::map<int, std::set<int32_t>> regions_at;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) regions_at[v].insert(regions.of_face[f]);
  }
  std::vector<int32_t> patch(static_cast<size_t>(regions.count));
  for (size_t r = 0; r < patch.size(); ++r) patch[r] = static_cast<int32_t>(r);
  const auto root = [&](int32_t r) {
    while (patch[static_cast<size_t>(r)] != r) r = patch[static_cast<size_t>(r)];
    return r;
  };
  for (const auto& [v, met] : regions_at) {
    for (const int32_t a : met) {
      for (const int32_t b : met) {
        if (colors.of_region[static_cast<size_t>(a)] != colors.of_region[static_cast<size_t>(b)]) {
          continue;
        }
        patch[static_cast<size_t>(root(a))] = root(b);
      }
    }
  }
  std::map<int32_t, size_t> num_faces;
  for (const int32_t r : regions.of_face) ++num_faces[root(r)];
  EXPECT_GE(num_faces.size(), mesh.faces.size() / 1024 / 2);
  for (const auto& [r, count] : num_faces) EXPECT_LE(count, 1024u + 4 * 64 * 12) << r;
}

TEST(ColorClusters, ASmallMeshHasOneColor) {
  const TriangleMesh mesh = MakeShape(ShapeName::kSphere, 0.01)->Mesh(0.3);
  const ClusterColors colors = ColorClusters(mesh, GrowFaceRegions(mesh, 64), 1 << 20);
  EXPECT_EQ(colors.num_colors, 1);
}

}  // namespace
}  // namespace lsmvs
