#include "lsmvs/mesh/textured_ply.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

Color ColorAt(const Eigen::Vector3d& x) {
  return (127.5 + 100 * (3 * x).array().sin()).matrix().cast<uint8_t>();
}

class TexturedPlyTest : public ::testing::Test {
 protected:
  std::filesystem::path Path() const { return folder_.path() / "mesh.ply"; }
  void Write(const std::string& content) const {
    std::ofstream(Path(), std::ios::binary) << content;
  }
  std::string Bytes() const {
    std::ifstream file(Path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::string ErrorOf(const std::string& content) const {
    Write(content);
    try {
      ReadTexturedPly(Path());
    } catch (const InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted: " << content.substr(0, 300);
    return "";
  }
  TexturedMesh Painted(const AtlasOptions& options) const {
    TriangleMesh mesh = Sphere({1, 2, 3}, 1.0).Mesh(0.6);
    // Numbers that a float holds exactly.
    for (Eigen::Vector3d& x : mesh.vertices) x = (4096 * x).array().round() / 4096;
    return PaintAtlas(mesh, ColorAt, folder_.path(), options);
  }
  void ExpectSame(const TexturedMesh& back, const TexturedMesh& textured, double tolerance) const {
    std::string fault;
    EXPECT_TRUE(back.Check(&fault)) << fault;
    EXPECT_EQ(back.mesh.vertices, textured.mesh.vertices);
    EXPECT_EQ(back.mesh.faces, textured.mesh.faces);
    EXPECT_EQ(back.page_idx, textured.page_idx);
    EXPECT_EQ(back.pages, textured.pages);
    EXPECT_EQ(back.page_width, textured.page_width);
    EXPECT_EQ(back.page_height, textured.page_height);
    ASSERT_EQ(back.texcoords.size(), textured.texcoords.size());
    for (size_t f = 0; f < back.texcoords.size(); ++f) {
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_LE((back.texcoords[f][c] - textured.texcoords[f][c]).norm(), tolerance);
      }
    }
  }
  TemporaryFolder folder_;
};

TEST_F(TexturedPlyTest, RoundTripOfOneAndOfSeveralPages) {
  AtlasOptions one;
  one.page_width = one.page_height = 1024;
  ASSERT_EQ(Painted(one).pages.size(), 1u);
  WriteTexturedPly(Path(), Painted(one));
  ExpectSame(ReadTexturedPly(Path()), Painted(one), 0);  // sides that a float divides exactly
  EXPECT_EQ(Bytes().find("texnumber"), std::string::npos);

  AtlasOptions several;
  several.page_width = 150;
  several.page_height = 90;
  ASSERT_GT(Painted(several).pages.size(), 2u);
  WriteTexturedPly(Path(), Painted(several));
  ExpectSame(ReadTexturedPly(Path()), Painted(several), 1e-4);
}

// COLMAP, MeshLab and OpenMVS write this; v is 1 at the top of the page.
TEST_F(TexturedPlyTest, HeaderAndDirectionOfV) {
  const ColorImage page(8, 4, Color(1, 2, 3));
  WritePng(folder_.path() / "a b.png", page);
  TexturedMesh textured;
  textured.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  textured.mesh.faces = {{0, 1, 2}};
  textured.texcoords = {{Eigen::Vector2f(0, 0), Eigen::Vector2f(8, 0), Eigen::Vector2f(2, 4)}};
  textured.page_idx = {0};
  textured.pages = {folder_.path() / "a b.png"};
  textured.page_width = 8;
  textured.page_height = 4;
  WriteTexturedPly(Path(), textured);
  const std::string bytes = Bytes();
  const size_t body = bytes.find("end_header\n") + 11;
  EXPECT_EQ(bytes.substr(0, body),
            "ply\nformat binary_little_endian 1.0\ncomment TextureFile a b.png\nelement vertex 3\n"
            "property float x\nproperty float y\nproperty float z\nelement face 1\n"
            "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
            "end_header\n");
  float uv[6];
  ASSERT_EQ(bytes.size(), body + 3 * 12 + 13 + 1 + sizeof uv);
  std::memcpy(uv, bytes.data() + body + 3 * 12 + 13 + 1, sizeof uv);
  EXPECT_EQ(std::vector<float>(uv, uv + 6), (std::vector<float>{0, 1, 1, 1, 0.25, 0}));
  ExpectSame(ReadTexturedPly(Path()), textured, 0);
}

TEST_F(TexturedPlyTest, KeepsColorsNormalsAndOffset) {
  TexturedMesh textured = Painted({});
  textured.mesh.vertex_normals = ComputeVertexNormals(textured.mesh);
  for (const Eigen::Vector3d& x : textured.mesh.vertices) {
    textured.mesh.vertex_colors.push_back(ColorAt(x));
  }
  const Eigen::Vector3d offset(431000, 5411000, 200);
  WriteTexturedPly(Path(), textured, offset);
  const TexturedMesh back = ReadTexturedPly(Path(), offset);
  EXPECT_EQ(back.mesh.vertex_colors, textured.mesh.vertex_colors);
  EXPECT_EQ(back.mesh.vertex_normals, textured.mesh.vertex_normals);
  for (size_t v = 0; v < back.mesh.vertices.size(); ++v) {
    EXPECT_LT((back.mesh.vertices[v] - textured.mesh.vertices[v]).norm(), 1e-8);
  }
  // It stays a PLY that the reader of plain meshes takes.
  EXPECT_EQ(ReadMeshPly(Path(), offset).faces, textured.mesh.faces);
}

TEST_F(TexturedPlyTest, MeshWithoutTextureIsAPlainOne) {
  TexturedMesh plain;
  plain.mesh = Painted({}).mesh;
  WriteTexturedPly(Path(), plain);
  const std::string bytes = Bytes();
  WriteMeshPly(Path(), plain.mesh);
  EXPECT_EQ(Bytes(), bytes);
  EXPECT_FALSE(ReadTexturedPly(Path()).has_texture());
}

constexpr const char* kVertices =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
constexpr const char* kRows = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

std::string Quad(const std::string& page, const std::string& face) {
  return "ply\nformat ascii 1.0\ncomment TextureFile " + page + "\n" + kVertices +
         "element face 1\nproperty list uchar int vertex_index\n"
         "property list uchar float texcoord\nproperty int texnumber\nend_header\n" +
         kRows + face + "\n";
}

TEST_F(TexturedPlyTest, PolygonsBecomeFans) {
  WritePng(folder_.path() / "t.png", ColorImage(10, 20, Color(0, 0, 0)));
  Write(Quad("t.png", "4 0 1 2 3 8 0 0 1 0 1 1 0 1 0"));
  const TexturedMesh mesh = ReadTexturedPly(Path());
  ASSERT_EQ(mesh.texcoords.size(), 2u);
  EXPECT_EQ(mesh.mesh.faces[1], Eigen::Vector3i(0, 2, 3));
  EXPECT_EQ(mesh.texcoords[1][0], Eigen::Vector2f(0, 20));
  EXPECT_EQ(mesh.texcoords[1][1], Eigen::Vector2f(10, 0));
  EXPECT_EQ(mesh.texcoords[1][2], Eigen::Vector2f(0, 0));
}

TEST_F(TexturedPlyTest, TextureCoordinatesPerVertex) {
  WritePng(folder_.path() / "t.png", ColorImage(10, 20, Color(0, 0, 0)));
  for (const auto& [u, v] : {std::pair("s", "t"), {"u", "v"}, {"texture_u", "texture_v"}}) {
    Write(std::string("ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 3\n"
                      "property float x\nproperty float y\nproperty float z\nproperty float ") +
          u + "\nproperty float " + v +
          "\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
          "0 0 0 0 1\n1 0 0 1 1\n0 1 0 0.5 0.25\n3 2 0 1\n");
    const TexturedMesh mesh = ReadTexturedPly(Path());
    ASSERT_EQ(mesh.texcoords.size(), 1u) << u;
    EXPECT_EQ(mesh.texcoords[0][0], Eigen::Vector2f(5, 15));
    EXPECT_EQ(mesh.texcoords[0][2], Eigen::Vector2f(10, 0));
  }
}

TEST_F(TexturedPlyTest, PagesOfOtherSizesAreStretched) {
  WritePng(folder_.path() / "a.png", ColorImage(10, 20, Color(0, 0, 0)));
  WriteJpeg(folder_.path() / "b.jpg", ColorImage(40, 10, Color(0, 0, 0)), 90);
  Write("ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b.jpg\n" +
        std::string(kVertices) +
        "element face 2\nproperty list uchar int vertex_index\n"
        "property list uchar float texcoord\nproperty uchar texnumber\nend_header\n" +
        kRows + "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0 0 1 1 0 1 1\n");
  const TexturedMesh mesh = ReadTexturedPly(Path());
  EXPECT_EQ(mesh.page_width, 40);
  EXPECT_EQ(mesh.page_height, 20);
  EXPECT_EQ(mesh.page_idx, (std::vector<uint16_t>{0, 1}));
  EXPECT_EQ(mesh.texcoords[1][1], Eigen::Vector2f(40, 0));
}

TEST_F(TexturedPlyTest, FindsPagesBesideTheMesh) {
  std::filesystem::create_directory(folder_.path() / "sub");
  WritePng(folder_.path() / "sub" / "in.png", ColorImage(4, 4, Color(0, 0, 0)));
  WritePng(folder_.path() / "out.png", ColorImage(4, 4, Color(0, 0, 0)));
  const std::string face = "3 0 1 2 6 0 0 1 0 1 1 0";
  for (const auto& [name, found] : {std::pair("sub/in.png", "sub/in.png"),
                                    {"out.png", "out.png"},
                                    {"elsewhere/out.png", "out.png"},
                                    {"C:\\textures\\out.png", "out.png"},
                                    {"/nowhere/out.png", "out.png"}}) {
    Write(Quad(name, face));
    EXPECT_EQ(ReadTexturedPly(Path()).pages.at(0), folder_.path() / found) << name;
  }
}

TEST_F(TexturedPlyTest, BadTexturesAreRefused) {
  WritePng(folder_.path() / "t.png", ColorImage(10, 20, Color(0, 0, 0)));
  std::ofstream(folder_.path() / "text.png") << "no picture";
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string good = "3 0 1 2 6 0 0 1 0 1 1 0";
  EXPECT_TRUE(contains(ErrorOf(Quad("none.png", good)), "none.png is missing"));
  EXPECT_TRUE(contains(ErrorOf(Quad("text.png", good)), "text.png"));
  EXPECT_TRUE(contains(ErrorOf(Quad("", good)), "names no file"));
  EXPECT_TRUE(contains(ErrorOf(Quad("t.png", "3 0 1 2 6 0 0 1 0 1 1 1")), "texnumber 1"));
  EXPECT_TRUE(contains(ErrorOf(Quad("t.png", "3 0 1 2 6 0 0 1 0 1 1 -1")), "texnumber -1"));
  EXPECT_TRUE(contains(ErrorOf(Quad("t.png", "3 0 1 2 4 0 0 1 0 0")), "3 corners and 4 numbers"));
  EXPECT_TRUE(contains(ErrorOf(Quad("t.png", "3 0 1 2 6 0 0 nan 0 1 1 0")), "not finite"));
  EXPECT_TRUE(contains(ErrorOf(Quad("t.png", "3 0 1 4 6 0 0 1 0 1 1 0")), "names vertex 4"));
  EXPECT_TRUE(contains(
      ErrorOf("ply\nformat ascii 1.0\ncomment TextureFile t.png\n" + std::string(kVertices) +
              "element face 1\nproperty list uchar int vertex_index\n"
              "end_header\n" +
              kRows + "3 0 1 2\n"),
      "no texture coordinates"));
}

TEST_F(TexturedPlyTest, EveryTruncationIsFound) {
  AtlasOptions options;
  options.page_width = options.page_height = 64;
  options.chart_px = 10;
  TexturedMesh textured =
      PaintAtlas(Sphere({0, 0, 0}, 1).Mesh(2), ColorAt, folder_.path(), options);
  ASSERT_GT(textured.pages.size(), 1u);
  WriteTexturedPly(Path(), textured);
  const std::string whole = Bytes();
  for (size_t length = 0; length < whole.size(); length += 1 + length / 400)
    ErrorOf(whole.substr(0, length));
}

TEST_F(TexturedPlyTest, BrokenBytesNeverCrash) {
  WriteTexturedPly(Path(), Painted({}));
  const std::string whole = Bytes();
  Random random(2);
  int num_refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string broken = whole;
    for (int k = 0; k < 3; ++k) {
      broken[random.Below(i % 2 == 0 ? 300 : broken.size())] = static_cast<char>(random.Bits());
    }
    Write(broken);
    try {
      std::string fault;
      EXPECT_TRUE(ReadTexturedPly(Path()).Check(&fault)) << fault;
    } catch (const InputError&) {
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 100);
}

TEST_F(TexturedPlyTest, CheckFindsEachFault) {
  const TexturedMesh good = Painted({});
  std::string fault;
  ASSERT_TRUE(good.Check(&fault)) << fault;
  const std::vector<std::function<void(TexturedMesh*)>> breaks = {
      [](TexturedMesh* m) { m->texcoords.pop_back(); },
      [](TexturedMesh* m) { m->page_idx.pop_back(); },
      [](TexturedMesh* m) { m->page_idx[3] = static_cast<uint16_t>(m->pages.size()); },
      [](TexturedMesh* m) { m->pages.clear(); },
      [](TexturedMesh* m) { m->page_width = 0; },
      [](TexturedMesh* m) { m->page_height = -1; },
      [](TexturedMesh* m) { m->mesh.faces[2][1] = -1; },
      [](TexturedMesh* m) { m->mesh.faces[2][1] = static_cast<int>(m->mesh.vertices.size()); },
      [](TexturedMesh* m) { m->texcoords[1][2][0] = std::nanf(""); },
      [](TexturedMesh* m) { m->mesh.vertex_colors.resize(1); },
      [](TexturedMesh* m) { m->mesh.vertex_normals.resize(1); },
  };
  for (size_t b = 0; b < breaks.size(); ++b) {
    TexturedMesh bad = good;
    breaks[b](&bad);
    EXPECT_FALSE(bad.Check(&fault)) << b;
    EXPECT_FALSE(fault.empty()) << b;
  }
}

}  // namespace
}  // namespace lsmvs
