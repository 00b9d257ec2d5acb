// Our files in COLMAP's hands and COLMAP's in ours: the `colmap` executable and, if
// scripts/setup_pycolmap.sh was run, the current COLMAP as pycolmap. Skipped where they are
// missing.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "lsmvs/adapter_test/analytic_workspace.h"
#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/colmap_runner.h"
#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/prepare_workspace.h"
#include "lsmvs/colmap_adapter/scene_loader.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/colmap_adapter/stereo_config.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// One of the two COLMAPs, with the few things that we ask of both.
class Colmap {
 public:
  virtual ~Colmap() = default;
  virtual std::string WhyMissing() const = 0;
  virtual void Fuse(const fs::path& workspace, const fs::path& ply) const = 0;
  virtual void Convert(const fs::path& model, const fs::path& out, bool to_text) const = 0;
  virtual void PoissonMesh(const fs::path& ply, const fs::path& mesh) const = 0;
};

class Executable : public Colmap {
 public:
  std::string WhyMissing() const override {
    return runner_.available() ? "" : "the program `colmap` is not installed";
  }
  // In one thread: which pixels COLMAP fuses depends on the order in which several get to them.
  void Fuse(const fs::path& workspace, const fs::path& ply) const override {
    Run({"stereo_fusion", "--workspace_path", workspace, "--output_path", ply, "--input_type",
         "geometric", "--StereoFusion.min_num_pixels", "3", "--StereoFusion.num_threads", "1"});
  }
  void Convert(const fs::path& model, const fs::path& out, bool to_text) const override {
    fs::create_directories(out);
    Run({"model_converter", "--input_path", model, "--output_path", out, "--output_type",
         to_text ? "TXT" : "BIN"});
  }
  void PoissonMesh(const fs::path& ply, const fs::path& mesh) const override {
    Run({"poisson_mesher", "--input_path", ply, "--output_path", mesh, "--PoissonMeshing.depth",
         "6", "--PoissonMeshing.trim", "0", "--PoissonMeshing.num_threads", "1"});
  }

 private:
  void Run(const std::vector<std::string>& arguments) const {
    runner_.Run(arguments, log_.path() / "log", RunContext(1));
  }

  ColmapRunner runner_;
  TemporaryFolder log_;
};

class Pycolmap : public Colmap {
 public:
  std::string WhyMissing() const override {
    return fs::exists(python_) ? "" : "pycolmap is not installed; run scripts/setup_pycolmap.sh";
  }
  void Fuse(const fs::path& workspace, const fs::path& ply) const override {
    Run({"fuse", workspace, ply});
  }
  void Convert(const fs::path& model, const fs::path& out, bool to_text) const override {
    Run({"convert", model, out, to_text ? "txt" : "bin"});
  }
  void PoissonMesh(const fs::path& ply, const fs::path& mesh) const override {
    Run({"mesh", ply, mesh});
  }
  // What the tool printed.
  std::string Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), LSMVS_PYCOLMAP_TOOL);
    runner_.Run(arguments, log_.path() / "log", RunContext(1));
    return ReadWholeFile(log_.path() / "log");
  }

 private:
  const fs::path python_ = LSMVS_PYCOLMAP_PYTHON;
  // Runs any program with a log; this one happens to be Python.
  ColmapRunner runner_{python_};
  TemporaryFolder log_;
};

class InteropTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (std::string(GetParam()) == "pycolmap") {
      colmap_ = std::make_unique<Pycolmap>();
    } else {
      colmap_ = std::make_unique<Executable>();
    }
    if (!colmap_->WhyMissing().empty()) GTEST_SKIP() << colmap_->WhyMissing();
  }
  bool is_current() const { return std::string(GetParam()) == "pycolmap"; }

  TemporaryFolder folder_;
  std::unique_ptr<Colmap> colmap_;
};

INSTANTIATE_TEST_SUITE_P(Colmaps, InteropTest, testing::Values("executable", "pycolmap"),
                         [](const auto& instance) { return std::string(instance.param); });

