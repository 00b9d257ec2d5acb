#include "lsmvs/colmap_adapter/pmvs_scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Two photos of 64 x 48 and three points, as `colmap image_undistorter --output_type PMVS` writes
// them: matrices with six digits.
class PmvsScene : public testing::Test {
 protected:
  PmvsScene() {
    for (int i = 0; i < 2; ++i) {
      View view;
      view.camera = {64, 48, 70.5, 71.25, 31.5, 24.75};
      view.cam_from_world =
          Rigid3(Eigen::Quaterniond(0.9, 0.1 * i, -0.3, 0.2), Eigen::Vector3d(0.5, -i, 4));
      views_.push_back(view);
      Write(fmt::format("txt/{:08d}.txt", i), Matrix(view, 1));
      ColorImage photo(64, 48);
      const std::vector<uint8_t> jpeg = EncodeJpeg(photo, 90);
      Write(fmt::format("visualize/{:08d}.jpg", i), std::string(jpeg.begin(), jpeg.end()));
    }
    Write("bundle.rd.out", Bundle(2));
  }

  static std::string Matrix(const View& view, double scale) {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << view.cam_from_world.rotation, view.cam_from_world.translation;
    matrix = scale * view.camera.Matrix() * matrix;
    std::string text = "CONTOUR\n";
    for (int row = 0; row < 3; ++row) {
      text += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", matrix(row, 0), matrix(row, 1),
                          matrix(row, 2), matrix(row, 3));
    }
    return text;
  }
  static std::string Bundle(int num_photos) {
    std::string text = fmt::format("# Bundle file v0.3\n{} 2\n", num_photos);
    for (int i = 0; i < num_photos; ++i) text += "70 0 0\n1 0 0\n0 -1 0\n0 0 -1\n0 0 0\n";
    return text +
           "0.5 0.25 2\n10 20 30\n2 1 7 -3.5 4 0 9 1 2\n-1 0 3\n0 0 255\n2 0 1 1 1 0 2 3 3\n";
  }
  void Write(const fs::path& name, const std::string& text) {
    fs::create_directories((folder_.path() / name).parent_path());
    WriteFileAtomically(folder_.path() / name, text);
  }
  void ExpectRefused(const std::string& what) {
    try {
      LoadPmvsScene(folder_.path());
      ADD_FAILURE() << "not refused: " << what;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
    }
  }

  TemporaryFolder folder_;
  std::vector<View> views_;
};

TEST_F(PmvsScene, CamerasProjectAsTheyDid) {
  const Scene scene = LoadPmvsScene(folder_.path());
  ASSERT_EQ(scene.num_views(), 2);
  const Eigen::Vector3d x(0.3, -0.2, 1.5);
  for (size_t i = 0; i < 2; ++i) {
    const View &view = scene.views[i], &truth = views_[i];
    EXPECT_EQ(view.camera.width, 64);
    EXPECT_EQ(view.camera.height, 48);
    EXPECT_NEAR(view.camera.fx, 70.5, 1e-3);
    EXPECT_NEAR(view.camera.fy, 71.25, 1e-3);
    EXPECT_NEAR(view.camera.cx, 31.5, 1e-3);
    EXPECT_NEAR(view.camera.cy, 24.75, 1e-3);
    EXPECT_TRUE(view.cam_from_world.rotation.isApprox(truth.cam_from_world.rotation, 1e-5));
    EXPECT_NEAR(view.cam_from_world.rotation.determinant(), 1, 1e-9);
    EXPECT_LT((view.CenterInWorld() - truth.CenterInWorld()).norm(), 1e-4);
    EXPECT_LT((view.camera.Project(view.cam_from_world * x) -
               truth.camera.Project(truth.cam_from_world * x))
                  .norm(),
              2e-3);
  }
  EXPECT_EQ(scene.views[1].name, "00000001.jpg");
}

TEST_F(PmvsScene, ScaleOfAMatrixDoesNotMatter) {
  const Scene scene = LoadPmvsScene(folder_.path());
  for (const double scale : {-1.0, -3.0, 0.01}) {
    Write("txt/00000000.txt", Matrix(views_[0], scale));
    const View view = LoadPmvsScene(folder_.path()).views[0];
    EXPECT_NEAR(view.camera.fx, scene.views[0].camera.fx, 1e-3);
    EXPECT_GT(view.Depth({0, 0, 1}), 0);
  }
}

TEST_F(PmvsScene, SparsePointsComeFromTheBundle) {
  Scene scene = LoadPmvsScene(folder_.path());
  ASSERT_EQ(scene.points.size(), 2u);
  EXPECT_EQ(scene.points[0].x_in_world, Eigen::Vector3d(0.5, 0.25, 2));
  EXPECT_EQ(scene.points[0].view_idxs, (std::vector<int>{0, 1}));
  EXPECT_EQ(scene.points[1].color, Color(0, 0, 255));
  EXPECT_EQ(scene.points[1].view_idxs, std::vector<int>{0});
  fs::remove(folder_.path() / "bundle.rd.out");
  EXPECT_TRUE(LoadPmvsScene(folder_.path()).points.empty());
}

TEST_F(PmvsScene, BadFoldersAreRefused) {
  const std::string bundle = Bundle(2);
  Write("bundle.rd.out", Bundle(3));
  ExpectRefused("tells of 3 photos, but txt/ has 2 matrices");
  Write("bundle.rd.out", bundle.substr(0, bundle.size() - 20));
  ExpectRefused("bundle.rd.out: line");
  Write("bundle.rd.out", bundle);
  const std::string matrix = Matrix(views_[0], 1);
  Write("txt/00000000.txt", matrix.substr(0, matrix.size() / 2));
  ExpectRefused("txt/00000000.txt: line");
  Write("txt/00000000.txt", "CONTOUR\nnan 0 0 0\n0 1 0 0\n0 0 1 0\n");
  ExpectRefused("not finite");
  Write("txt/00000000.txt", "CONTOUR\n1 0 0 0\n0 1 0 0\n1 1 0 0\n");
  ExpectRefused("is no matrix of a camera");
  Write("txt/00000000.txt", "CONTOUR\n100 5 32 0\n0 100 24 0\n0 0 1 0\n");
  ExpectRefused("skewed");
  Write("txt/00000000.txt", matrix);
  fs::remove(folder_.path() / "visualize" / "00000001.jpg");
  ExpectRefused("00000001.jpg");
}

}  // namespace
}  // namespace lsmvs
