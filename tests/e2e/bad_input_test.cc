#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "program_runner.h"
#include "small_workspace.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

// Runs on a workspace that was spoilt; expects the code and the texts, and that no result was
// written.
void ExpectRefused(const SmallWorkspace& workspace, int exit_code,
                   const std::vector<std::string>& texts,
                   const std::vector<std::string>& more_arguments = {}) {
  std::vector<std::string> arguments = {workspace.text()};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  ExpectError(RunProgram("lsmvs-mesher", arguments), exit_code, texts);
  EXPECT_TRUE(FindLeftovers(workspace.path()).empty());
  for (const char* result : {"fused.ply", "meshed-visibility.ply", "meshed-refined.ply"}) {
    EXPECT_FALSE(fs::exists(workspace / result)) << result;
  }
}

fs::path FirstImage(const SmallWorkspace& workspace) {
  fs::path first;
  for (const auto& entry : fs::directory_iterator(workspace / "images")) {
    if (first.empty() || entry.path() < first) first = entry.path();
  }
  return first;
}

fs::path Sparse(const SmallWorkspace& workspace, const std::string& name) {
  return (workspace / "sparse") / name;
}

template <class T>
std::string BytesOf(const T& value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

// Reads the model, changes it and writes it back.
template <class Change>
void ChangeModel(const SmallWorkspace& workspace, const Change& change) {
  SparseModel model = ReadSparseModel(workspace / "sparse");
  change(&model);
  WriteSparseModel(workspace / "sparse", model);
}

TEST(BadInput, MissingFolders) {
  ExpectError(RunProgram("lsmvs-mesher", {"/nowhere/at/all"}), 3,
              {"/nowhere/at/all", "does not exist"});
  SmallWorkspace without_images, without_sparse, empty_images;
  fs::remove_all(without_images / "images");
  ExpectRefused(without_images, 3, {"images"});
  fs::remove_all(without_sparse / "sparse");
  ExpectRefused(without_sparse, 3, {without_sparse.text()});
  fs::remove_all(empty_images / "images");
  fs::create_directory(empty_images / "images");
  ExpectRefused(empty_images, 3, {"images: holds none of the model's 5 photos", "0000.png"});
  SmallWorkspace empty_sparse, half_sparse;
  fs::remove_all(empty_sparse / "sparse");
  fs::create_directory(empty_sparse / "sparse");
  ExpectRefused(empty_sparse, 3, {"sparse: holds no sparse model", "colmap mapper"});
  fs::remove(half_sparse / "sparse/points3D.bin");
  ExpectRefused(half_sparse, 3, {"sparse: holds no whole sparse model: points3D.bin is missing"});
}

TEST(BadInput, PathsThatAreNoWorkspace) {
  const SmallWorkspace workspace;
  fs::create_directory(workspace / "nothing");
  ExpectError(RunProgram("lsmvs-mesher", {(workspace / "nothing").string()}), 3,
              {"nothing: is neither"});
  ExpectError(RunProgram("lsmvs-mesher", {FirstImage(workspace).string()}), 3,
              {"0000.png: is not a folder"});
  ExpectError(RunProgram("lsmvs-mesher", {(workspace / "sparse").string()}), 3,
              {"is a sparse model, not a workspace"});
}

TEST(BadInput, CommandsNameWhatIsMissing) {
  const SmallWorkspace workspace;
  fs::remove_all(workspace / "sparse");
  for (const char* command : {"patch_match_stereo", "stereo_fusion", "mesh_refiner"}) {
    std::vector<std::string> arguments = {command, "--workspace_path", workspace.text()};
    if (std::string(command) != "patch_match_stereo") {
      arguments.insert(arguments.end(), {"--output_path", (workspace / "o.ply").string()});
    }
    if (std::string(command) == "mesh_refiner") {
      arguments.insert(arguments.end(), {"--input_path", (workspace / "i.ply").string()});
    }
    ExpectError(RunProgram("lsmvs", arguments), 3, {"sparse"});
  }
}

TEST(BadInput, MeshThatIsNone) {
  const SmallWorkspace workspace;
  const std::string input = (workspace / "i.ply").string();
  const std::vector<std::string> arguments = {"mesh_refiner",
                                              "--workspace_path",
                                              workspace.text(),
                                              "--input_path",
                                              input,
                                              "--output_path",
                                              (workspace / "o.ply").string()};
  ExpectError(RunProgram("lsmvs", arguments), 3, {"i.ply"});
  WriteText(input, "ply\nformat ascii 1.0\nelement vertex 1\n");
  ExpectError(RunProgram("lsmvs", arguments), 3, {"i.ply"});
  EXPECT_FALSE(fs::exists(workspace / "o.ply"));
}

TEST(BadInput, ImageMissingCorruptOrOfAnotherSize) {
  const SmallWorkspace missing, corrupt, truncated, text;
  const std::string name = FirstImage(missing).filename().string();
  fs::remove(FirstImage(missing));
  ExpectRefused(missing, 3, {name});
  WriteText(FirstImage(text), "this is not an image");
  ExpectRefused(text, 3, {name});
  const std::string good = ReadText(FirstImage(truncated));
  WriteText(FirstImage(truncated), good.substr(0, good.size() / 2));
  ExpectRefused(truncated, 3, {name});
  OverwriteBytes(FirstImage(corrupt), good.size() / 2, std::string(200, 'x'));
  ExpectRefused(corrupt, 3, {name});
  const SmallWorkspace other_size;
  ChangeModel(other_size, [](SparseModel* model) { model->cameras[0].width += 2; });
  ExpectRefused(other_size, 3, {name, "128"});
}

TEST(BadInput, ModelTruncatedOrInconsistent) {
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const SmallWorkspace workspace;
    const std::string good = ReadText(Sparse(workspace, name));
    for (const size_t length : {size_t{0}, size_t{4}, size_t{8}, size_t{20}, good.size() - 5}) {
      WriteText(Sparse(workspace, name), good.substr(0, length));
      ExpectRefused(workspace, 3, {name});
    }
    WriteText(Sparse(workspace, name), BytesOf(uint64_t{1} << 60) + good.substr(8));
    ExpectRefused(workspace, 3, {name});
    WriteText(Sparse(workspace, name), good + "surplus");
    ExpectRefused(workspace, 3, {name});
  }
}

