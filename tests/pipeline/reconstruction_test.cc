#include "lsmvs/pipeline/reconstruction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>

#include <fstream>
#include <set>

#include "lsmvs/execution/file_table.h"
#include "lsmvs/execution/job_order.h"
#include "lsmvs/pipeline/job_scene.h"
#include "lsmvs/synthetic/synthetic_scene.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Names files below /w; reads and writes none.
class NamedFiles : public WorkspaceFiles {
 public:
  std::vector<fs::path> ModelFiles() const override { return {"/w/cameras", "/w/images"}; }
  fs::path PointsFile() const override { return "/w/points3D"; }
  std::array<fs::path, 2> DepthMapFiles(const View& view, DepthMapKind kind) const override {
    const std::string end = kind == DepthMapKind::kPhotometric ? ".photometric" : ".geometric";
    return {"/w/depth/" + view.name + end, "/w/normal/" + view.name + end};
  }
  void CheckDepthMap(const View&, DepthMapKind) const override {}
  void WriteDepthMap(const View&, DepthMapKind, const DepthMap&, MapPrecision,
                     const std::vector<fs::path>&) const override {}
  std::unique_ptr<DepthMapSource> OpenDepthMaps(const Scene&, DepthMapKind, size_t) const override {
    return nullptr;
  }
  fs::path CloudFile() const override { return "/w/fused.ply"; }
  std::vector<fs::path> CloudFiles(const fs::path& cloud) const override {
    return {cloud, cloud.string() + ".vis"};
  }
  VisibilityCloud ReadCloud(const fs::path&, const Scene&) const override { return {}; }
  void SampleCloud(const fs::path&, const Scene&, CloudSampler*) const override {}
  void WriteCloud(const Scene&, const std::vector<fs::path>&,
                  const std::function<void(const CloudSink&)>& write) const override {
    write([](const VisibilityCloud&) {});
  }
  fs::path CloudPartFile(const fs::path& cloud, int part) const override {
    return cloud.string() + ".part" + std::to_string(part);
  }
  CloudCounts JoinClouds(const Scene&, const std::vector<fs::path>&,
                         const std::vector<fs::path>&) const override {
    return {};
  }
  fs::path KeypointFile() const override { return "/w/database"; }
  std::vector<std::vector<Eigen::Vector2f>> ReadKeypoints(const Scene&) const override {
    return {};
  }
  std::vector<fs::path> VisibleMeshFiles(const fs::path& mesh) const override {
    return {mesh, mesh.string() + ".vis"};
  }
  void WriteVisibility(const std::vector<uint64_t>&, const std::vector<uint32_t>&,
                       const fs::path&) const override {}
  fs::path VisibilityMeshFile() const override { return "/w/visibility.ply"; }
  fs::path RefinedMeshFile() const override { return "/w/refined.ply"; }
  fs::path TexturedMeshFile() const override { return "/w/textured/mesh.ply"; }
};

constexpr int kNumViews = 4;

ReconstructionPtr Make(const ReconstructionOptions& options = {},
                       size_t memory_budget_bytes = size_t{1} << 30) {
  RunContext context(1);
  context.memory_budget_bytes = memory_budget_bytes;
  return MakeReconstruction(MakeScene(ShapeName::kSphere, kNumViews, 64, 48).scene,
                            std::make_shared<NamedFiles>(), options, context);
}

std::vector<Task> AllTasks(const ReconstructionPtr& reconstruction) {
  const auto stages = StagesOf(reconstruction->options.point_source);
  return MakeReconstructionTasks(reconstruction, stages.front(), stages.back());
}

ReconstructionOptions QuasiDense() {
  ReconstructionOptions options;
  options.point_source = PointSource::kQuasiDense;
  return options;
}

std::vector<std::string> Options(const std::vector<Task>& tasks) {
  std::vector<std::string> options;
  for (const Task& task : tasks) options.push_back(task.stage + ": " + task.options);
  return options;
}