// Sorts what COLMAP may reorder.
SparseModel Sorted(SparseModel model) {
  const auto by_id = [](const auto& a, const auto& b) { return a.image_id < b.image_id; };
  std::sort(model.images.begin(), model.images.end(), by_id);
  std::sort(model.points3d.begin(), model.points3d.end(),
            [](const auto& a, const auto& b) { return a.point3d_id < b.point3d_id; });
  model.rigs.clear();
  model.frames.clear();
  return model;
}

void ExpectNearlySame(const SparseModel& a, const SparseModel& b) {
  ASSERT_EQ(a.images.size(), b.images.size());
  ASSERT_EQ(a.points3d.size(), b.points3d.size());
  for (size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].image_id, b.images[i].image_id);
    EXPECT_EQ(a.images[i].name, b.images[i].name);
    EXPECT_EQ(a.images[i].num_points2d, b.images[i].num_points2d);
    const Rigid3 pose_a = a.images[i].cam_from_world.ToRigid3();
    const Rigid3 pose_b = b.images[i].cam_from_world.ToRigid3();
    EXPECT_LT((pose_a.OriginInSource() - pose_b.OriginInSource()).norm(), 1e-12);
    EXPECT_LT((pose_a.rotation - pose_b.rotation).norm(), 1e-12);
  }
  for (size_t p = 0; p < a.points3d.size(); ++p) {
    EXPECT_EQ(a.points3d[p].x_in_world, b.points3d[p].x_in_world);
    EXPECT_EQ(a.points3d[p].color, b.points3d[p].color);
    EXPECT_EQ(a.points3d[p].track.size(), b.points3d[p].track.size());
  }
}

TEST_P(InteropTest, SparseModelsGoThereAndBack) {
  const AnalyticWorkspace data = MakeAnalyticWorkspace(folder_.path(), *MakePlane());
  for (const SparseFormat ours : {SparseFormat::kBinary, SparseFormat::kText}) {
    for (const bool to_text : {false, true}) {
      const TemporaryFolder in, out;
      WriteSparseModel(in.path(), data.model, ours);
      colmap_->Convert(in.path(), out.path(), to_text);
      const SparseModel read = ReadSparseModel(out.path());
      ExpectNearlySame(Sorted(read), Sorted(data.model));
      EXPECT_EQ(read.frames.size(), is_current() ? data.model.images.size() : 0u);
    }
  }
}

// Distance of the points from the surface in units of the ground sampling distance; the mean has
// its sign turned where the surface faces the other way along the diagonal of the image, so that
// the two sides of a sphere do not cancel.
struct Distance {
  double bias = 0, mean_absolute = 0;
};

Distance MeasureDistance(const AnalyticWorkspace& data, const AnalyticSurface& surface,
                         const VisibilityCloud& cloud) {
  constexpr double kMinFacing = 0.3;
  const Eigen::Matrix3d& rotation = data.scene.views[0].cam_from_world.rotation;
  Distance distance;
  double count = 0;
  for (const Eigen::Vector3f& position : cloud.positions) {
    const Eigen::Vector3d x = position.cast<double>();
    const Eigen::Vector3d normal = rotation * surface.Normal(x);
    if (normal.z() > -kMinFacing) continue;
    const double signed_distance = surface.SignedDistance(x);
    distance.bias += normal.x() + normal.y() < 0 ? signed_distance : -signed_distance;
    distance.mean_absolute += std::abs(signed_distance);
    ++count;
  }
  const double gsd = GroundSamplingDistance(data.scene);
  return {distance.bias / count / gsd, distance.mean_absolute / count / gsd};
}

void WriteTrueDepthMaps(const AnalyticWorkspace& data, const AnalyticSurface& surface, int width,
                        int height, bool without_half_pixel) {
  for (int v = 0; v < data.scene.num_views(); ++v) {
    const View& view = data.scene.views[static_cast<size_t>(v)];
    DepthMap map = data.TrueDepthMap(surface, v, width, height);
    if (without_half_pixel) MoveSamplesToPixelCenters(view.camera, &map);
    WriteDepthMap(data.workspace, view, DepthMapKind::kGeometric, map);
  }
}

