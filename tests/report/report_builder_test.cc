#include "lsmvs/report/report_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

// A sphere with rendered photos, and a mesh of it that is 5 % too large.
class ReportBuilderTest : public testing::Test {
 protected:
  ReportBuilderTest() : scene_(MakeScene(ShapeName::kSphere, 4, 96, 72)) {
    WritePhotos(*scene_.shape, scene_.photo, (folder_.path() / "images").string(), &scene_.scene,
                context_);
    larger_.mesh = truth_ = TruthMesh(scene_);
    for (Eigen::Vector3d& x : larger_.mesh.vertices) x *= 1.05;
  }

  ReportSource Source(const std::string& name) const {
    return {folder_.path() / name, "a title", "a test", 123};
  }

  const RunContext context_{2};
  const TemporaryFolder folder_;
  SyntheticScene scene_;
  TriangleMesh truth_;
  TexturedMesh larger_;
};

TEST_F(ReportBuilderTest, MeasuresAndDrawsAgainstTheTruth) {
  ReportOptions options;
  options.picture_width = 64;
  options.max_num_photos = 2;
  options.surface.num_samples = 2000;
  ReportBuilder builder(scene_.scene, options, folder_.path(), context_);
  builder.SetTruth(truth_);
  builder.AddMesh(larger_, Source("larger.ply"));
  TexturedMesh exact;
  exact.mesh = truth_;
  builder.AddMesh(exact, Source("exact.ply"));
  builder.AddViews();

  const Report& report = builder.report();
  ASSERT_EQ(report.meshes.size(), 2u);
  const ReportMesh &larger = report.meshes[0], &right = report.meshes[1];
  EXPECT_EQ(larger.file, "larger.ply");
  EXPECT_EQ(larger.file_bytes, 123u);
  EXPECT_LT(right.figures.surface->accuracy.mean, 0.1 * larger.figures.surface->accuracy.mean);
  EXPECT_GT(right.figures.photometric->score, larger.figures.photometric->score);
  ASSERT_EQ(larger.errors.size(), larger.shown.vertices.size());
  EXPECT_LT(*std::max_element(right.errors.begin(), right.errors.end()),
            *std::min_element(larger.errors.begin(), larger.errors.end()));
  for (const char* picture : {"larger.png", "larger-errors.png", "exact.png", "exact-errors.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / picture)) << picture;
  }
  // Colours came from the photos.
  EXPECT_EQ(larger.shown.vertex_colors.size(), larger.shown.vertices.size());

  ASSERT_EQ(report.photos.size(), 4u);
  const auto has_picture = [](const ReportPhoto& photo) { return !photo.jpeg.empty(); };
  const auto num_pictures = std::count_if(report.photos.begin(), report.photos.end(), has_picture);
  EXPECT_GE(num_pictures, 2);
  EXPECT_LE(num_pictures, 3);  // the one that the page opens with has its picture at any rate
  ASSERT_GE(report.key_photo, 0);
  EXPECT_TRUE(has_picture(report.photos[static_cast<size_t>(report.key_photo)]));
  EXPECT_LT((report.focus - scene_.scene.world_offset).norm(), report.radius);
}

TEST_F(ReportBuilderTest, CloudsHaveFiguresOnly) {
  ReportBuilder builder(scene_.scene, {}, folder_.path(), context_);
  TriangleMesh cloud = truth_;
  cloud.faces.clear();
  builder.AddCloud(cloud, {}, {}, Source("cloud.ply"));
  ASSERT_EQ(builder.report().clouds.size(), 1u);
  EXPECT_EQ(builder.report().clouds[0].figures.cloud->num_points, truth_.vertices.size());
  EXPECT_FALSE(builder.report().clouds[0].figures.surface);
}

TEST_F(ReportBuilderTest, RefusesOptionsOutOfRange) {
  ReportOptions options;
  options.picture_width = 0;
  EXPECT_THROW(ReportBuilder(scene_.scene, options, folder_.path(), context_), UsageError);
}

}  // namespace
}  // namespace lsmvs