TEST(ReconstructionTasks, InputsComeFromPhotosModelAndEarlierTasks) {
  const std::vector<Task> tasks = AllTasks(Make());
  ASSERT_EQ(tasks.size(), 2 * kNumViews + 4u);
  std::set<std::string> made, names;
  for (const Task& task : tasks) {
    EXPECT_TRUE(names.insert(task.name).second) << task.name;
    for (const fs::path& input : task.inputs) {
      if (input.string().starts_with("/w/") && input != "/w/cameras" && input != "/w/images") {
        EXPECT_TRUE(made.contains(input)) << task.name << " reads " << input;
      }
    }
    for (const fs::path& output : task.outputs) {
      EXPECT_TRUE(made.insert(output).second) << output;
    }
  }
}

TEST(ReconstructionTasks, OnlyWhatIsAskedForIsWanted) {
  for (const Task& task : AllTasks(Make())) EXPECT_EQ(task.wanted, task.stage != kStereoStage);
  const std::vector<Task> stereo =
      MakeReconstructionTasks(Make(), ReconstructionStage::kStereo, ReconstructionStage::kStereo);
  ASSERT_EQ(stereo.size(), 2u * kNumViews);
  for (int i = 0; i < kNumViews; ++i) {
    EXPECT_FALSE(stereo[i].wanted);
    EXPECT_TRUE(stereo[kNumViews + i].wanted);
  }
}

TEST(ReconstructionTasks, WithoutTheGeometricPassFusionTakesPhotometricMaps) {
  ReconstructionOptions options;
  options.patch_match.geom_consistency = false;
  const std::vector<Task> tasks = AllTasks(Make(options));
  ASSERT_EQ(tasks.size(), kNumViews + 4u);
  const auto& inputs = tasks[kNumViews].inputs;
  EXPECT_THAT(inputs.back().string(), HasSubstr(".photometric"));
}

std::vector<Task> FusionTasks(int num_views) {
  ReconstructionOptions options;
  options.view_selection.max_num_neighbors = 2;
  const ReconstructionPtr reconstruction =
      MakeReconstruction(MakeScene(ShapeName::kSphere, num_views, 64, 48).scene,
                         std::make_shared<NamedFiles>(), options, RunContext(1));
  return MakeFusionTasks(reconstruction, DepthMapKind::kGeometric, MapsToFuse::kAll,
                         "/w/fused.ply");
}

TEST(FusionTasks, OfFewViewsAreOne) {
  const std::vector<Task> tasks = FusionTasks(10);
  ASSERT_EQ(tasks.size(), 1u);
  EXPECT_EQ(tasks[0].name, kFusionStage);
  EXPECT_TRUE(tasks[0].wanted);
}

TEST(FusionTasks, OfManyViewsArePartsAndWhatJoinsThem) {
  const int num_views = 40;
  const std::vector<Task> tasks = FusionTasks(num_views);
  ASSERT_EQ(tasks.size(), 5u);
  const Task& join = tasks.back();
  EXPECT_EQ(join.name, kFusionStage);
  EXPECT_TRUE(join.wanted);
  EXPECT_EQ(join.foreign_outputs, ForeignOutputs::kUse);
  std::set<std::string> names;
  double bytes = 0;
  for (size_t i = 0; i + 1 < tasks.size(); ++i) {
    const Task& part = tasks[i];
    EXPECT_TRUE(names.insert(part.name).second);
    EXPECT_EQ(part.stage, kFusionStage);
    EXPECT_TRUE(part.temporary);
    EXPECT_FALSE(part.wanted);
    for (const fs::path& output : part.outputs) {
      EXPECT_THAT(join.inputs, testing::Contains(output));
    }
    // Not those of all views.
    const auto num_maps = std::count_if(
        part.inputs.begin(), part.inputs.end(),
        [](const fs::path& input) { return input.string().starts_with("/w/depth/"); });
    EXPECT_GE(num_maps, 10);
    EXPECT_LT(num_maps, num_views);
    bytes += static_cast<double>(part.output_bytes);
  }
  EXPECT_NEAR(bytes, static_cast<double>(join.output_bytes), 10);
  EXPECT_FALSE(join.temporary);
}

