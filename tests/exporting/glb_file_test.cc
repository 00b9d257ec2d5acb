#include "lsmvs/exporting/files/glb_file.h"

#include <gtest/gtest.h>

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "lsmvs/exporting/mesh_exporter.h"
#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"

namespace lsmvs {
namespace {

using Json = nlohmann::json;

// The two chunks of a file, checked against the container's rules.
struct Glb {
  Json json;
  std::string binary;

  explicit Glb(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto word = [&](size_t at) {
      uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), bytes.size());
    const size_t json_size = word(12);
    EXPECT_EQ(json_size % 4, 0u);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    json = Json::parse(bytes.substr(20, json_size));
    EXPECT_EQ(word(20 + json_size) % 4, 0u);
    EXPECT_EQ(bytes.substr(24 + json_size, 4), std::string("BIN\0", 4));
    binary = bytes.substr(28 + json_size);
    EXPECT_EQ(binary.size(), word(20 + json_size));
    EXPECT_EQ(json["buffers"][0]["byteLength"], binary.size());
  }

  template <class T>
  std::vector<T> Read(size_t accessor) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<size_t>()];
    EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
    EXPECT_GE(view["byteLength"].get<size_t>(), a["count"].get<size_t>() * sizeof(T));
    std::vector<T> values(a["count"].get<size_t>());
    std::memcpy(static_cast<void*>(values.data()), binary.data() + view["byteOffset"].get<size_t>(),
                values.size() * sizeof(T));
    return values;
  }
  const Json& Primitive(size_t i) const { return json["meshes"][0]["primitives"][i]; }
  size_t Attribute(size_t i, const char* name) const {
    return Primitive(i)["attributes"][name].get<size_t>();
  }
};

TEST(GlbFile, HoldsEveryFaceWithItsTexture) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = 300;
  options.page_height = 200;
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.5), BlobColor, folder.path(), options);
  ExportGlb(folder.path() / "m.glb", textured, {}, {});
  const Glb glb(folder.path() / "m.glb");
  ASSERT_EQ(glb.json["images"].size(), textured.pages.size());
  size_t face = 0;
  for (size_t p = 0; p < textured.pages.size(); ++p) {
    const auto x = glb.Read<Eigen::Vector3f>(glb.Attribute(p, "POSITION"));
    const auto uv = glb.Read<Eigen::Vector2f>(glb.Attribute(p, "TEXCOORD_0"));
    const auto indices = glb.Read<uint16_t>(glb.Primitive(p)["indices"].get<size_t>());
    const size_t material = glb.Primitive(p)["material"].get<size_t>();
    EXPECT_EQ(glb.json["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]["index"],
              p);
    EXPECT_TRUE(glb.json["materials"][material]["extensions"].contains("KHR_materials_unlit"));
    for (size_t i = 0; i < indices.size(); i += 3, ++face) {
      for (size_t c = 0; c < 3; ++c) {
        const int v = textured.mesh.faces[face][static_cast<int>(c)];
        EXPECT_EQ(x[indices[i + c]], textured.mesh.vertices[v].cast<float>());
        EXPECT_EQ(
            uv[indices[i + c]],
            Eigen::Vector2f(textured.NormalizedTexcoord(face, static_cast<int>(c)).cast<float>()));
      }
    }
    // The page's file lies in the binary chunk as it is.
    const Json& view = glb.json["bufferViews"][glb.json["images"][p]["bufferView"].get<size_t>()];
    std::ifstream file(textured.pages[p], std::ios::binary);
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(glb.binary.substr(view["byteOffset"].get<size_t>(), view["byteLength"].get<size_t>()),
              page);
  }
  EXPECT_EQ(face, textured.mesh.faces.size());
  EXPECT_FALSE(glb.json["scenes"][0].contains("extras"));
  // Half a turn about x: y and z of COLMAP's camera point down and away.
  const Json& rotation = glb.json["nodes"][0]["rotation"];
  EXPECT_NEAR(std::abs(rotation[0].get<double>()), 1, 1e-12);
  EXPECT_NEAR(rotation[3].get<double>(), 0, 1e-12);
}

