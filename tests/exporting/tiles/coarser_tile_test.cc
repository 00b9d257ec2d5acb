#include "lsmvs/exporting/tiles/coarser_tile.h"

#include <gtest/gtest.h>

#include <set>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/exporting/tiles/chart_repacking.h"
#include "lsmvs/exporting/tiles/skirts.h"
#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/texture_pages.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

// Colours without fine waves, so that coarse texels can show them.
Color SmoothColor(const Eigen::Vector3d& x) {
  return (128 + 90 * (1.5 * x).array().sin()).matrix().cast<uint8_t>();
}

Eigen::Vector3f TileColor(const TileMesh& tile, size_t f, const Eigen::Vector3d& weights) {
  Eigen::Vector2f x = Eigen::Vector2f::Zero();
  for (size_t c = 0; c < 3; ++c) {
    x += static_cast<float>(weights[static_cast<int>(c)]) * tile.texcoords[f][c];
  }
  return SampleColor(tile.page, x);
}

// A blob whose faces with x < 0 are one tile, those with y < 0 a second, the rest is elsewhere.
class CoarserTileTest : public ::testing::Test {
 protected:
  CoarserTileTest() {
    AtlasOptions options;
    options.page_width = options.page_height = 512;
    options.chart_px = 12;
    textured_ = PaintAtlas(BlobMesh(0.15), SmoothColor, folder_.path(), options);
    const TriangleMesh& mesh = textured_.mesh;
    is_locked_.assign(mesh.vertices.size(), 0);
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
      for (const int v : mesh.faces[f]) centroid += mesh.vertices[v] / 3;
      const int tile = centroid.x() < 0 ? 0 : centroid.y() < 0 ? 1 : 2;
      faces_[tile].push_back(static_cast<int>(f));
      if (tile < 2) continue;
      for (const int v : mesh.faces[f]) is_locked_[v] = 1;
    }
    pages_ = std::make_unique<TexturePages>(textured_, size_t{1} << 30);
    first_ = MakeFinestTile(textured_, pages_.get(), faces_[0]);
    second_ = MakeFinestTile(textured_, pages_.get(), faces_[1]);
  }
  TileMesh Coarse(int num_threads) const {
    return MakeCoarserTile({&first_, &second_}, is_locked_, {1000, 1e5}, RunContext(num_threads));
  }

  TemporaryFolder folder_;
  TexturedMesh textured_;
  std::vector<int> faces_[3];
  std::vector<uint8_t> is_locked_;
  std::unique_ptr<TexturePages> pages_;
  TileMesh first_, second_;
};

TEST_F(CoarserTileTest, FinestTileKeepsEveryTexel) {
  for (size_t i = 0; i < faces_[0].size(); ++i) {
    const size_t f = static_cast<size_t>(faces_[0][i]);
    const auto page = pages_->Page(textured_.page_idx[f]);
    for (int v = 0; v < 3; ++v) {
      EXPECT_EQ(first_.vertex_ids[first_.mesh.faces[i][v]], textured_.mesh.faces[f][v]);
    }
    // All around the corners the texels are those of the page.
    for (size_t c = 0; c < 3; ++c) {
      const Eigen::Vector2i from = textured_.texcoords[f][c].cast<int>();
      const Eigen::Vector2i to = first_.texcoords[i][c].cast<int>();
      EXPECT_EQ(textured_.texcoords[f][c] - from.cast<float>(),
                first_.texcoords[i][c] - to.cast<float>());
      for (int d = -2; d <= 2; ++d) {
        EXPECT_EQ((*page)(from.x() + d, from.y() - d), first_.page(to.x() + d, to.y() - d));
      }
    }
  }
  EXPECT_EQ(first_.error, 0);
}

TEST_F(CoarserTileTest, BorderStaysToTheLastBit) {
  const TileMesh tile = Coarse(2);
  EXPECT_LT(tile.mesh.faces.size(), (faces_[0].size() + faces_[1].size()) / 3);
  std::set<std::pair<int, int>> edges;
  for (const Eigen::Vector3i& f : tile.mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      edges.emplace(tile.vertex_ids[f[c]], tile.vertex_ids[f[(c + 1) % 3]]);
    }
  }
  size_t num_border = 0;
  std::set<std::pair<int, int>> outside;
  for (const int f : faces_[2]) {
    for (int c = 0; c < 3; ++c) {
      outside.emplace(textured_.mesh.faces[f][c], textured_.mesh.faces[f][(c + 1) % 3]);
    }
  }
  for (const auto& faces : {faces_[0], faces_[1]}) {
    for (const int f : faces) {
      for (int c = 0; c < 3; ++c) {
        const int a = textured_.mesh.faces[f][c], b = textured_.mesh.faces[f][(c + 1) % 3];
        if (!outside.contains({b, a})) continue;
        ++num_border;
        EXPECT_TRUE(edges.contains({a, b}));
      }
    }
  }
  EXPECT_GT(num_border, 40u);
  for (size_t v = 0; v < tile.vertex_ids.size(); ++v) {
    if (tile.vertex_ids[v] < 0) continue;
    EXPECT_EQ(tile.mesh.vertices[v], textured_.mesh.vertices[tile.vertex_ids[v]]);
  }
}

