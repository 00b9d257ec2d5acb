// mesh_evaluator, mesh_renderer and mesh_comparer on a small rendered workspace.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "lsmvs/cli/command_table.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/program/run_program.h"
#include "lsmvs/report/report.h"
#include "lsmvs/synthetic/texture.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/synthetic/workspace.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
  int code;
  std::string output, errors;
};

Outcome RunProgram(const std::vector<std::string>& arguments) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.code = RunCommandTable(CommandTable(), arguments);
  std::fflush(stdout);
  outcome.output = testing::internal::GetCapturedStdout();
  outcome.errors = testing::internal::GetCapturedStderr();
  return outcome;
}

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// A dense workspace with a true mesh and a mesh that is 1 % too large.
class EvaluationCommands : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    SyntheticScene scene = MakeScene(ShapeName::kSphere, 6, 160, 120);
    WriteWorkspace(Workspace(), WorkspaceFormat::kDense, &scene, RunContext(2));
    TriangleMesh mesh = ReadMeshPly(Truth());
    for (Eigen::Vector3d& x : mesh.vertices) x *= 1.01;
    WriteMeshPly(Mesh(), mesh);
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path Workspace() { return folder_->path() / "ws"; }
  static fs::path Truth() { return Workspace() / "gt_mesh.ply"; }
  static fs::path Mesh() { return Workspace() / "meshed-refined.ply"; }
  // The true mesh with the texture of the scene, as an even light shows it.
  static fs::path Textured() {
    const fs::path path = Workspace() / "textured" / "mesh.ply";
    if (fs::exists(path)) return path;
    fs::create_directories(path.parent_path());
    const SyntheticScene scene = MakeScene(ShapeName::kSphere, 6, 160, 120);
    const SolidTexture texture(scene.photo.texture);
    AtlasOptions options;
    options.page_width = options.page_height = 2048;
    options.chart_px = 5;
    options.gutter_px = 2;
    const auto color = [&](const Eigen::Vector3d& x) -> Color {
      return (255 * texture.Albedo(x, scene.gsd)).cast<uint8_t>();
    };
    WriteTexturedPly(path, PaintAtlas(ReadMeshPly(Truth()), color, path.parent_path(), options));
    return path;
  }

  static TemporaryFolder* folder_;
};

TemporaryFolder* EvaluationCommands::folder_ = nullptr;

TEST_F(EvaluationCommands, EvaluatorScoresTheTruthAsPerfect) {
  const Outcome outcome =
      RunProgram({"mesh_evaluator", "--input_path", Truth(), "--ground_truth_path", Truth(),
                  "--workspace_path", Workspace(), "--json_path", "-", "--num_samples", "5000"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const nlohmann::json json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["surface"]["f1"][0], 1);
  EXPECT_GT(json["surface"]["gsd"], 0);
  EXPECT_EQ(json["depth_errors"]["views"].size(), 6u);
  EXPECT_FALSE(json.contains("photometric"));
}

TEST_F(EvaluationCommands, EvaluatorWorksWithoutWorkspace) {
  const fs::path errors = folder_->path() / "errors.ply", json_path = folder_->path() / "e.json";
  const Outcome outcome = RunProgram(
      {"mesh_evaluator", "--input_path", Mesh(), "--ground_truth_path", Truth(), "--unit", "world",
       "--thresholds", "0.001,1", "--json_path", json_path, "--error_path", errors});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_THAT(outcome.output, HasSubstr("completeness"));
  EXPECT_EQ(nlohmann::json::parse(Content(json_path))["surface"]["f1"][1], 1);
  EXPECT_EQ(ReadMeshPly(errors).vertex_colors.size(), ReadMeshPly(errors).vertices.size());
}

TEST_F(EvaluationCommands, EvaluatorScoresByThePhotos) {
  const auto score = [&](const fs::path& mesh) {
    const Outcome outcome =
        RunProgram({"mesh_evaluator", "--input_path", mesh, "--workspace_path", Workspace(),
                    "--json_path", "-", "--Photometric.level", "0"});
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output)["photometric"]["score"].get<double>();
  };
  EXPECT_GT(score(Truth()), score(Mesh()));
}

