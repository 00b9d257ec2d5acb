#include "lsmvs/refinement/finishing/vertex_quality.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lsmvs {
namespace {

// Two triangles that share an edge, and one by itself.
TriangleMesh ThreeFaces() {
  TriangleMesh mesh;
  mesh.vertices.resize(7, Eigen::Vector3d::Zero());
  mesh.faces = {{0, 1, 2}, {1, 3, 2}, {4, 5, 6}};
  return mesh;
}

// Four views; the first face has pair (0, 1), the second (0, 1) and (2, 3), the third none.
FacePairs SomePairs() {
  FacePairs pairs;
  pairs.pairs = {{0, 1}, {1, 0}, {2, 3}};
  pairs.per_face = 2;
  pairs.of_face = {0, -1, 1, 2, -1, -1};
  return pairs;
}

PhotoTerms Terms(double error_per_mass) {
  const auto error = static_cast<float>(error_per_mass);
  PhotoTerms terms;
  terms.pixels = {10, 20, 0};
  terms.mass = {10, 20, 0};
  terms.error = {10 * error, 20 * error, 0};
  return terms;
}

double ByViews(double n) { return 1 - std::exp(-n * n / (2 * 1.5 * 1.5)); }

TEST(VertexQuality, TellsHowManyPhotosAgree) {
  const std::vector<float> quality = VertexQuality(ThreeFaces(), SomePairs(), Terms(0));
  ASSERT_EQ(quality.size(), 7u);
  EXPECT_NEAR(quality[0], ByViews(2), 1e-6);
  for (const size_t v : {1, 2, 3}) EXPECT_NEAR(quality[v], ByViews(4), 1e-6);
  for (const size_t v : {4, 5, 6}) EXPECT_EQ(quality[v], 0.0f);
}

TEST(VertexQuality, FallsWithThePhotoError) {
  const std::vector<float> half =
      VertexQuality(ThreeFaces(), SomePairs(), Terms(0.5 * kUnlikePhotoError));
  EXPECT_NEAR(half[0], 0.5 * ByViews(2), 1e-6);
  const std::vector<float> unlike =
      VertexQuality(ThreeFaces(), SomePairs(), Terms(2 * kUnlikePhotoError));
  for (const float quality : unlike) EXPECT_EQ(quality, 0.0f);
}

TEST(VertexQuality, WithoutTextureNothingIsTold) {
  PhotoTerms terms = Terms(2 * kUnlikePhotoError);
  for (size_t f = 0; f < 3; ++f) terms.mass[f] = terms.error[f] = 0;
  EXPECT_NEAR(VertexQuality(ThreeFaces(), SomePairs(), terms)[0], 0.5 * ByViews(2), 1e-6);
  // Half of the texture that is needed: halfway between that and what the photos say.
  terms = Terms(0);
  for (float& mass : terms.mass) mass *= 0.5f * static_cast<float>(kFullMassShare);
  EXPECT_NEAR(VertexQuality(ThreeFaces(), SomePairs(), terms)[0], 0.75 * ByViews(2), 1e-6);
}

}  // namespace
}  // namespace lsmvs
