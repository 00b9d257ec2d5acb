#include "lsmvs/mesh/ply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

TriangleMesh ColoredSphere() {
  TriangleMesh mesh = Sphere({1, 2, 3}, 1.0).Mesh(0.6);
  Random random(1);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    // Numbers that a float holds exactly.
    mesh.vertices[v] = (4096 * mesh.vertices[v]).array().round() / 4096;
    mesh.vertex_quality.push_back(static_cast<float>(v % 8) / 8);
    mesh.vertex_colors.emplace_back(static_cast<uint8_t>(random.Below(256)),
                                    static_cast<uint8_t>(random.Below(256)), 7);
  }
  mesh.vertex_normals = ComputeVertexNormals(mesh);
  return mesh;
}

// Appends the value's bytes, most significant first if `big_endian`.
template <class T>
void Append(T value, bool big_endian, std::string* bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof value);
  if (big_endian) std::reverse(raw, raw + sizeof raw);
  bytes->append(raw, sizeof raw);
}

class PlyTest : public ::testing::Test {
 protected:
  std::filesystem::path Path() const { return folder_.path() / "mesh.ply"; }
  void Write(const std::string& content) const {
    std::ofstream(Path(), std::ios::binary) << content;
  }
  TriangleMesh ReadText(const std::string& content) const {
    Write(content);
    return ReadMeshPly(Path());
  }
  std::string ErrorOf(const std::string& content) const {
    try {
      ReadText(content);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("mesh.ply"), std::string::npos);
      return error.what();
    }
    ADD_FAILURE() << "accepted: " << content.substr(0, 300);
    return "";
  }
  std::string Bytes() const {
    std::ifstream file(Path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  TemporaryFolder folder_;
};

TEST_F(PlyTest, RoundTrip) {
  const TriangleMesh mesh = ColoredSphere();
  WriteMeshPly(Path(), mesh);
  const TriangleMesh back = ReadMeshPly(Path());
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.faces, mesh.faces);
  EXPECT_EQ(back.vertex_colors, mesh.vertex_colors);
  EXPECT_EQ(back.vertex_quality, mesh.vertex_quality);
  EXPECT_EQ(back.vertex_normals, mesh.vertex_normals);
}

TEST_F(PlyTest, WithoutAttributesAndWithoutFaces) {
  TriangleMesh mesh = Sphere({0, 0, 0}, 1.0).Mesh(2);
  WriteMeshPly(Path(), mesh);
  EXPECT_TRUE(ReadMeshPly(Path()).vertex_colors.empty());
  EXPECT_TRUE(ReadMeshPly(Path()).vertex_normals.empty());
  mesh.faces.clear();
  WriteMeshPly(Path(), mesh);
  EXPECT_EQ(ReadMeshPly(Path()).vertices.size(), mesh.vertices.size());
  EXPECT_TRUE(ReadMeshPly(Path()).empty());
  WriteMeshPly(Path(), TriangleMesh());
  EXPECT_TRUE(ReadMeshPly(Path()).vertices.empty());
}

TEST_F(PlyTest, LargeOffsetLosesNothing) {
  const TriangleMesh mesh = ColoredSphere();
  const Eigen::Vector3d offset(431000.0, 5411000.0, 200.0);
  WriteMeshPly(Path(), mesh, offset);
  const TriangleMesh near = ReadMeshPly(Path(), offset);
  const TriangleMesh far = ReadMeshPly(Path());
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_LT((near.vertices[v] - mesh.vertices[v]).norm(), 1e-8);
    EXPECT_LT((far.vertices[v] - offset - mesh.vertices[v]).norm(), 1e-8);
  }
}

// OpenMVS knows faces by the name vertex_indices alone; other programs know both names or read any.
TEST_F(PlyTest, HeaderIsOneThatEveryProgramReads) {
  WriteMeshPly(Path(), Sphere({0, 0, 0}, 1.0).Mesh(2));
  EXPECT_EQ(Bytes().substr(0, Bytes().find("end_header")),
            "ply\nformat binary_little_endian 1.0\nelement vertex 12\nproperty float x\n"
            "property float y\nproperty float z\nelement face 20\n"
            "property list uchar int vertex_indices\n");
}