TEST(ReconstructionTasks, QuasiDenseMatchingTakesThePlaceOfDepthMapsAndFusion) {
  const std::vector<Task> tasks = AllTasks(Make(QuasiDense()));
  ASSERT_EQ(tasks.size(), 4u);
  EXPECT_EQ(tasks[0].stage, kQuasiDenseStage);
  EXPECT_EQ(tasks[1].stage, kSurfaceStage);
  EXPECT_THAT(tasks[0].outputs,
              testing::ElementsAre(fs::path("/w/fused.ply"), fs::path("/w/fused.ply.vis")));
  EXPECT_THAT(tasks[0].inputs, testing::Contains(fs::path("/w/database")));
  EXPECT_EQ(tasks[0].inputs.size(), 2u + kNumViews + 1u);
  EXPECT_THAT(tasks[0].options, HasSubstr("QuasiDenseMatching.min_ncc"));
  EXPECT_GT(tasks[0].cost.peak_bytes, 0u);
}

TEST(ReconstructionTasks, TexturingTakesTheRefinedMeshAndThePhotos) {
  const Task task = AllTasks(Make()).back();
  EXPECT_EQ(task.stage, kTexturingStage);
  EXPECT_THAT(task.outputs, testing::ElementsAre(fs::path("/w/textured/mesh.ply"),
                                                 fs::path("/w/textured/texture.png")));
  EXPECT_EQ(task.inputs.size(), 2u + kNumViews + 1u);
  EXPECT_THAT(task.options, HasSubstr("MeshTextureMapping.seam_cost"));
  EXPECT_GT(task.cost.peak_bytes, 0u);
  EXPECT_GT(task.output_bytes, 0u);
  ReconstructionOptions options;
  options.texturing.unseen_color = "none";
  EXPECT_THROW(Make(options), UsageError);
}

TEST(ReconstructionTasks, TheBoxIsOnRecordWherePointsAreMade) {
  ReconstructionOptions boxed = QuasiDense();
  boxed.bounding_box = ParseBox("b", "0,0,0,1,2,3");
  EXPECT_THAT(AllTasks(Make(boxed))[0].options, HasSubstr("bounding_box=0 0 0 1 2 3"));
  boxed.point_source = PointSource::kPatchMatch;
  EXPECT_THAT(AllTasks(Make(boxed))[2 * kNumViews].options, HasSubstr("bounding_box=0 0 0 1 2 3"));
}

TEST(ReconstructionTasks, StagesOfTheOtherSourceAreRefused) {
  using enum ReconstructionStage;
  EXPECT_THROW(MakeReconstructionTasks(Make(QuasiDense()), kStereo, kRefinement), UsageError);
  EXPECT_THROW(MakeReconstructionTasks(Make(QuasiDense()), kQuasiDense, kFusion), UsageError);
  EXPECT_THROW(MakeReconstructionTasks(Make(), kQuasiDense, kRefinement), UsageError);
  EXPECT_THROW(MakeReconstructionTasks(Make(), kSurface, kStereo), UsageError);
  EXPECT_EQ(MakeReconstructionTasks(Make(QuasiDense()), kSurface, kRefinement).size(), 2u);
}

TEST(ReconstructionTasks, OptionsThatChangeResultsAreOnRecordAndOthersAreNot) {
  const std::vector<std::string> base = Options(AllTasks(Make()));
  EXPECT_EQ(Options(AllTasks(Make({}, size_t{1} << 33))), base);
  ReconstructionOptions options;
  options.seed = 5;
  EXPECT_NE(Options(AllTasks(Make(options))), base);
  options = {};
  options.surface.cleaning.smoothing_iterations += 1;
  const std::vector<std::string> changed = Options(AllTasks(Make(options)));
  for (size_t i = 0; i < base.size(); ++i) {
    EXPECT_EQ(base[i] != changed[i], base[i].starts_with(kSurfaceStage)) << base[i];
  }
}