TEST_F(EvaluationCommands, EvaluatorScoresTextures) {
  const auto score = [&](const fs::path& mesh) {
    const Outcome outcome =
        RunProgram({"mesh_evaluator", "--input_path", mesh, "--workspace_path", Workspace(),
                    "--texture", "1", "--view_step", "3", "--json_path", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output);
  };
  TriangleMesh gray = ReadMeshPly(Truth());
  gray.vertex_colors.assign(gray.vertices.size(), Color(128, 128, 128));
  const fs::path gray_path = folder_->path() / "gray.ply";
  WriteMeshPly(gray_path, gray);
  const nlohmann::json textured = score(Textured()), plain = score(gray_path);
  EXPECT_EQ(textured["texture"]["views"].size(), 2u);  // every third of six
  EXPECT_FALSE(textured.contains("photometric"));
  EXPECT_EQ(textured["atlas"]["pages"], 1);
  EXPECT_FALSE(plain.contains("atlas"));
  EXPECT_GT(textured["texture"]["psnr"].get<double>(), plain["texture"]["psnr"].get<double>());
  EXPECT_GT(textured["texture"]["ssim"].get<double>(),
            plain["texture"]["ssim"].get<double>() + 0.1);
  EXPECT_EQ(textured["texture"]["completeness"], plain["texture"]["completeness"]);
}

TEST_F(EvaluationCommands, TexturesThatCannotBeScored) {
  const auto refused = [&](const std::vector<std::string>& arguments, int code,
                           const std::string& text) {
    std::vector<std::string> all = {"mesh_evaluator", "--texture", "1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = RunProgram(all);
    EXPECT_EQ(outcome.code, code);
    EXPECT_THAT(outcome.errors, HasSubstr(text));
  };
  refused({"--input_path", Textured()}, 2, "--texture needs --workspace_path");
  TriangleMesh plain = ReadMeshPly(Truth());
  plain.vertex_colors.clear();
  const fs::path path = folder_->path() / "plain.ply";
  WriteMeshPly(path, plain);
  refused({"--input_path", path, "--workspace_path", Workspace()}, 3, "neither texture nor");
  plain.faces.clear();
  WriteMeshPly(path, plain);
  refused({"--input_path", path, "--workspace_path", Workspace()}, 3, "has no faces");
  refused(
      {"--input_path", Textured(), "--workspace_path", Workspace(), "--TextureScore.level", "99"},
      2, "TextureScore.level");
}

TEST_F(EvaluationCommands, RendererDrawsTextures) {
  const fs::path picture = folder_->path() / "texture.png", gray = folder_->path() / "clay.png";
  for (const auto& [path, mesh] : {std::pair(picture, Textured()), {gray, Truth()}}) {
    ASSERT_EQ(RunProgram({"mesh_renderer", "--input_path", mesh, "--output_path", path,
                          "--workspace_path", Workspace(), "--style", "color", "--width", "160"})
                  .code,
              0);
  }
  // The surface has one colour without texture and many with it.
  const ColorImage image = ReadColors(picture), clay = ReadColors(gray);
  const Color surface = clay(clay.width / 2, clay.height / 2);
  int low = 255, high = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    if (clay.pixels[i] != surface) continue;
    low = std::min<int>(low, image.pixels[i][1]);
    high = std::max<int>(high, image.pixels[i][1]);
  }
  EXPECT_GT(high - low, 20);
}

TEST_F(EvaluationCommands, ComparerShowsTextures) {
  Textured();
  const fs::path report = folder_->path() / "textured-report";
  const Outcome outcome =
      RunProgram({"mesh_comparer", "--workspace_path", Workspace(), "--output_path", report,
                  "--picture_width", "64", "--max_num_faces", "2000", "--max_num_photos", "2"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_TRUE(fs::exists(report / "mesh-texture.png"));
  bool found = false;
  for (const auto& entry : fs::directory_iterator(report)) {
    if (entry.path().extension() != ".json" || !Content(entry.path()).starts_with("{")) continue;
    const nlohmann::json json = nlohmann::json::parse(Content(entry.path()));
    if (!json.contains("meshes")) continue;
    for (const auto& mesh : json["meshes"]) {
      if (mesh["title"] != "textured") continue;
      found = true;
      EXPECT_GT(mesh["figures"]["texture"]["psnr"], 10);
      EXPECT_EQ(mesh["figures"]["atlas"]["pages"], 1);
    }
  }
  EXPECT_TRUE(found);
  if (HasReportPage()) {
    EXPECT_THAT(Content(report / "index.html"), HasSubstr("id=\"texture-"));
  }
  fs::remove_all(Workspace() / "textured");  // of the other tests
}

// Patches at these places, each seen by three photos.
std::string Patches(const std::vector<Eigen::Vector3d>& points) {
  std::string text = fmt::format("PATCHES\n{}\n", points.size());
  for (const Eigen::Vector3d& x : points) {
    text += fmt::format("PATCHS\n{} {} {} 1\n0 0 1 0\n0.8 1 1\n3\n0 1 2 \n0\n\n\n", x.x(), x.y(),
                        x.z());
  }
  return text;
}

// The truth is the square [0,1]^2 at z = 0. Half of the patches lie in it, a quarter 0.3 above and
// a quarter 0.7 above, each in a voxel of its own.
TEST_F(EvaluationCommands, EvaluatorScoresPatchesOfPmvs) {
  TriangleMesh square;
  square.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.faces = {{0, 1, 2}, {0, 2, 3}};
  const fs::path truth = folder_->path() / "square.ply", path = folder_->path() / "a.patch";
  WriteMeshPly(truth, square);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 24; ++i) {
    const double z = i < 12 ? 0 : i < 18 ? 0.3 : 0.7;
    points.emplace_back(0.1 + 0.2 * (i % 5), 0.1 + 0.2 * (i / 5), z);
  }
  WriteFileAtomically(path, Patches(points));
  const Outcome outcome =
      RunProgram({"mesh_evaluator", "--input_path", path, "--ground_truth_path", truth, "--unit",
                  "world", "--thresholds", "0.29,0.31,1", "--json_path", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const nlohmann::json json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["surface"]["kind"], "cloud");
  EXPECT_EQ(json["surface"]["accuracy"]["shares"], (std::vector<double>{0.5, 0.75, 1}));
  EXPECT_EQ(json["surface"]["completeness"]["shares"][2], 1);
  EXPECT_EQ(json["cloud"]["points"], 24);
  EXPECT_EQ(json["cloud"]["mean_views"], 3);
  EXPECT_NEAR(json["cloud"]["mean_score"], 0.8, 1e-6);
  EXPECT_FALSE(json["cloud"].contains("coverage"));
}

TEST_F(EvaluationCommands, CloudsAreMeasuredWithoutTruth) {
  const fs::path path = folder_->path() / "b.patch";
  WriteFileAtomically(path, Patches(ReadMeshPly(Truth()).vertices));
  const Outcome outcome = RunProgram({"mesh_evaluator", "--input_path", path, "--workspace_path",
                                      Workspace(), "--json_path", "-"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const double coverage = nlohmann::json::parse(outcome.output)["cloud"]["coverage"];
  EXPECT_GT(coverage, 0.05);
  EXPECT_LT(coverage, 1);
  // Photos are only compared through a mesh.
  const Outcome photos = RunProgram(
      {"mesh_evaluator", "--input_path", path, "--workspace_path", Workspace(), "--photometric"});
  EXPECT_EQ(photos.code, 3);
  EXPECT_THAT(photos.errors, HasSubstr("only seen through a mesh"));
}

TEST_F(EvaluationCommands, BadPatchesAreRefused) {
  const fs::path path = folder_->path() / "c.patch";
  const auto refused = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(path, text);
    const Outcome outcome =
        RunProgram({"mesh_evaluator", "--input_path", path, "--workspace_path", Workspace()});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.errors, HasSubstr("c.patch: " + message));
  };
  std::string text = Patches({{1, 2, 3}, {4, 5, 6}});
  refused(text.substr(0, text.find("0 1 2", text.find("4 5 6"))),
          "line 17: ends before the photos");
  refused("PATCHES\n0\n", "has no points");
  text.replace(text.find("4 5 6"), 5, "4 nan 6");
  refused(text, "line 13: has a number that is not finite");
}

TEST_F(EvaluationCommands, ComparerTakesPatchesOfPmvs) {
  const fs::path patches = folder_->path() / "d.patch", report = folder_->path() / "pmvs-report";
  WriteFileAtomically(patches, Patches(ReadMeshPly(Truth()).vertices));
  const Outcome outcome =
      RunProgram({"mesh_comparer", Workspace(), "--ground_truth_path", Truth(), "--input_paths",
                  patches, "--output_path", report, "--picture_width", "64", "--max_num_faces",
                  "500", "--max_num_photos", "2", "--num_samples", "2000"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const nlohmann::json json = nlohmann::json::parse(Content(report / "report.json"));
  ASSERT_EQ(json["clouds"].size(), 1u);
  EXPECT_EQ(json["clouds"][0]["file"], "d.patch");
  EXPECT_EQ(json["clouds"][0]["figures"]["surface"]["kind"], "cloud");
  EXPECT_GT(json["clouds"][0]["figures"]["surface"]["accuracy"]["shares"][0], 0.99);
  EXPECT_EQ(json["clouds"][0]["figures"]["cloud"]["mean_views"], 3);
  EXPECT_EQ(json["meshes"].size(), 1u);
}

TEST_F(EvaluationCommands, EvaluatorSaysWhatIsWrong) {
  EXPECT_EQ(RunProgram({"mesh_evaluator", "--input_path", Mesh()}).code, 2);
  EXPECT_EQ(
      RunProgram({"mesh_evaluator", "--input_path", Mesh(), "--ground_truth_path", "nowhere.ply"})
          .code,
      3);
  const Outcome views = RunProgram({"mesh_evaluator", "--input_path", Mesh(), "--workspace_path",
                                    Workspace(), "--view_names", "nobody.png"});
  EXPECT_EQ(views.code, 2);
  EXPECT_THAT(views.errors, HasSubstr("nobody.png"));
  const Outcome thresholds = RunProgram({"mesh_evaluator", "--input_path", Mesh(),
                                         "--ground_truth_path", Truth(), "--thresholds", "2,1"});
  EXPECT_EQ(thresholds.code, 2);
  EXPECT_THAT(thresholds.errors, HasSubstr("thresholds"));
}

TEST_F(EvaluationCommands, RendererDrawsFromPhotosAndTurntable) {
  const fs::path picture = folder_->path() / "picture.png";
  ASSERT_EQ(RunProgram({"mesh_renderer", "--input_path", Mesh(), "--output_path", picture,
                        "--workspace_path", Workspace(), "--width", "80"})
                .code,
            0);
  const ColorImage image = ReadColors(picture);
  EXPECT_EQ(image.width, 80);
  EXPECT_EQ(image.height, 60);
  EXPECT_LT(image(40, 30)[0], 235);  // the sphere, darker than the background
  ASSERT_EQ(
      RunProgram({"mesh_renderer", "--input_path", Mesh(), "--output_path", picture, "--num_frames",
                  "3", "--width", "32", "--height", "24", "--style", "normals"})
          .code,
      0);
  EXPECT_EQ(ReadColors(folder_->path() / "picture-002.png").height, 24);
  EXPECT_EQ(
      RunProgram({"mesh_renderer", "--input_path", Mesh(), "--output_path", picture, "--up", "0,0"})
          .code,
      2);
}

TEST_F(EvaluationCommands, InputsAreNotReplaced) {
  const auto before = ReadMeshPly(Mesh()).faces.size();
  const Outcome name =
      RunProgram({"mesh_renderer", "--input_path", Mesh(), "--output_path", Mesh()});
  EXPECT_EQ(name.code, 2);
  const fs::path photo = fs::path(Workspace()) / "images" / "0000.png";
  const Outcome renderer = RunProgram({"mesh_renderer", "--input_path", Mesh(), "--output_path",
                                       photo, "--workspace_path", Workspace()});
  EXPECT_EQ(renderer.code, 6);
  EXPECT_THAT(renderer.errors, HasSubstr("0000.png"));
  for (const char* option : {"--json_path", "--error_path"}) {
    EXPECT_EQ(RunProgram({"mesh_evaluator", "--input_path", Mesh(), "--ground_truth_path", Truth(),
                          option, Truth()})
                  .code,
              6);
  }
  EXPECT_EQ(ReadMeshPly(Mesh()).faces.size(), before);
  EXPECT_GT(ReadMeshPly(Truth()).faces.size(), 0u);
}

TEST_F(EvaluationCommands, ComparerWritesPageFiguresAndPictures) {
  const fs::path other = folder_->path() / "other.ply";
  WriteMeshPly(other, ReadMeshPly(Truth()));
  const Outcome outcome =
      RunProgram({"mesh_comparer", Workspace(), "--ground_truth_path", Truth(), "--input_paths",
                  other, "--picture_width", "64", "--max_num_faces", "500", "--max_num_photos", "2",
                  "--num_samples", "2000"});
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const fs::path report = Workspace() / "lsmvs" / "report";
  const nlohmann::json json = nlohmann::json::parse(Content(report / "report.json"));
  ASSERT_EQ(json["meshes"].size(), 2u);
  EXPECT_EQ(json["meshes"][0]["title"], "lsmvs refined");
  EXPECT_EQ(json["title"], "Meshes of ws");
  EXPECT_EQ(json["meshes"][0]["figures"]["silhouettes"]["hole_share"], 0);
  EXPECT_EQ(json["meshes"][0]["figures"]["silhouettes"]["views"], 6);
  EXPECT_LE(json["meshes"][0]["faces_shown"], 500);
  EXPECT_LT(json["meshes"][0]["figures"]["surface"]["f1"][0],
            json["meshes"][1]["figures"]["surface"]["f1"][0]);
  EXPECT_EQ(json["missing"].size(), 3u);
  EXPECT_EQ(ReadColors(report / "meshed-refined.png").width, 64);
  EXPECT_TRUE(fs::exists(report / "other-errors.png"));
  if (!HasReportPage()) return;
  const std::string page = Content(report / "index.html");
  EXPECT_THAT(page, HasSubstr("id=\"mesh-1\""));
  // Neither file has colours; both are shown in those of the photos.
  EXPECT_THAT(page, HasSubstr("other.ply has no colours"));
  EXPECT_THAT(page, HasSubstr("\"colors\":true"));
  EXPECT_THAT(page, Not(HasSubstr("\"colors\":false")));
}

// A stand-in for the executable: its Poisson mesher copies the truth, its Delaunay mesher fails, a
// third is unknown.
TEST_F(EvaluationCommands, ComparerRunsWhatColmapCan) {
  const fs::path workspace = folder_->path() / "with-colmap", colmap = folder_->path() / "colmap";
  fs::copy(Workspace(), workspace, fs::copy_options::recursive);
  fs::remove_all(workspace / "lsmvs");
  fs::copy(Truth(), workspace / "fused.ply");
  WriteFileAtomically(colmap,
                      "#!/bin/sh\n"
                      "case $1 in\n"
                      "-h) echo 'COLMAP 9.9 -- test';;\n"
                      "help) echo poisson_mesher; echo delaunay_mesher;;\n"
                      "poisson_mesher) cp \"$3\" \"$5\";;\n"
                      "*) echo 'requires CGAL'; exit 1;;\n"
                      "esac\n");
  fs::permissions(colmap, fs::perms::owner_all);
  ::setenv("COLMAP", colmap.c_str(), 1);
  const auto compare = [&] {
    const Outcome outcome =
        RunProgram({"mesh_comparer", workspace, "--run_colmap", "--picture_width", "32"});
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return nlohmann::json::parse(Content(workspace / "lsmvs" / "report" / "report.json"));
  };
  nlohmann::json json = compare();
  ASSERT_EQ(json["meshes"].size(), 2u);
  EXPECT_EQ(json["meshes"][1]["title"], "COLMAP Poisson");
  EXPECT_GT(json["meshes"][1]["peak_bytes"], 0);
  ASSERT_EQ(json["missing"].size(), 2u);
  EXPECT_THAT(json["missing"][0]["reason"].get<std::string>(), HasSubstr("requires CGAL"));
  EXPECT_EQ(json["missing"][1]["reason"], "COLMAP 9.9 has no advancing_front_mesher");
  const double seconds = json["meshes"][1]["seconds"];
  fs::remove(colmap);  // what is there is not made again, and its time is remembered
  json = compare();
  ::unsetenv("COLMAP");
  EXPECT_EQ(json["meshes"][1]["seconds"], seconds);
  EXPECT_THAT(json["missing"][0]["reason"].get<std::string>(), HasSubstr("not found"));
}

TEST_F(EvaluationCommands, ComparerNeedsAMesh) {
  const fs::path empty = folder_->path() / "empty";
  SyntheticScene scene = MakeScene(ShapeName::kSphere, 3, 64, 48);
  WriteWorkspace(empty, WorkspaceFormat::kDense, &scene, RunContext(2));
  const Outcome outcome = RunProgram({"mesh_comparer", empty});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.errors, HasSubstr("no mesh to compare"));
}

}  // namespace
}  // namespace lsmvs
