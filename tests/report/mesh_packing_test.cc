#include "lsmvs/report/page/mesh_packing.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <random>

namespace lsmvs {
namespace {

std::vector<uint8_t> Inflated(const std::vector<uint8_t>& packed, size_t size) {
  std::vector<uint8_t> bytes(size + 16);
  uLongf length = bytes.size();
  EXPECT_EQ(uncompress(bytes.data(), &length, packed.data(), packed.size()), Z_OK);
  bytes.resize(length);
  return bytes;
}

// The other side of the format, the plain way. `texcoords`: u of all corners, then v, as stored.
TriangleMesh Unpacked(const PackedMesh& packed, std::vector<uint8_t>* errors,
                      std::vector<uint16_t>* texcoords = nullptr) {
  const size_t n = packed.num_vertices;
  const std::vector<uint8_t> bytes = Inflated(packed.bytes, 13 * n + 27 * packed.num_faces);
  TriangleMesh mesh;
  mesh.vertices.resize(n);
  size_t offset = 0;
  for (int axis = 0; axis < 3; ++axis, offset += 3 * n) {
    uint32_t value = 0;
    for (size_t v = 0; v < n; ++v) {
      value += bytes[offset + v] | bytes[offset + n + v] << 8 | bytes[offset + 2 * n + v] << 16;
      mesh.vertices[v][axis] = packed.origin[axis] + (value & 0xffffff) * packed.step;
    }
  }
  const auto plane = [&](const auto& set) {
    uint8_t value = 0;
    for (size_t v = 0; v < n; ++v) set(v, value = static_cast<uint8_t>(value + bytes[offset + v]));
    offset += n;
  };
  mesh.vertex_colors.resize(packed.has_colors ? n : 0);
  for (int k = 0; packed.has_colors && k < 3; ++k) {
    plane([&](size_t v, uint8_t value) { mesh.vertex_colors[v][k] = value; });
  }
  errors->resize(packed.has_errors ? n : 0);
  if (packed.has_errors) plane([&](size_t v, uint8_t value) { (*errors)[v] = value; });
  int last = 0;
  for (size_t f = 0; f < packed.num_faces; ++f) {
    mesh.faces.emplace_back();
    for (int k = 0; k < 3; ++k) {
      uint32_t code = 0;
      int shift = 0;
      do code |= static_cast<uint32_t>(bytes[offset] & 127) << shift, shift += 7;
      while (bytes[offset++] & 128);
      last += static_cast<int>(code >> 1) ^ -static_cast<int>(code & 1);
      mesh.faces.back()[k] = last;
    }
  }
  for (int axis = 0; packed.has_texture && axis < 2; ++axis) {
    const size_t count = 3 * packed.num_faces;
    uint16_t value = 0;
    for (size_t i = 0; i < count; ++i) {
      value = static_cast<uint16_t>(value + bytes[offset + i] + 256 * bytes[offset + count + i]);
      texcoords->push_back(value);
    }
    offset += 2 * count;
  }
  EXPECT_EQ(offset, bytes.size());
  return mesh;
}

TEST(MeshPacking, RoundTrip) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-100, 300);
  TriangleMesh mesh;
  std::vector<float> errors;
  for (int v = 0; v < 700; ++v) {
    mesh.vertices.emplace_back(uniform(random), uniform(random), uniform(random));
    mesh.vertex_colors.emplace_back(v % 256, v / 3 % 256, 255 - v % 256);
    errors.push_back(static_cast<float>(v) / 699);
  }
  errors[3] = std::numeric_limits<float>::quiet_NaN();
  for (int f = 0; f < 900; ++f) mesh.faces.emplace_back(random() % 700, random() % 700, f % 700);
  const PackedMesh packed = PackMesh(mesh, errors);
  std::vector<uint8_t> error_bytes;
  const TriangleMesh back = Unpacked(packed, &error_bytes);
  EXPECT_EQ(back.faces, mesh.faces);
  EXPECT_EQ(back.vertex_colors, mesh.vertex_colors);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_LT((back.vertices[v] - mesh.vertices[v]).cwiseAbs().maxCoeff(), packed.step);
    if (v == 3) continue;
    EXPECT_NEAR(error_bytes[v] / 254.0, errors[v], 0.003);
  }
  EXPECT_EQ(error_bytes[3], 255);
  EXPECT_LT(packed.step, 400.0 / (1 << 23));
}

TEST(MeshPacking, TextureCoordinates) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}};
  const std::vector<std::array<Eigen::Vector2f, 3>> texcoords = {
      {Eigen::Vector2f(0, 0), Eigen::Vector2f(200, 0), Eigen::Vector2f(0, 100)},
      {Eigen::Vector2f(150, 25), Eigen::Vector2f(50, 75), Eigen::Vector2f(0.5f, 99.5f)}};
  const PackedMesh packed = PackMesh(mesh, {}, texcoords, {200, 100});
  EXPECT_TRUE(packed.has_texture);
  std::vector<uint8_t> errors;
  std::vector<uint16_t> stored;
  EXPECT_EQ(Unpacked(packed, &errors, &stored).faces, mesh.faces);
  ASSERT_EQ(stored.size(), 12u);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(stored[i] / 65535.0 * 200, texcoords[i / 3][i % 3].x(), 0.002);
    EXPECT_NEAR(stored[6 + i] / 65535.0 * 100, texcoords[i / 3][i % 3].y(), 0.001);
  }
}

TEST(MeshPacking, EmptyAndFlatMeshes) {
  std::vector<uint8_t> errors;
  EXPECT_TRUE(Unpacked(PackMesh({}, {}), &errors).vertices.empty());
  TriangleMesh point;
  point.vertices.assign(3, Eigen::Vector3d(1, 2, 3));
  point.faces.emplace_back(0, 1, 2);
  EXPECT_EQ(Unpacked(PackMesh(point, {}), &errors).vertices[2], Eigen::Vector3d(1, 2, 3));
}

TEST(Base64, TheVectorsOfTheRfc) {
  const auto encode = [](const std::string& text) { return Base64({text.begin(), text.end()}); };
  EXPECT_EQ(encode(""), "");
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foo"), "Zm9v");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace lsmvs
