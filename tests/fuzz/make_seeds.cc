// Writes small valid files for the fuzzers to start from: make_seeds FOLDER fills FOLDER/<fuzzer>/.
#include <sqlite3.h>

#include <fstream>
#include <iterator>
#include <string>

#include "fuzz_input.h"
#include "lsmvs/colmap_adapter/depth_map_io.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/ply.h"

namespace {

using namespace lsmvs;
namespace fs = std::filesystem;

SparseModel Model() {
  using enum SparseModel::SensorType;
  SparseModel model;
  model.cameras = {{CameraId{1}, 1, 64, 48, {50, 50, 32, 24}}};
  model.images = {{ImageId{1}, {}, CameraId{1}, "a", 1, {{{3, 4}, Point3dId{7}}}},
                  {ImageId{2}, {}, CameraId{1}, "b", 1, {{{3, 4}, Point3dId{7}}}}};
  model.points3d = {{Point3dId{7}, {0, 0, 3}, {1, 2, 3}, 0.5, {{ImageId{1}, 0}, {ImageId{2}, 0}}}};
  model.rigs = {{RigId{1}, {{{kCamera, 1}, {}}, {{kImu, 2}, SparseModel::Pose{}}}}};
  model.frames = {{FrameId{1}, RigId{1}, {}, {{{kCamera, 1}, 1}, {{kImu, 2}, 5}}},
                  {FrameId{2}, RigId{1}, {}, {{{kCamera, 1}, 2}}}};
  return model;
}

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string Piece(const std::string& bytes) {
  const auto length = static_cast<uint16_t>(bytes.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + bytes;
}

void Put(const fs::path& folder, const char* fuzzer, const char* name, const std::string& bytes) {
  fs::create_directories(folder / fuzzer);
  std::ofstream(folder / fuzzer / name, std::ios::binary) << bytes;
}

void PutModels(const fs::path& out, const fs::path& work) {
  WriteSparseModel(work, Model(), SparseFormat::kBinary);
  WriteSparseModel(work, Model(), SparseFormat::kText);
  Put(out, "cameras", "seed", Content(work / "cameras.bin"));
  Put(out, "images", "seed", Content(work / "images.bin"));
  Put(out, "points3d", "seed", Content(work / "points3D.bin"));
  Put(out, "rigs_frames", "seed", Piece(Content(work / "rigs.bin")) + Content(work / "frames.bin"));
  std::string text;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt", "rigs.txt"}) {
    text += Piece(Content(work / name));
  }
  Put(out, "text_model", "seed", text + Content(work / "frames.txt"));
}

void PutMaps(const fs::path& out, const fs::path& work) {
  const View view{ImageId{1}, "a", {64, 48, 50, 50, 32, 24}, Rigid3()};
  const DepthMap map{Raster<float>(4, 3, 2.0f),
                     Raster<Eigen::Vector3f>(4, 3, Eigen::Vector3f(0, 0, -1))};
  const DenseWorkspace workspace{work};
  WriteDepthMap(workspace, view, DepthMapKind::kGeometric, map);
  Put(out, "depth_map", "seed",
      Piece(Content(workspace.DepthMapPath("a", DepthMapKind::kGeometric))) +
          Content(workspace.NormalMapPath("a", DepthMapKind::kGeometric)));
  WriteDepthMap(workspace, view, DepthMapKind::kGeometric, map, MapFormat::kCompact);
  Put(out, "depth_map", "compact",
      Piece(Content(workspace.DepthMapPath("a", DepthMapKind::kGeometric))) +
          Content(workspace.NormalMapPath("a", DepthMapKind::kGeometric)));
}

void PutClouds(const fs::path& out, const fs::path& work) {
  Scene scene;
  scene.views.resize(2);
  VisibilityCloud cloud;
  const std::vector<uint32_t> views = {0, 1};
  for (int i = 0; i < 3; ++i) cloud.Add({0, 0, 2}, {0, 0, -1}, {1, 2, 3}, views);
  WriteFusedCloud(work / "fused.ply", cloud, scene);
  const std::string vis = Content(work / "fused.ply.vis"), ply = Content(work / "fused.ply");
  Put(out, "visibility_file", "seed", vis);
  Put(out, "fused_cloud", "seed", Piece(vis) + ply);
  Put(out, "ply", "cloud", ply);
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}};
  WriteMeshPly(work / "mesh.ply", mesh);
  Put(out, "ply", "mesh", Content(work / "mesh.ply"));
  Put(out, "ply", "ascii",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty int "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 "
      "0 1 2\n");
}

void PutImages(const fs::path& out) {
  const ColorImage image(8, 6, Color(10, 20, 30));
  const auto put = [&](const char* name, const std::vector<uint8_t>& bytes) {
    Put(out, "image_file", name, std::string(bytes.begin(), bytes.end()));
  };
  put("png", EncodePng(image));
  put("jpeg", EncodeJpeg(image, 90));
}

void PutDatabase(const fs::path& out, const fs::path& work) {
  sqlite3* handle = nullptr;
  sqlite3_open((work / "database.db").c_str(), &handle);
  sqlite3_exec(handle,
               "PRAGMA page_size=512;"
               "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER);"
               "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER,"
               " data BLOB);"
               "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows INTEGER,"
               " cols INTEGER, data BLOB, config INTEGER);"
               "INSERT INTO images VALUES (1, 'a', 1), (2, 'b', 1);"
               "INSERT INTO keypoints VALUES (1, 1, 4, zeroblob(16)), (2, 1, 6, zeroblob(24));"
               "INSERT INTO two_view_geometries VALUES (2147483649, 1, 2, zeroblob(8), 2);",
               nullptr, nullptr, nullptr);
  sqlite3_close(handle);
  Put(out, "database", "seed", Content(work / "database.db"));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const fs::path out = argv[1];
  PutModels(out, lsmvs::fuzz::Folder());
  PutMaps(out, lsmvs::fuzz::Folder());
  PutClouds(out, lsmvs::fuzz::Folder());
  PutImages(out);
  PutDatabase(out, lsmvs::fuzz::Folder());
  Put(out, "stereo_config", "seed",
      "# c\na.jpg\n__auto__, 20\nb.jpg\n__all__\nc.jpg\na.jpg, b.jpg\n");
  return 0;
}
