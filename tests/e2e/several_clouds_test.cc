// Clouds of several workspaces in one frame, meshed as one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/synthetic/shuffled_cloud.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "program_runner.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

std::string ReadBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Flight {
  Scene views;
  VisibilityCloud cloud;
};

// Every second view, from `first` on, with what it sees of the cloud.
Flight TakeFlight(const Scene& views, const VisibilityCloud& cloud, uint32_t first) {
  Flight flight;
  for (uint32_t v = first; v < views.views.size(); v += 2) {
    flight.views.views.push_back(views.views[v]);
  }
  for (size_t p = 0; p < cloud.size(); ++p) {
    std::vector<uint32_t> own;
    for (const uint32_t v : cloud.ViewsOf(p)) {
      if (v % 2 == first) own.push_back(v / 2);
    }
    if (own.empty()) continue;
    flight.cloud.Add(cloud.positions[p], cloud.normals[p], cloud.colors[p], own);
  }
  return flight;
}

Flight Concatenate(const Flight& a, const Flight& b) {
  Flight both = a;
  const auto num_a = static_cast<uint32_t>(a.views.views.size());
  for (View view : b.views.views) {
    view.name = "other/" + view.name;
    view.image_id = ImageId{static_cast<uint32_t>(view.image_id) + 100000};
    both.views.views.push_back(view);
  }
  VisibilityCloud moved = b.cloud;
  for (uint32_t& view_idx : moved.view_idxs) view_idx += num_a;
  both.cloud.Append(moved);
  return both;
}

void WriteFlight(const fs::path& folder, const Flight& flight, const Eigen::Vector3d& shift) {
  Scene moved = flight.views;
  for (View& view : moved.views) {
    view.cam_from_world.translation -= view.cam_from_world.rotation * shift;
  }
  VisibilityCloud cloud = flight.cloud;
  for (Eigen::Vector3f& x : cloud.positions) x += shift.cast<float>();
  fs::create_directories(folder / "sparse");
  WriteSparseModel(folder / "sparse", MakeSparseModel(moved));
  WriteFusedCloud(folder / "fused.ply", cloud, moved);
}

// The cloud in another order as fused.ply, and the same points split at random into two more clouds
// of the workspace.
void WriteShuffledAndSplit(const fs::path& folder, const Flight& flight) {
  WriteFlight(folder, flight, Eigen::Vector3d::Zero());
  const VisibilityCloud cloud = Shuffle(flight.cloud, 1).cloud;
  WriteFusedCloud(folder / "shuffled.ply", cloud, flight.views);
  VisibilityCloud halves[2];
  std::mt19937_64 random(2);
  for (size_t p = 0; p < cloud.size(); ++p) {
    halves[random() % 2].Add(cloud.positions[p], cloud.normals[p], cloud.colors[p],
                             cloud.ViewsOf(p));
  }
  WriteFusedCloud(folder / "one.ply", halves[0], flight.views);
  WriteFusedCloud(folder / "two.ply", halves[1], flight.views);
}