TEST_P(InteropTest, OurDepthMapsFuseWithoutBias) {
  for (const auto& surface : {MakePlane(), MakeSphere()}) {
    const TemporaryFolder folder;
    const AnalyticWorkspace data = MakeAnalyticWorkspace(folder.path(), *surface);
    for (const int scale : {1, 2}) {
      WriteTrueDepthMaps(data, *surface, 320 / scale, 240 / scale, false);
      colmap_->Fuse(folder.path(), data.workspace.FusedPath());
      const FusedCloud fused =
          ReadFusedCloud(data.workspace.FusedPath(), data.scene, data.workspace);
      EXPECT_EQ(fused.message, "");
      EXPECT_GT(fused.cloud.size(), 5000u / static_cast<size_t>(scale * scale));
      const Distance distance = MeasureDistance(data, *surface, fused.cloud);
      RecordProperty(fmt::format("bias_gsd_scale{}", scale), fmt::format("{:.4f}", distance.bias));
      EXPECT_LT(std::abs(distance.bias), 0.05 * scale);
      EXPECT_LT(distance.mean_absolute, 0.1 * scale);
    }
  }
}

TEST_P(InteropTest, TheHalfPixelMatters) {
  const auto surface = MakePlane();
  const AnalyticWorkspace data = MakeAnalyticWorkspace(folder_.path(), *surface);
  WriteTrueDepthMaps(data, *surface, 320, 240, true);
  colmap_->Fuse(folder_.path(), data.workspace.FusedPath());
  const FusedCloud fused = ReadFusedCloud(data.workspace.FusedPath(), data.scene, data.workspace);
  EXPECT_GT(std::abs(MeasureDistance(data, *surface, fused.cloud).bias), 0.15);
}

// Fraction of (point, view) pairs of a cloud in which the view's true depth at the point's
// projection is the point's.
double FractionSeen(const AnalyticWorkspace& data, const AnalyticSurface& surface,
                    const VisibilityCloud& cloud) {
  size_t num_pairs = 0, num_seen = 0;
  for (size_t p = 0; p < cloud.size(); p += 17) {
    const Eigen::Vector3d x = cloud.positions[p].cast<double>();
    for (const uint32_t v : cloud.ViewsOf(p)) {
      const View& view = data.scene.views[v];
      const Eigen::Vector3d center = view.CenterInWorld();
      const auto t = surface.Intersect(center, x - center);
      ++num_pairs;
      num_seen += t && std::abs(*t - 1) < 0.02 &&
                  view.camera.Contains(view.camera.Project(view.cam_from_world * x));
    }
  }
  return static_cast<double>(num_seen) / static_cast<double>(num_pairs);
}

TEST_P(InteropTest, VisibilityIndicesAreInRegisteredOrder) {
  // One view has no depth map worth the name, so the wrong order would be seen: it must never
  // appear.
  const auto surface = MakeSphere();
  for (const bool with_rigs : {false, true}) {
    if (with_rigs && !is_current()) continue;
    const TemporaryFolder folder;
    AnalyticWorkspace data = MakeAnalyticWorkspace(folder.path(), *surface);
    if (with_rigs) {
      AddTrivialRigsAndFrames(&data.model);
      std::swap(data.model.frames[0], data.model.frames[4]);
      WriteSparseModel(data.workspace.SparseFolder(), data.model);
      data.scene = LoadScene(data.workspace);
    }
    WriteTrueDepthMaps(data, *surface, 320, 240, false);
    const View& blind = data.scene.views[1];
    DepthMap empty = data.TrueDepthMap(*surface, 1, 320, 240);
    std::fill(empty.depth.pixels.begin(), empty.depth.pixels.end(), 0.0f);
    WriteDepthMap(data.workspace, blind, DepthMapKind::kGeometric, empty);
    colmap_->Fuse(folder.path(), data.workspace.FusedPath());
    const FusedCloud fused = ReadFusedCloud(data.workspace.FusedPath(), data.scene, data.workspace);
    EXPECT_EQ(fused.message, "");
    EXPECT_GT(FractionSeen(data, *surface, fused.cloud), 0.99);
    std::vector<size_t> counts(6);
    for (const uint32_t v : fused.cloud.view_idxs) ++counts[v];
    for (size_t v = 0; v < 6; ++v) EXPECT_EQ(counts[v] > 0, v != 1) << v;
  }
}

