#include "lsmvs/exporting/tiles/surface_octree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "lsmvs/exporting_test/textured_blob.h"

namespace lsmvs {
namespace {

bool IsBelow(const std::vector<SurfaceOctreeNode>& nodes, int node, int ancestor) {
  while (node >= 0 && node != ancestor) node = nodes[node].parent;
  return node == ancestor;
}

TEST(SurfaceOctree, EachFaceLiesInOneSmallLeaf) {
  const TriangleMesh mesh = BlobMesh(0.1);
  const auto nodes = BuildSurfaceOctree(mesh, {}, 200, 1);
  std::vector<int> count(mesh.faces.size(), 0);
  for (size_t n = 0; n < nodes.size(); ++n) {
    EXPECT_NE(nodes[n].children.empty(), nodes[n].faces.empty());
    EXPECT_NE(nodes[n].children.size(), 1u);
    EXPECT_LE(nodes[n].faces.size(), 200u);
    for (const int f : nodes[n].faces) ++count[f];
    for (const int child : nodes[n].children) {
      EXPECT_EQ(nodes[child].parent, static_cast<int>(n));
      EXPECT_EQ(nodes[child].depth, nodes[n].depth + 1);
      EXPECT_TRUE(nodes[child].name.starts_with(nodes[n].name));
    }
  }
  EXPECT_EQ(*std::min_element(count.begin(), count.end()), 1);
  EXPECT_EQ(*std::max_element(count.begin(), count.end()), 1);
  EXPECT_GT(nodes.size(), mesh.faces.size() / 200);
}

TEST(SurfaceOctree, WeightsDivideToo) {
  const TriangleMesh mesh = BlobMesh(0.3);
  const std::vector<double> weights(mesh.faces.size(), 2.0);
  for (const SurfaceOctreeNode& node : BuildSurfaceOctree(mesh, weights, 1 << 20, 20)) {
    EXPECT_LE(node.faces.size(), 10u);
  }
}

TEST(SurfaceOctree, FacesInOnePlaceStayTogether) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.assign(100, {0, 1, 2});
  const auto nodes = BuildSurfaceOctree(mesh, {}, 10, 1);
  ASSERT_EQ(nodes.size(), 1u);
  EXPECT_EQ(nodes[0].faces.size(), 100u);
}

TEST(SurfaceOctree, NodeOfAVertexHoldsAllItsFaces) {
  const TriangleMesh mesh = BlobMesh(0.15);
  const auto nodes = BuildSurfaceOctree(mesh, {}, 50, 1);
  const std::vector<int> node_of = NodesOfVertices(mesh, nodes);
  std::vector<int> leaf_of(mesh.faces.size());
  for (size_t n = 0; n < nodes.size(); ++n) {
    for (const int f : nodes[n].faces) leaf_of[f] = static_cast<int>(n);
  }
  std::vector<std::vector<int>> leaves(mesh.vertices.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) leaves[v].push_back(leaf_of[f]);
  }
  for (size_t v = 0; v < leaves.size(); ++v) {
    bool by_one_child = false;  // would be deeper
    for (const int leaf : leaves[v]) EXPECT_TRUE(IsBelow(nodes, leaf, node_of[v]));
    for (const int child : nodes[node_of[v]].children) {
      by_one_child |= std::all_of(leaves[v].begin(), leaves[v].end(),
                                  [&](int leaf) { return IsBelow(nodes, leaf, child); });
    }
    EXPECT_FALSE(by_one_child);
  }
}

}  // namespace
}  // namespace lsmvs