// A town that two flights have seen, and both as one, in either order.
class SeveralClouds : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    TownOptions options;
    options.num_points = 2e5;
    const Town town(options);
    const Scene views = town.MakeViews();
    VisibilityCloud cloud;
    SampleTown(town, views, RunContext(2), [&](const auto& part) { cloud.Append(part); });
    const Flight a = TakeFlight(views, cloud, 0), b = TakeFlight(views, cloud, 1);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    WriteFlight(Path("a"), a, none);
    WriteFlight(Path("b"), b, none);
    WriteFlight(Path("ab"), Concatenate(a, b), none);
    WriteFlight(Path("ba"), Concatenate(b, a), none);
    WriteFlight(Path("far"), b, {5000, 0, 0});
    WriteShuffledAndSplit(Path("split"), a);
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Path(const std::string& name) { return folder_->path() / name; }

  static ProgramResult Mesh(const std::vector<std::string>& inputs, const std::string& output,
                            const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"visibility_mesher", "--output_path",
                                          Path(output).string()};
    for (const std::string& input : inputs) {
      arguments.insert(arguments.end(), {"--input_path", Path(input).string()});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram("lsmvs", arguments);
  }

  static bool SameMesh(const std::string& a, const std::string& b) {
    return ReadBytes(Path(a)) == ReadBytes(Path(b)) &&
           ReadBytes(Path(a + ".vis")) == ReadBytes(Path(b + ".vis"));
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* SeveralClouds::folder_ = nullptr;

TEST_F(SeveralClouds, AreMeshedAsTheConcatenatedCloudInAnyOrder) {
  const ProgramResult result = Mesh({"a", "b"}, "1/mesh.ply");
  ExpectSuccess(result);
  EXPECT_THAT(result.out, HasSubstr("views 0 to "));
  EXPECT_THAT(result.err, Not(HasSubstr("do not overlap")));
  ExpectSuccess(Mesh({"b", "a/fused.ply"}, "2/mesh.ply", {"--num_threads", "1"}));
  EXPECT_TRUE(SameMesh("1/mesh.ply", "2/mesh.ply"));
  ExpectSuccess(Mesh({"ab"}, "ab/mesh.ply"));
  ExpectSuccess(Mesh({"ba"}, "ba/mesh.ply"));
  EXPECT_TRUE(SameMesh("1/mesh.ply", "ab/mesh.ply") || SameMesh("1/mesh.ply", "ba/mesh.ply"));
  EXPECT_GT(ReadMeshPly(Path("1/mesh.ply")).faces.size(), 10000u);
  // The second run finds the first one's record, whatever the order.
  EXPECT_THAT(Mesh({"b", "a"}, "1/mesh.ply").out, HasSubstr("up to date"));
}

TEST_F(SeveralClouds, OrderOfThePointsAndOfTheirFilesDoesNotMatter) {
  ExpectSuccess(Mesh({"split"}, "order/whole.ply"));
  ExpectSuccess(Mesh({"split/shuffled.ply"}, "order/1.ply", {"--num_parts", "2"}));
  ExpectSuccess(Mesh({"split/one.ply", "split/two.ply"}, "order/2.ply"));
  ExpectSuccess(Mesh({"split/two.ply", "split/one.ply"}, "order/3.ply", {"--num_parts", "7"}));
  for (const std::string other : {"1", "2", "3"}) {
    EXPECT_TRUE(SameMesh("order/whole.ply", "order/" + other + ".ply")) << other;
  }
  // Photos of one model are the same photos.
  EXPECT_THAT(Mesh({"split/two.ply", "split/one.ply", "b"}, "order/4.ply").out,
              testing::ContainsRegex("views [0-9]+ to [0-9]+.*\nviews [0-9]+ to"));
}

TEST_F(SeveralClouds, PartsGiveTheSameBytes) {
  ExpectSuccess(Mesh({"a", "b"}, "parts/whole.ply"));
  ExpectSuccess(Mesh({"a", "b"}, "parts/parts.ply", {"--num_parts", "4"}));
  EXPECT_TRUE(SameMesh("parts/whole.ply", "parts/parts.ply"));
}

TEST_F(SeveralClouds, SparseModelsAreJoined) {
  ExpectError(Mesh({"a", "b"}, "sparse.ply", {"--input_type", "sparse"}), 3, {"no surface"});
}

TEST_F(SeveralClouds, InDifferentFramesGiveAWarningWithFigures) {
  const ProgramResult result = Mesh({"a", "far"}, "far.ply");
  ExpectSuccess(result);
  EXPECT_THAT(result.err, testing::AllOf(HasSubstr("do not overlap"), HasSubstr("0.0 %"),
                                         HasSubstr(Path("far/fused.ply").string()),
                                         HasSubstr("model_aligner")));
}

TEST_F(SeveralClouds, BadOnesAreRefused) {
  ExpectError(Mesh({"a", "no"}, "x.ply"), 3, {Path("no").string(), "does not exist"});
  ExpectError(Mesh({"a", "a"}, "x.ply"), 2, {"twice", Path("a").string()});
  ExpectError(Mesh({"a", "a/fused.ply"}, "x.ply"), 2, {"twice", Path("a/fused.ply").string()});
  fs::create_directories(Path("bare"));
  ExpectError(Mesh({"a", "bare"}, "x.ply"), 3, {Path("bare").string(), "sparse model"});
  fs::copy(Path("a"), Path("novis"), fs::copy_options::recursive);
  fs::remove(Path("novis/fused.ply.vis"));
  ExpectError(Mesh({"b", "novis"}, "x.ply"), 3, {Path("novis/fused.ply.vis").string(), "missing"});
  ExpectError(Mesh({"a", "b"}, "x.ply", {"--filtered_cloud_path", Path("c.ply").string()}), 2,
              {"--filtered_cloud_path"});
  EXPECT_FALSE(fs::exists(Path("x.ply")));
}

}  // namespace
}  // namespace lsmvs