TEST_P(InteropTest, OurFusedCloudMakesAPoissonMesh) {
  const auto surface = MakeSphere();
  const AnalyticWorkspace data = MakeAnalyticWorkspace(folder_.path(), *surface);
  VisibilityCloud cloud;
  const std::vector<uint32_t> views = {0, 1};
  constexpr int kNumPoints = 1500;
  for (int i = 0; i < kNumPoints; ++i) {
    const double z = 1 - 2 * (i + 0.5) / kNumPoints, angle = 2.399963 * i;
    const Eigen::Vector3d x(std::sqrt(1 - z * z) * std::cos(angle),
                            std::sqrt(1 - z * z) * std::sin(angle), z);
    cloud.Add(x.cast<float>(), x.cast<float>(), Color(200, 100, 50), views);
  }
  WriteFusedCloud(data.workspace.FusedPath(), cloud, data.scene);
  colmap_->PoissonMesh(data.workspace.FusedPath(), data.workspace.PoissonMeshPath());
  const TriangleMesh mesh = ReadMeshPly(data.workspace.PoissonMeshPath());
  EXPECT_GT(mesh.faces.size(), 500u);
  for (const Eigen::Vector3d& x : mesh.vertices) {
    EXPECT_LT(std::abs(surface->SignedDistance(x)), 0.05);
  }
}

// --- The executable alone.

TEST(ColmapExecutableTest, UndistortsAProject) {
  const ColmapRunner runner;
  if (!runner.available()) GTEST_SKIP() << "the program `colmap` is not installed";
  EXPECT_NE(runner.Version(), "");
  const TemporaryFolder folder;
  AnalyticWorkspace data = MakeAnalyticWorkspace(folder.path(), *MakePlane());
  // Two distorted models of the same photos.
  data.model.cameras[0].model_id = 2;
  data.model.cameras[0].params = {300, 160, 120, 0.02};
  fs::remove_all(folder.path() / "sparse");
  fs::remove_all(folder.path() / "stereo");
  WriteSparseModel(folder.path() / "sparse/0", data.model);
  WriteSparseModel(folder.path() / "sparse/1", data.model, SparseFormat::kText);
  PrepareWorkspaceOptions options;
  options.max_image_size = 200;
  const auto workspaces = PrepareDenseWorkspaces(folder.path(), runner, options, RunContext(1));
  ASSERT_EQ(workspaces.size(), 2u);
  for (const DenseWorkspace& workspace : workspaces) {
    const Scene scene = LoadScene(workspace);
    EXPECT_EQ(scene.num_views(), 6);
    EXPECT_LE(scene.views[0].camera.width, 200);
    EXPECT_EQ(scene.points.size(), data.model.points3d.size());
    EXPECT_EQ(ReadFusionConfig(workspace.FusionConfigPath()).size(), 6u);
    EXPECT_EQ(ReadPatchMatchConfig(workspace.PatchMatchConfigPath()).size(), 6u);
  }
}

// --- The current COLMAP alone.

class PycolmapTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!colmap_.WhyMissing().empty()) GTEST_SKIP() << colmap_.WhyMissing();
  }

  struct Description {
    std::vector<std::pair<std::string, Eigen::Vector3d>> images;  // name, centre
    size_t num_points = 0;
    double mean_track_length = 0;
  };
  Description Describe(const fs::path& model) const {
    Description description;
    std::istringstream text(colmap_.Run({"describe", model}));
    std::string first, name;
    while (text >> first && first != "points") {
      Eigen::Vector3d center;
      text >> name >> center.x() >> center.y() >> center.z();
      description.images.emplace_back(name, center);
    }
    text >> description.num_points >> description.mean_track_length;
    return description;
  }
  // What pycolmap says of a model must be what we read in it, in the same order.
  void ExpectAgrees(const fs::path& folder) const {
    const Description theirs = Describe(folder);
    const SparseModel ours = ReadSparseModel(folder);
    const std::vector<size_t> order = RegisteredImageOrder(ours);
    ASSERT_EQ(theirs.images.size(), order.size());
    for (size_t i = 0; i < order.size(); ++i) {
      const SparseModel::Image& image = ours.images[order[i]];
      EXPECT_EQ(image.name, theirs.images[i].first);
      const Eigen::Vector3d center = image.cam_from_world.ToRigid3().OriginInSource();
      EXPECT_LT((center - theirs.images[i].second).norm(), 1e-9);
    }
    EXPECT_EQ(ours.points3d.size(), theirs.num_points);
  }

  Pycolmap colmap_;
  TemporaryFolder folder_;
};