// Decoded as the extension says, every face is where it was, to half a step of the grid.
TEST(GlbFile, CompressedFacesAreThoseOfTheMesh) {
  const TemporaryFolder folder;
  AtlasOptions options;
  options.page_width = 300;
  options.page_height = 200;
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.5), BlobColor, folder.path(), options);
  ExportGlb(folder.path() / "plain.glb", textured, {}, {});
  ExportGlb(folder.path() / "m.glb", textured, {}, {}, true);
  const Glb plain(folder.path() / "plain.glb"), glb(folder.path() / "m.glb");
  const auto decoded = [&](size_t accessor) -> std::vector<uint16_t> {
    const Json& a = glb.json["accessors"][accessor];
    const Json& view = glb.json["bufferViews"][a["bufferView"].get<size_t>()];
    EXPECT_EQ(view["buffer"], 1);
    const Json& block = view["extensions"]["EXT_meshopt_compression"];
    EXPECT_EQ(block["buffer"], 0);
    const auto count = block["count"].get<size_t>(), stride = block["byteStride"].get<size_t>();
    EXPECT_EQ(view["byteLength"].get<size_t>(), count * stride);
    std::vector<uint16_t> values(count * stride / 2);
    const auto* bytes = reinterpret_cast<const unsigned char*>(glb.binary.data()) +
                        block["byteOffset"].get<size_t>();
    const auto size = block["byteLength"].get<size_t>();
    const int code = block["mode"] == "TRIANGLES"
                         ? meshopt_decodeIndexBuffer(values.data(), count, stride, bytes, size)
                         : meshopt_decodeVertexBuffer(values.data(), count, stride, bytes, size);
    EXPECT_EQ(code, 0);
    return values;
  };
  // Corners of a face as one sorted text would be: position and texture coordinates, rounded.
  using Corner = std::array<long, 5>;
  using Corners = std::multiset<std::array<Corner, 3>>;
  const auto add_face = [](std::array<Corner, 3> face, Corners* faces) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces->insert(face);
  };
  const Json& node = glb.json["nodes"][0];
  const double step = node["scale"][0].get<double>();
  const Json low = node["translation"];  // turned by half about x, as the rotation
  const Eigen::Vector3d origin(low[0].get<double>(), -low[1].get<double>(), -low[2].get<double>());
  ASSERT_EQ(glb.json["meshes"][0]["primitives"].size(), textured.pages.size());
  for (size_t p = 0; p < textured.pages.size(); ++p) {
    const auto q = decoded(glb.Attribute(p, "POSITION")),
               uv = decoded(glb.Attribute(p, "TEXCOORD_0"));
    const auto indices = decoded(glb.Primitive(p)["indices"].get<size_t>());
    const auto x = plain.Read<Eigen::Vector3f>(plain.Attribute(p, "POSITION"));
    const auto true_uv = plain.Read<Eigen::Vector2f>(plain.Attribute(p, "TEXCOORD_0"));
    const auto true_indices = plain.Read<uint16_t>(plain.Primitive(p)["indices"].get<size_t>());
    ASSERT_EQ(indices.size(), true_indices.size());
    Corners faces, true_faces;
    for (size_t i = 0; i < indices.size(); i += 3) {
      std::array<Corner, 3> face, true_face;
      for (size_t c = 0; c < 3; ++c) {
        const size_t v = indices[i + c], w = true_indices[i + c];
        face[c] = {q[4 * v], q[4 * v + 1], q[4 * v + 2], uv[2 * v], uv[2 * v + 1]};
        const Eigen::Vector3d grid = (x[w].cast<double>() - origin) / step;
        true_face[c] = {std::lround(grid.x()), std::lround(grid.y()), std::lround(grid.z()),
                        std::lround(65535.0 * true_uv[w].x()),
                        std::lround(65535.0 * true_uv[w].y())};
      }
      add_face(face, &faces);
      add_face(true_face, &true_faces);
    }
    EXPECT_EQ(faces, true_faces);
  }
}

TEST(GlbFile, BoundsAreExact) {
  const TemporaryFolder folder;
  TexturedMesh plain;
  plain.mesh = BlobMesh(0.3);
  ExportGlb(folder.path() / "m.glb", plain, {}, {});
  const Glb glb(folder.path() / "m.glb");
  const size_t accessor = glb.Attribute(0, "POSITION");
  Eigen::Vector3f low, high;
  low.setConstant(1e9f);
  high.setConstant(-1e9f);
  for (const Eigen::Vector3f& x : glb.Read<Eigen::Vector3f>(accessor)) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(glb.json["accessors"][accessor]["min"][k].get<double>(), double{low[k]});
    EXPECT_EQ(glb.json["accessors"][accessor]["max"][k].get<double>(), double{high[k]});
  }
}