TEST(ReconstructionTasks, WithoutSparsePointsTheFirstStageSaysWhatIsMissing) {
  Scene scene = MakeScene(ShapeName::kSphere, kNumViews, 64, 48).scene;
  scene.points.clear();
  const RunContext context(1);
  const std::vector<fs::path> outputs = {"/nowhere/a", "/nowhere/b"};
  for (const ReconstructionOptions& options : {ReconstructionOptions(), QuasiDense()}) {
    const std::vector<Task> tasks =
        AllTasks(MakeReconstruction(scene, std::make_shared<NamedFiles>(), options, context));
    try {
      tasks.front().run({context, outputs});
      FAIL();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("/w/points3D"));
      EXPECT_THAT(error.what(), HasSubstr("depth_min"));
    }
  }
}

TEST(ReconstructionOptions, DefaultsAreValidAndBadOnesAreRefused) {
  ReconstructionOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.fusion.min_num_pixels = 0;
  EXPECT_THROW(Make(options), UsageError);
}

TEST(Quality, SetsSizesAndIterations) {
  ReconstructionOptions low, high;
  ApplyQuality(Quality::kLow, &low);
  ApplyQuality(Quality::kHigh, &high);
  EXPECT_EQ(low.max_image_size, 1000);
  EXPECT_EQ(low.point_source, PointSource::kQuasiDense);
  EXPECT_EQ(high.point_source, PointSource::kPatchMatch);
  EXPECT_EQ(high.max_image_size, 2400);
  EXPECT_LT(low.patch_match.num_iterations, high.patch_match.num_iterations);
  EXPECT_LT(low.refinement.max_num_iterations, high.refinement.max_num_iterations);
  EXPECT_EQ(high.patch_match.num_iterations, PatchMatchOptions().num_iterations);
  ReconstructionOptions extreme;
  ApplyQuality(Quality::kExtreme, &extreme);
  EXPECT_EQ(extreme.max_image_size, 0);
}

TEST(Box, ParsesSixNumbers) {
  const Eigen::AlignedBox3d box = ParseBox("b", "-1,0 0,1, 2,3.5");
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, 0, 0));
  EXPECT_EQ(box.max(), Eigen::Vector3d(1, 2, 3.5));
  EXPECT_TRUE(ParseBox("b", "").isEmpty());
  for (const char* bad :
       {"1", "1,2,3,4,5", "0,0,0,1,1,1,1", "1,0,0,0,1,1", "a,b,c,d,e,f", "0,0,0,1,1,nan"}) {
    EXPECT_THROW(ParseBox("b", bad), UsageError) << bad;
  }
}

// The sphere with views in one file, and read again for views 1 and 3; view 3 sees too few points.
class JobScene : public testing::Test {
 protected:
  JobScene() {
    Scene scene = MakeScene(ShapeName::kSphere, kNumViews, 64, 48).scene;
    scene.world_offset = {1000, 2000, 0};
    size_t seen_by_three = 0;
    for (SparsePoint& point : scene.points) {
      const bool sees = std::count(point.view_idxs.begin(), point.view_idxs.end(), 3) > 0;
      if (sees && ++seen_by_three > kMinPointsOfView / 2) std::erase(point.view_idxs, 3);
    }
    whole_ = MakeReconstruction(scene, files_, {}, RunContext(1));
    WriteJobScene(Path(), *whole_);
  }
  fs::path Path() const { return folder_.path() / "scene"; }
  ReconstructionPtr Read() const {
    const auto& views = whole_->scene.views;
    return ReadJobScene(Path(), {views[1].name, views[3].name}, files_, {}, RunContext(1));
  }

  TemporaryFolder folder_;
  std::shared_ptr<const WorkspaceFiles> files_ = std::make_shared<NamedFiles>();
  ReconstructionPtr whole_;
};