TEST(BadInput, PosesThatAreNotNumbers) {
  const SmallWorkspace workspace;
  constexpr size_t kRotation = 12;  // after the number of images and the first image's id
  OverwriteBytes(Sparse(workspace, "images.bin"), kRotation,
                 BytesOf(std::numeric_limits<double>::quiet_NaN()));
  ExpectRefused(workspace, 3, {"sparse", "0000.png", "not finite"});
  OverwriteBytes(Sparse(workspace, "images.bin"), kRotation, std::string(32, '\0'));
  ExpectRefused(workspace, 3, {"sparse", "0000.png", "rotation of length 0"});
}

TEST(BadInput, UnknownAndDistortedCameras) {
  const SmallWorkspace unknown, distorted;
  constexpr size_t kModelId = 12;  // after the number of cameras and the first camera's id
  OverwriteBytes(Sparse(unknown, "cameras.bin"), kModelId, BytesOf(int32_t{99}));
  ExpectRefused(unknown, 3, {"cameras.bin", "99"});
  ChangeModel(distorted, [](SparseModel* model) {
    model->cameras[0].model_id = 4;
    model->cameras[0].params.resize(8, 0.01);
  });
  ExpectRefused(distorted, 3, {"OPENCV", "image_undistorter"});
}

TEST(BadInput, NoRegisteredImage) {
  const SmallWorkspace workspace;
  ChangeModel(workspace, [](SparseModel* model) {
    model->images.clear();
    model->points3d.clear();
    model->frames.clear();
  });
  ExpectRefused(workspace, 3, {"no registered image"});
}

TEST(BadInput, NoSparsePoints) {
  const SmallWorkspace workspace;
  ChangeModel(workspace, [](SparseModel* model) {
    model->points3d.clear();
    for (auto& image : model->images) {
      for (auto& point : image.points2d) point.point3d_id = SparseModel::kNoPoint3d;
    }
  });
  ExpectRefused(workspace, 3, {"points3D", "--PatchMatchStereo.depth_min"});
  ExpectRefused(workspace, 3, {"points3D", "--QuasiDenseMatching.depth_min"}, {"--quality", "low"});
}

TEST(BadInput, TooLittleMemory) {
  const SmallWorkspace workspace;
  for (const char* quality : {"low", "high"}) {
    ExpectRefused(workspace, 5, {"--max_memory is 20MB", "allow"},
                  {"--max_memory", "20MB", "--quality", quality});
  }
}

// Enough to begin with and too little for the work: refused before it begins.
TEST(BadInput, TooLittleMemoryForAStage) {
  SKIP_WITH_SANITIZERS;
  const SmallWorkspace workspace;
  // Surfaces are made in parts, but one part must fit.
  constexpr size_t kNumPoints = 4'000'000, kBytesPerPoint = 12;
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                             std::to_string(kNumPoints) +
                             "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  WriteText(workspace / "fused.ply", header);
  fs::resize_file(workspace / "fused.ply", header.size() + kNumPoints * kBytesPerPoint);
  WriteText(workspace / "fused.ply.vis", "");
  ExpectError(RunProgram("lsmvs-mesher", {workspace.text(), "--max_memory", "110MB"}), 5,
              {workspace.text(), "visibility_mesher needs about", "--max_memory"});
  EXPECT_FALSE(fs::exists(workspace / "meshed-visibility.ply"));
}