TEST(GlbFile, VertexColorsAreLinearLight) {
  const TemporaryFolder folder;
  TexturedMesh colored;
  colored.mesh = BlobMesh(0.7);
  for (const Eigen::Vector3d& x : colored.mesh.vertices) {
    colored.mesh.vertex_colors.push_back(BlobColor(x));
  }
  ExportGlb(folder.path() / "m.glb", colored, {}, {});
  const Glb glb(folder.path() / "m.glb");
  const size_t accessor = glb.Attribute(0, "COLOR_0");
  EXPECT_TRUE(glb.json["accessors"][accessor]["normalized"].get<bool>());
  const auto colors = glb.Read<std::array<uint16_t, 4>>(accessor);
  const auto x = glb.Read<Eigen::Vector3f>(glb.Attribute(0, "POSITION"));
  ASSERT_EQ(colors.size(), colored.mesh.vertices.size());
  for (size_t i = 0; i < colors.size(); ++i) {
    EXPECT_EQ(colors[i][3], 65535);
    const Color expected = BlobColor(x[i].cast<double>());
    for (size_t k = 0; k < 3; ++k) {
      const double linear = colors[i][k] / 65535.0;
      const double srgb =
          linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
      EXPECT_NEAR(255 * srgb, expected[static_cast<int>(k)], 1.01);  // the position is rounded
    }
  }
}

TEST(GlbFile, LargeCoordinatesKeepTheirPrecision) {
  const TemporaryFolder folder;
  TexturedMesh far;
  far.mesh = BlobMesh(0.5);
  for (Eigen::Vector3d& x : far.mesh.vertices) x += Eigen::Vector3d(431000.25, 5411000.5, 200);
  ExportGlb(folder.path() / "m.glb", far, {}, {});
  const Glb glb(folder.path() / "m.glb");
  const Json& stored = glb.json["scenes"][0]["extras"]["offset"];
  const Eigen::Vector3d offset(stored[0].get<double>(), stored[1].get<double>(),
                               stored[2].get<double>());
  const auto x = glb.Read<Eigen::Vector3f>(glb.Attribute(0, "POSITION"));
  const auto indices = glb.Read<uint16_t>(glb.Primitive(0)["indices"].get<size_t>());
  for (size_t i = 0; i < indices.size(); ++i) {
    const Eigen::Vector3d& truth =
        far.mesh.vertices[far.mesh.faces[i / 3][static_cast<int>(i % 3)]];
    EXPECT_LT((x[indices[i]].cast<double>() + offset - truth).norm(), 1e-6);
  }
  std::ifstream file(folder.path() / "m.offset.txt");
  Eigen::Vector3d written;
  file >> written[0] >> written[1] >> written[2];
  EXPECT_EQ(written, offset);
}

TEST(GlbFile, ManyVerticesTakeLongIndices) {
  const TemporaryFolder folder;
  GlbModel model;
  model.parts.emplace_back();
  model.parts[0].positions.assign(65536, Eigen::Vector3f::Zero());
  model.parts[0].faces = {{0, 1, 65535}};
  WriteGlb(folder.path() / "m.glb", model);
  const Glb glb(folder.path() / "m.glb");
  const size_t indices = glb.Primitive(0)["indices"].get<size_t>();
  EXPECT_EQ(glb.json["accessors"][indices]["componentType"], 5125);
  EXPECT_EQ(glb.Read<uint32_t>(indices).at(2), 65535u);
}

TEST(GlbFile, WebpNeedsItsExtension) {
  const TemporaryFolder folder;
  const TexturedMesh textured = PaintAtlas(BlobMesh(0.7), BlobColor, folder.path());
  ExportGlb(folder.path() / "m.glb", textured, {}, {TextureFormat::kWebp, 90});
  const Glb glb(folder.path() / "m.glb");
  EXPECT_EQ(glb.json["images"][0]["mimeType"], "image/webp");
  EXPECT_EQ(glb.json["extensionsRequired"], Json::array({"EXT_texture_webp"}));
  EXPECT_EQ(glb.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"], 0);
}

}  // namespace
}  // namespace lsmvs