TEST_F(PlyTest, ReadsFacesOfEitherName) {
  for (const char* name : {"vertex_index", "vertex_indices"}) {
    const TriangleMesh mesh = ReadText(
        std::string("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                    "property float z\nelement face 1\nproperty list uchar int ") +
        name + "\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    EXPECT_EQ(mesh.faces, (std::vector<Eigen::Vector3i>{{0, 1, 2}})) << name;
  }
}

TEST_F(PlyTest, AsciiWithCommentsPolygonsAndWindowsLines) {
  const TriangleMesh mesh = ReadText(
      "ply\r\nformat ascii 1.0\r\ncomment by hand, element vertex 9\r\nobj_info x\r\n"
      "element vertex 5\r\nproperty uchar red\r\nproperty double z\r\nproperty float x\r\n"
      "property float32 y\r\nproperty uint8 green\r\nproperty uchar blue\r\n"
      "element face 2\r\nproperty float quality\r\nproperty list uchar uint vertex_indices\r\n"
      "end_header\r\n"
      "10 0 0 0 20 30\r\n1 0 +1 0 2 3\r\n1 0 1 1 2 3\r\n1 0 0 1e0 2 3\r\n1 2.5 0.5 0.5 2 3\r\n"
      "0.5 4 0 1 2 3\r\n0.25 3 0 1 4");
  ASSERT_EQ(mesh.vertices.size(), 5u);
  EXPECT_EQ(mesh.vertices[4], Eigen::Vector3d(0.5, 0.5, 2.5));
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(1, 1, 0));
  EXPECT_EQ(mesh.vertex_colors[0], (Eigen::Matrix<uint8_t, 3, 1>(10, 20, 30)));
  EXPECT_EQ(mesh.faces, (std::vector<Eigen::Vector3i>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}}));
}

TEST_F(PlyTest, ColorsAreCutToBytes) {
  const TriangleMesh mesh = ReadText(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty float red\nproperty float green\nproperty float blue\n"
      "end_header\n0 0 0 nan 300 -3\n1 0 0 7.9 inf -inf\n");
  ASSERT_EQ(mesh.vertex_colors.size(), 2u);
  EXPECT_EQ(mesh.vertex_colors[0], (Eigen::Matrix<uint8_t, 3, 1>(0, 255, 0)));
  EXPECT_EQ(mesh.vertex_colors[1], (Eigen::Matrix<uint8_t, 3, 1>(7, 255, 0)));
}

TEST_F(PlyTest, BinaryOfEitherByteOrderWithForeignElements) {
  for (const bool big : {false, true}) {
    std::string bytes = "ply\nformat binary_" + std::string(big ? "big" : "little") +
                        "_endian 1.0\n"
                        "element camera 2\nproperty list ushort double params\nproperty int id\n"
                        "element vertex 3\nproperty double x\nproperty short y\nproperty float z\n"
                        "property list uint8 int8 extra\n"
                        "element face 1\nproperty list int ushort vertex_index\nend_header\n";
    for (const int camera : {0, 1}) {
      Append<uint16_t>(2, big, &bytes);
      for (const double d : {1.5, 2.5}) Append(d + camera, big, &bytes);
      Append<int32_t>(camera, big, &bytes);
    }
    for (int v = 0; v < 3; ++v) {
      Append<double>(v + 0.125, big, &bytes);
      Append<int16_t>(static_cast<int16_t>(-v), big, &bytes);
      Append<float>(0.5f, big, &bytes);
      Append<uint8_t>(static_cast<uint8_t>(v), big, &bytes);
      for (int i = 0; i < v; ++i) Append<int8_t>(-1, big, &bytes);
    }
    Append<int32_t>(3, big, &bytes);
    for (const int v : {2, 0, 1}) Append(static_cast<uint16_t>(v), big, &bytes);
    const TriangleMesh mesh = ReadText(bytes);
    ASSERT_EQ(mesh.vertices.size(), 3u);
    EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(2.125, -2, 0.5));
    EXPECT_EQ(mesh.faces, (std::vector<Eigen::Vector3i>{{2, 0, 1}}));
    // Every truncation is found, and nothing else happens.
    for (size_t length = 0; length < bytes.size(); ++length) ErrorOf(bytes.substr(0, length));
  }
}