TEST_F(JobScene, GivesTheTasksOfTheWholeScene) {
  const ReconstructionPtr part = Read();
  const std::vector<Task> tasks = AllTasks(part), expected = AllTasks(whole_);
  ASSERT_EQ(tasks.size(), expected.size());
  const FileTable table(folder_.path());
  for (size_t i = 0; i < tasks.size(); ++i) {
    EXPECT_EQ(tasks[i].name, expected[i].name);
    EXPECT_EQ(IdentityOf(tasks[i], table), IdentityOf(expected[i], table)) << tasks[i].name;
  }
  EXPECT_EQ(part->scene.world_offset, whole_->scene.world_offset);
  for (size_t v = 0; v < whole_->scene.views.size(); ++v) {
    const View &a = part->scene.views[v], &b = whole_->scene.views[v];
    EXPECT_EQ(a.cam_from_world.rotation, b.cam_from_world.rotation);
    EXPECT_EQ(a.cam_from_world.translation, b.cam_from_world.translation);
    EXPECT_EQ(part->depth_ranges[v].min, whole_->depth_ranges[v].min);
    EXPECT_EQ(part->depth_ranges[v].max, whole_->depth_ranges[v].max);
  }
}

// Points that the view sees, in the scene's order.
std::vector<Eigen::Vector3d> PointsOf(const Scene& scene, int view_idx) {
  std::vector<Eigen::Vector3d> points;
  for (const SparsePoint& point : scene.points) {
    const auto& views = point.view_idxs;
    if (std::find(views.begin(), views.end(), view_idx) != views.end()) {
      points.push_back(point.x_in_world);
    }
  }
  return points;
}

TEST_F(JobScene, HasThePointsThatItsViewsStartFrom) {
  const ReconstructionPtr part = Read();
  EXPECT_EQ(PointsOf(part->scene, 1), PointsOf(whole_->scene, 1));
  EXPECT_TRUE(PointsOf(part->scene, 0).empty());
  EXPECT_TRUE(PointsOf(part->scene, 3).empty()) << "too few: those in its image count";
  ASSERT_LT(PointsOf(whole_->scene, 3).size(), kMinPointsOfView);
  const std::vector<uint32_t> in_image = PointsInImage(whole_->scene, 3);
  const std::vector<uint32_t> in_part = PointsInImage(part->scene, 3);
  ASSERT_EQ(in_part.size(), in_image.size());
  for (size_t i = 0; i < in_image.size(); ++i) {
    EXPECT_EQ(part->scene.points[in_part[i]].x_in_world,
              whole_->scene.points[in_image[i]].x_in_world);
  }
}

TEST_F(JobScene, HasNoPointsThatOnlyOthersSee) {
  const ReconstructionPtr part =
      ReadJobScene(Path(), {whole_->scene.views[1].name}, files_, {}, RunContext(1));
  EXPECT_EQ(part->scene.points.size(), PointsOf(whole_->scene, 1).size());
  EXPECT_LT(part->scene.points.size(), whole_->scene.points.size());
}

TEST_F(JobScene, ThatIsNotWholeIsRefused) {
  std::ifstream file(Path(), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (size_t size = 0; size < bytes.size(); size += 997) {
    std::ofstream(Path(), std::ios::binary) << bytes.substr(0, size);
    EXPECT_THROW(Read(), InputError) << size;
  }
}

TEST_F(JobScene, IsForTasksOfDepthMapsOnly) {
  const std::set<std::string> both = {"a/b.jpg", "c.jpg"};
  EXPECT_EQ(ViewsOfStereoTasks(
                {"patch_match_stereo/geometric/a/b.jpg", "patch_match_stereo/photometric/c.jpg"}),
            both);
  EXPECT_TRUE(ViewsOfStereoTasks({"patch_match_stereo/geometric/a.jpg", "stereo_fusion"}).empty());
  EXPECT_TRUE(ViewsOfStereoTasks({}).empty());
}

}  // namespace
}  // namespace lsmvs