TEST_F(CoarserTileTest, ErrorBoundsTheDistance) {
  const TileMesh tile = Coarse(2);
  EXPECT_GT(tile.error, 0);
  EXPECT_LT(tile.error, 0.2);
  const MeshTracer tracer(textured_.mesh, RunContext(1));
  for (const Eigen::Vector3d& x : tile.mesh.vertices) {
    EXPECT_LE(tracer.Closest(x)->distance, tile.error + 1e-6);
  }
}

TEST_F(CoarserTileTest, TextureShowsTheTrueColours) {
  const TileMesh tile = Coarse(2);
  EXPECT_NEAR(tile.texel_size, 2 * first_.texel_size, 0.2 * first_.texel_size);
  const MeshTracer tracer(textured_.mesh, RunContext(1));
  double sum = 0, largest = 0;
  for (size_t f = 0; f < tile.mesh.faces.size(); ++f) {
    for (const Eigen::Vector3d& weights :
         {Eigen::Vector3d(0.3, 0.3, 0.4), Eigen::Vector3d(0.98, 0.01, 0.01),
          Eigen::Vector3d(0.5, 0.5, 0)}) {
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (int c = 0; c < 3; ++c) x += weights[c] * tile.mesh.vertices[tile.mesh.faces[f][c]];
      const Eigen::Vector3f truth = SmoothColor(tracer.Closest(x)->x_in_world).cast<float>();
      const double error = (TileColor(tile, f, weights) - truth).cwiseAbs().maxCoeff();
      sum += error;
      largest = std::max(largest, error);
    }
  }
  EXPECT_LT(sum / static_cast<double>(3 * tile.mesh.faces.size()), 1.0);
  EXPECT_LT(largest, 8);
}

// Nothing is thrown away that a tile has room for.
TEST_F(CoarserTileTest, SmallTilesStayAsFineAsTheyAre) {
  const CoarserTileOptions roomy;
  const TileMesh tile = MakeCoarserTile({&first_, &second_}, is_locked_, roomy, RunContext(2));
  EXPECT_EQ(tile.mesh.faces.size(), first_.mesh.faces.size() + second_.mesh.faces.size());
  EXPECT_NEAR(tile.texel_size, first_.texel_size, 0.1 * first_.texel_size);
  EXPECT_LT(tile.error, 1e-6);
}

TEST_F(CoarserTileTest, SameBytesForAnyNumberOfThreads) {
  const TileMesh one = Coarse(1), two = Coarse(2);
  EXPECT_EQ(one.mesh.vertices, two.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, two.mesh.faces);
  EXPECT_EQ(one.page.pixels, two.page.pixels);
  EXPECT_EQ(one.error, two.error);
}

TEST_F(CoarserTileTest, SkirtsHangUnderTheBorder) {
  TileMesh tile = Coarse(2);
  const size_t num_faces = tile.mesh.faces.size(), num_vertices = tile.mesh.vertices.size();
  const auto normals = ComputeVertexNormals(textured_.mesh);
  AddSkirts(is_locked_, normals, 0.05, &tile);
  ASSERT_GT(tile.mesh.faces.size(), num_faces + 80);
  EXPECT_EQ(tile.texcoords.size(), tile.mesh.faces.size());
  EXPECT_EQ(tile.vertex_ids.size(), tile.mesh.vertices.size());
  const MeshTracer tracer(textured_.mesh, RunContext(1));
  for (size_t v = num_vertices; v < tile.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& x = tile.mesh.vertices[v];
    const ClosestPoint nearest = *tracer.Closest(x);
    EXPECT_NEAR(nearest.distance, 0.05, 0.02);
    const Eigen::Vector3d normal = FaceNormalTimesTwiceArea(textured_.mesh, nearest.face);
    EXPECT_LT(normal.dot(x - nearest.x_in_world), 0) << "above the surface";
  }
  for (size_t f = num_faces; f < tile.mesh.faces.size(); ++f) {
    int num_lower = 0;
    for (const int v : tile.mesh.faces[f]) num_lower += v >= static_cast<int>(num_vertices);
    EXPECT_TRUE(num_lower == 1 || num_lower == 2);
  }
}

TEST(CoarserTile, VertexColoursWithoutTexture) {
  TexturedMesh colored;
  colored.mesh = BlobMesh(0.1);
  for (const Eigen::Vector3d& x : colored.mesh.vertices) {
    colored.mesh.vertex_colors.push_back(SmoothColor(x));
  }
  std::vector<int> faces(colored.mesh.faces.size());
  for (size_t f = 0; f < faces.size(); ++f) faces[f] = static_cast<int>(f);
  const TileMesh finest = MakeFinestTile(colored, nullptr, faces);
  EXPECT_EQ(finest.mesh.vertex_colors.size(), finest.mesh.vertices.size());
  EXPECT_EQ(finest.texel_size, MeanEdgeLength(colored.mesh));
  EXPECT_LT(finest.texel_size, 0.1);
  const std::vector<uint8_t> locked(colored.mesh.vertices.size(), 0);
  const TileMesh tile = MakeCoarserTile({&finest}, locked, {1000, 1e5}, RunContext(1));
  EXPECT_FALSE(tile.has_texture());
  ASSERT_EQ(tile.mesh.vertex_colors.size(), tile.mesh.vertices.size());
  for (size_t v = 0; v < tile.mesh.vertices.size(); ++v) {
    const Eigen::Vector3i difference =
        tile.mesh.vertex_colors[v].cast<int>() - SmoothColor(tile.mesh.vertices[v]).cast<int>();
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 25);
  }
}

}  // namespace
}  // namespace lsmvs