TEST_F(PlyTest, FacesMayComeBeforeVertices) {
  const TriangleMesh mesh = ReadText(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
      "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n");
  EXPECT_EQ(mesh.faces.size(), 1u);
}

constexpr const char* kVertexHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\n";

TEST_F(PlyTest, BadHeadersAreRefused) {
  const std::string tail = "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NO_THROW(ReadText(kVertexHeader + tail));
  const auto with = [&](const std::string& line) { return kVertexHeader + line + "\n" + tail; };
  ErrorOf("");
  ErrorOf("plyx\n");
  ErrorOf("ply\nend_header\n");
  ErrorOf("ply\nformat binary_middle_endian 1.0\nend_header\n");
  ErrorOf("ply\nformat ascii 1.0\nproperty float x\nend_header\n");
  ErrorOf(with("property quaternion q"));
  ErrorOf(with("property list uchar"));
  ErrorOf(with("property list uchar int indices extra"));
  ErrorOf(with("element face"));
  ErrorOf(with("element face -1"));
  ErrorOf(with("element face 1e3"));
  ErrorOf(with("element face 99999999999999999999999"));
  ErrorOf(with("nonsense"));
  ErrorOf("ply\nformat ascii 1.0\nelement point 1\nproperty float x\nend_header\n1\n");
  ErrorOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n");
  ErrorOf("ply\n" + std::string(3 << 20, 'c'));
}

TEST_F(PlyTest, CountsThatTheFileCannotHoldEndQuickly) {
  const std::string tail = "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  ErrorOf(kVertexHeader +
          std::string("element face 18446744073709551615\n"
                      "property list uchar int vertex_index\n") +
          tail);
  // Rows without properties take no bytes: any count of them could be claimed.
  ErrorOf(kVertexHeader + std::string("element nothing 18446744073709551615\n") + tail);
}

TEST_F(PlyTest, BadBodiesAreRefused) {
  const auto vertices = [](const std::string& rows) {
    return kVertexHeader + std::string("end_header\n") + rows;
  };
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1\n"));
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1 x\n"));
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1 nan\n"));
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1 inf\n"));
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1 0x10\n"));
  ErrorOf(vertices("0 0 0\n1 0 0\n0 1 0." + std::string(100, '3') + "\n0 0\n"));
  const auto face = [](const std::string& row) {
    return kVertexHeader +
           std::string("element face 1\nproperty list char float vertex_index\nend_header\n") +
           "0 0 0\n1 0 0\n0 1 0\n" + row + "\n";
  };
  EXPECT_NO_THROW(ReadText(face("3 0 1 2")));
  EXPECT_NE(ErrorOf(face("3 0 1 3")).find("names vertex 3, but there are 3"), std::string::npos);
  ErrorOf(face("3 0 1 -1"));
  ErrorOf(face("3 0 1 nan"));
  ErrorOf(face("3 0 1 1e30"));
  ErrorOf(face("-3 0 1 2"));
  ErrorOf(face("nan 0 1 2"));
  ErrorOf(face("100000000 0 1 2"));
  ErrorOf(kVertexHeader + std::string("element face 1\nproperty int material\nend_header\n"
                                      "0 0 0\n1 0 0\n0 1 0\n4\n"));
}

TEST_F(PlyTest, BrokenBytesNeverCrash) {
  WriteMeshPly(Path(), ColoredSphere());
  const std::string whole = Bytes();
  Random random(2);
  int num_refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string broken = whole;
    for (int k = 0; k < 3; ++k) {
      broken[random.Below(i % 2 == 0 ? 250 : broken.size())] = static_cast<char>(random.Bits());
    }
    Write(broken);
    try {
      ReadMeshPly(Path());
    } catch (const InputError&) {
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 180);
}

TEST_F(PlyTest, MissingFileAndFolder) {
  EXPECT_THROW(ReadMeshPly(folder_.path() / "none.ply"), InputError);
  EXPECT_THROW(ReadMeshPly(folder_.path()), InputError);
}

}  // namespace
}  // namespace lsmvs