TEST(BadInput, NothingLeftByMasksOrBox) {
  const SmallWorkspace workspace;
  const std::string black = "P5\n128 96\n255\n" + std::string(128 * 96, '\0');
  for (const auto& entry : fs::directory_iterator(workspace / "images")) {
    WriteText(workspace / ("masks/" + entry.path().filename().string() + ".png"), black);
  }
  for (const char* source : {"patch_match", "quasi_dense"}) {
    ExpectRefused(workspace, 3, {"fused.ply: would be empty", "--mask_path"},
                  {"--mask_path", (workspace / "masks").string(), "--point_source", source});
    ExpectRefused(workspace, 3, {"fused.ply: would be empty", "--bounding_box"},
                  {"--bounding_box", "1000,1000,1000,1001,1001,1001", "--point_source", source});
  }
}

TEST(BadInput, MasksThatAreNotThere) {
  const SmallWorkspace workspace;
  ExpectRefused(workspace, 3, {"/no/masks"}, {"--mask_path", "/no/masks"});
  fs::create_directory(workspace / "empty");
  const ProgramResult result =
      RunProgram("lsmvs-mesher", {workspace.text(), "--mask_path", (workspace / "empty").string(),
                                  "--quality", "low", "--to", "quasi_dense_matcher"});
  ExpectSuccess(result);
  EXPECT_THAT(result.err, testing::HasSubstr("0000.png is to be named 0000.png.png"));
}

TEST(BadInput, MasksThatAreNone) {
  const SmallWorkspace workspace;
  const std::string masks = (workspace / "masks").string();
  const fs::path mask = workspace / "masks/0000.png.png";
  WriteText(mask, "P5\n64 48\n255\n" + std::string(64 * 48, '\0'));
  ExpectRefused(workspace, 3, {"0000.png.png", "64 x 48", "mask"}, {"--mask_path", masks});
  WriteText(mask, "not an image");
  ExpectRefused(workspace, 3, {"0000.png.png", "cannot be decoded"}, {"--mask_path", masks});
}

TEST(BadInput, DatabaseThatIsNone) {
  const SmallWorkspace workspace;
  const std::string database = (workspace / "d.db").string();
  const std::vector<std::string> arguments = {"--quality", "low", "--database_path", database};
  ExpectRefused(workspace, 3, {"d.db: is missing"}, arguments);
  WriteText(database, "not a database");
  ExpectRefused(workspace, 3, {"d.db", "database"}, arguments);
}

TEST(BadInput, OutputsThatAreFolders) {
  const SmallWorkspace workspace;
  const fs::path folder = workspace / "out";
  fs::create_directory(folder);
  for (const char* overwrite : {"0", "1"}) {
    ExpectError(RunProgram("lsmvs", {"visibility_mesher", "--input_type", "sparse", "--input_path",
                                     workspace.text(), "--output_path", folder.string(),
                                     "--overwrite", overwrite}),
                3, {"out: is a folder", "name a file"});
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(BadInput, SourcesThatAreNoPhotos) {
  const SmallWorkspace workspace;
  WriteText(workspace / "stereo/patch-match.cfg", "0000.png\n0001.png, 0009.png\n");
  ExpectRefused(workspace, 3, {"patch-match.cfg", "line 2", "'0009.png'"});
}

TEST(BadInput, PhotosWithoutContrast) {
  const SmallWorkspace workspace;
  for (const auto& entry : fs::directory_iterator(workspace / "images")) {
    WriteText(entry.path(), "P5\n128 96\n255\n" + std::string(128 * 96, '\x10'));
  }
  ExpectRefused(workspace, 3, {"5 of 5 photos have no contrast", "0000.png (16 to 16 of 255)"});
}

TEST(BadInput, RunRecordThatIsNone) {
  const SmallWorkspace workspace;
  WriteText(workspace / "lsmvs/run.json", "{ not json");
  ExpectRefused(workspace, 3, {"run.json", "delete it"});
}

TEST(BadInput, DepthMapsThatAreCutOff) {
  const SmallWorkspace workspace;
  ExpectSuccess(RunProgram("lsmvs-mesher", {workspace.text(), "--to", "patch_match_stereo"}));
  const std::string name = FirstImage(workspace).filename().string() + ".geometric.bin";
  const fs::path map = (workspace / "stereo/depth_maps") / name;
  const std::string good = ReadText(map);
  WriteText(map, good.substr(0, good.size() - 7));
  ExpectRefused(workspace, 3, {name}, {"--from", "stereo_fusion"});
}

}  // namespace
}  // namespace lsmvs