TEST_F(PycolmapTest, ReadsOurModels) {
  const AnalyticWorkspace data = MakeAnalyticWorkspace(folder_.path(), *MakePlane());
  for (const bool with_rigs : {false, true}) {
    SparseModel model = data.model;
    if (with_rigs) {
      AddTrivialRigsAndFrames(&model);
      std::reverse(model.frames.begin(), model.frames.end());
    }
    for (const SparseFormat format : {SparseFormat::kBinary, SparseFormat::kText}) {
      const TemporaryFolder out;
      WriteSparseModel(out.path(), model, format);
      ExpectAgrees(out.path());
    }
  }
}

// A rig of two cameras whose frames name the second camera's image first.
TEST_F(PycolmapTest, AgreesOnTheOrderInsideAFrame) {
  using enum SparseModel::SensorType;
  SparseModel model = MakeAnalyticWorkspace(folder_.path(), *MakePlane()).model;
  model.cameras.push_back(model.cameras[0]);
  model.cameras[1].camera_id = CameraId{8};
  const SparseModel::Pose identity;
  model.rigs = {{RigId{1}, {{{kCamera, 3}, {}}, {{kCamera, 8}, identity}}}};
  for (size_t f = 0; f < 3; ++f) {
    SparseModel::Image &first = model.images[2 * f], &second = model.images[2 * f + 1];
    second.camera_id = CameraId{8};
    second.cam_from_world = first.cam_from_world;
    model.frames.push_back({FrameId{static_cast<uint32_t>(9 - f)},
                            RigId{1},
                            first.cam_from_world,
                            {{{kCamera, 8}, static_cast<uint64_t>(second.image_id)},
                             {{kCamera, 3}, static_cast<uint64_t>(first.image_id)}}});
  }
  for (const SparseFormat format : {SparseFormat::kBinary, SparseFormat::kText}) {
    const TemporaryFolder out;
    WriteSparseModel(out.path(), model, format);
    ExpectAgrees(out.path());
  }
}

TEST_F(PycolmapTest, ItsRigsAndFramesAreRead) {
  const fs::path binary = folder_.path() / "bin", text = folder_.path() / "txt";
  colmap_.Run({"rigs", binary, text});
  ExpectAgrees(binary);
  ExpectAgrees(text);
  const SparseModel model = ReadSparseModel(binary);
  EXPECT_EQ(model.rigs.size(), 2u);
  EXPECT_EQ(model.frames.size(), 6u);
  EXPECT_TRUE(model.rigs[0].sensors[1].sensor_from_rig.has_value());
  EXPECT_EQ(ReadSparseModel(text).frames.size(), 6u);
  // The composed poses in images.bin are those of rig and frame.
  std::map<uint64_t, const SparseModel::Image*> image_of;
  for (const auto& image : model.images) image_of[static_cast<uint64_t>(image.image_id)] = &image;
  for (const auto& frame : model.frames) {
    for (const auto& data : frame.data) {
      for (const auto& rig : model.rigs) {
        for (const auto& mount : rig.sensors) {
          if (rig.rig_id != frame.rig_id || mount.sensor.id != data.sensor.id) continue;
          Rigid3 pose = frame.rig_from_world.ToRigid3();
          if (mount.sensor_from_rig) pose = mount.sensor_from_rig->ToRigid3() * pose;
          const Rigid3 composed = image_of.at(data.data_id)->cam_from_world.ToRigid3();
          EXPECT_LT((pose.rotation - composed.rotation).norm(), 1e-9);
          EXPECT_LT((pose.translation - composed.translation).norm(), 1e-9);
        }
      }
    }
  }
  // And what we write of them is what they wrote.
  const TemporaryFolder out;
  WriteSparseModel(out.path(), model);
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin", "rigs.bin", "frames.bin"}) {
    EXPECT_TRUE(ReadWholeFile(binary / name) == ReadWholeFile(out.path() / name)) << name;
  }
}

}  // namespace
}  // namespace lsmvs
