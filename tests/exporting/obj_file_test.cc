#include "lsmvs/exporting/files/obj_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

struct ObjFace {
  std::string material;
  int vertex[3], texcoord[3];
};

// A reader of just what the format says.
struct Obj {
  std::vector<std::vector<double>> vertices;
  std::vector<Eigen::Vector2d> texcoords;
  std::vector<ObjFace> faces;
  std::string library;

  explicit Obj(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::string material;
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string key;
      words >> key;
      if (key == "mtllib") words >> library;
      if (key == "usemtl") words >> material;
      if (key == "v") {
        vertices.emplace_back();
        for (double x = 0; words >> x;) vertices.back().push_back(x);
      }
      if (key == "vt") {
        Eigen::Vector2d uv;
        words >> uv[0] >> uv[1];
        texcoords.push_back(uv);
      }
      if (key == "f") {
        ObjFace face;
        face.material = material;
        for (int c = 0; c < 3; ++c) {
          char slash = 0;
          words >> face.vertex[c];
          face.texcoord[c] = 0;
          if (words.peek() == '/') words >> slash >> face.texcoord[c];
        }
        faces.push_back(face);
      }
    }
  }
};

TEST(ObjFile, HoldsMeshAndTexture) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = 300;
  options.page_height = 200;
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.5), BlobColor, folder.path(), options);
  const Eigen::Vector3d offset(10, 20, 30);
  WriteObj(folder.path() / "a b.obj", textured, textured.pages, offset);
  const Obj obj(folder.path() / "a b.obj");
  ASSERT_EQ(obj.vertices.size(), textured.mesh.vertices.size());
  for (size_t v = 0; v < obj.vertices.size(); ++v) {
    ASSERT_EQ(obj.vertices[v].size(), 3u);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(obj.vertices[v][k], textured.mesh.vertices[v][k] - offset[k], 2e-6);
    }
  }
  ASSERT_EQ(obj.faces.size(), textured.mesh.faces.size());
  for (size_t f = 0; f < obj.faces.size(); ++f) {
    EXPECT_EQ(obj.faces[f].material, "page_" + std::to_string(textured.page_idx[f]));
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(obj.faces[f].vertex[c], textured.mesh.faces[f][c] + 1);
      const Eigen::Vector2d uv = textured.NormalizedTexcoord(f, c);
      const Eigen::Vector2d read = obj.texcoords.at(obj.faces[f].texcoord[c] - 1);
      EXPECT_LT((read - Eigen::Vector2d(uv[0], 1 - uv[1])).norm(), 1e-6);
    }
  }
  std::ifstream mtl(folder.path() / "a b.mtl");
  const std::string materials{std::istreambuf_iterator<char>(mtl), {}};
  for (const char* text :
       {"newmtl page_0\n", "map_Kd page0.png\n", "Kd 1 1 1\n", "newmtl page_1"}) {
    EXPECT_NE(materials.find(text), std::string::npos) << text;
  }
}

TEST(ObjFile, VertexColors) {
  const TemporaryFolder folder;
  TexturedMesh colored;
  colored.mesh = BlobMesh(0.7);
  for (const Eigen::Vector3d& x : colored.mesh.vertices) {
    colored.mesh.vertex_colors.push_back(BlobColor(x));
  }
  WriteObj(folder.path() / "c.obj", colored, {}, Eigen::Vector3d::Zero());
  const Obj obj(folder.path() / "c.obj");
  EXPECT_TRUE(obj.library.empty());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "c.mtl"));
  ASSERT_EQ(obj.vertices.size(), colored.mesh.vertices.size());
  for (size_t v = 0; v < obj.vertices.size(); ++v) {
    ASSERT_EQ(obj.vertices[v].size(), 6u);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(std::lround(255 * obj.vertices[v][3 + k]), colored.mesh.vertex_colors[v][k]);
    }
  }
  EXPECT_EQ(obj.faces.at(3).texcoord[0], 0);
}

}  // namespace
}  // namespace lsmvs
