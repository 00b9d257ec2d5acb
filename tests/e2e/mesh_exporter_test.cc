#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/util/atomic_file.h"
#include "program_runner.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

Color ColorAt(const Eigen::Vector3d& x) {
  return (127.5 + 100 * (3 * x).array().sin()).matrix().cast<uint8_t>();
}

class MeshExporterProgram : public ::testing::Test {
 protected:
  MeshExporterProgram() {
    const TexturedMesh textured =
        PaintAtlas(Sphere({0, 0, 0}, 1).Mesh(0.3), ColorAt, folder_.path());
    WriteTexturedPly(Path("mesh.ply"), textured);
    TriangleMesh colored = textured.mesh;
    for (const Eigen::Vector3d& x : colored.vertices) colored.vertex_colors.push_back(ColorAt(x));
    WriteMeshPly(Path("colored.ply"), colored);
  }
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  ProgramResult Export(const std::string& input, const std::string& output, const std::string& type,
                       std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {
        "mesh_exporter", "--input_path",  Path(input), "--output_path",
        Path(output),    "--output_type", type};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram("lsmvs", arguments);
  }
  std::string Content(const std::string& name) const {
    std::ifstream file(Path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  TemporaryFolder folder_;
};

TEST_F(MeshExporterProgram, WritesEachType) {
  for (const std::string input : {"mesh", "colored"}) {
    ExpectSuccess(Export(input + ".ply", "out/" + input + ".ply", "PLY"));
    ExpectSuccess(Export(input + ".ply", "out/" + input + ".obj", "OBJ"));
    ExpectSuccess(Export(input + ".ply", "out/" + input + ".glb", "GLB"));
    const ProgramResult tiles =
        Export(input + ".ply", "tiles_" + input, "3DTILES", {"--Tileset.max_tile_faces", "100"});
    ExpectSuccess(tiles);
    EXPECT_THAT(tiles.out, testing::HasSubstr("levels"));
    EXPECT_TRUE(fs::exists(Path("tiles_" + input + "/tileset.json")));
    EXPECT_TRUE(fs::exists(Path("tiles_" + input + "/tiles/r.glb")));
  }
  const TexturedMesh textured = ReadTexturedPly(Path("mesh.ply"));
  const TexturedMesh back = ReadTexturedPly(Path("out/mesh.ply"));
  EXPECT_EQ(back.mesh.faces, textured.mesh.faces);
  EXPECT_EQ(back.texcoords, textured.texcoords);
  EXPECT_EQ(Content("out/mesh_0.png"), Content("page0.png"));
  EXPECT_THAT(Content("out/mesh.mtl"), testing::HasSubstr("map_Kd mesh_0.png"));
}

TEST_F(MeshExporterProgram, PagesInTheSameFolderAreUsedAsTheyAre) {
  ExpectSuccess(Export("mesh.ply", "mesh.obj", "OBJ"));
  EXPECT_THAT(Content("mesh.mtl"), testing::HasSubstr("map_Kd page0.png"));
  EXPECT_FALSE(fs::exists(Path("mesh_0.png")));
}

TEST_F(MeshExporterProgram, NothingIsOverwrittenUnasked) {
  WriteFileAtomically(Path("out/mesh_0.png"), "mine");
  for (const char* type : {"PLY", "OBJ"}) {
    ExpectError(Export("mesh.ply", "out/mesh.x", type), 6, {"out/mesh_0.png", "--overwrite"});
  }
  EXPECT_EQ(Content("out/mesh_0.png"), "mine");
  EXPECT_FALSE(fs::exists(Path("out/mesh.x")));
  ExpectSuccess(Export("mesh.ply", "out/mesh.glb", "GLB"));
  ExpectError(Export("mesh.ply", "out/mesh.glb", "GLB"), 6, {"out/mesh.glb", "--overwrite"});
  ExpectSuccess(Export("mesh.ply", "out/mesh.glb", "GLB", {"--overwrite", "1"}));
  ExpectSuccess(Export("mesh.ply", "t", "3DTILES"));
  ExpectError(Export("mesh.ply", "t", "3DTILES"), 6, {"t/tileset.json", "--overwrite"});
  ExpectSuccess(Export("mesh.ply", "t", "3DTILES", {"--overwrite", "1"}));
}

// A folder "tiles" with files that no export made is never removed.
TEST_F(MeshExporterProgram, ForeignFilesAmongTheTilesStay) {
  ExpectSuccess(Export("mesh.ply", "t", "3DTILES"));
  WriteFileAtomically(Path("t/tiles/notes.txt"), "mine");
  ExpectSuccess(Export("mesh.ply", "t", "3DTILES", {"--overwrite", "1"}));
  EXPECT_EQ(Content("t/tiles/notes.txt"), "mine");
}

TEST_F(MeshExporterProgram, BadInputIsRefused) {
  ExpectError(Export("none.ply", "a.glb", "GLB"), 3, {"none.ply"});
  ExpectError(Export("mesh.ply", "a.stl", "STL"), 2, {"output_type", "STL"});
  fs::create_directory(Path("folder"));
  ExpectError(Export("mesh.ply", "folder", "GLB"), 2, {"folder", "is a folder"});
  ExpectError(Export("mesh.ply", "mesh.ply", "3DTILES"), 2, {"mesh.ply", "is a file"});
  ExpectError(Export("mesh.ply", "mesh.ply", "PLY", {"--overwrite", "1"}), 2, {"the input itself"});
  WriteFileAtomically(Path("cut.ply"), Content("mesh.ply").substr(0, 2000));
  ExpectError(Export("cut.ply", "a.glb", "GLB"), 3, {"cut.ply", "ends too early"});
  TriangleMesh cloud;
  cloud.vertices = {{1, 2, 3}};
  WriteMeshPly(Path("cloud.ply"), cloud);
  for (const char* type : {"PLY", "OBJ", "GLB", "3DTILES"}) {
    ExpectError(Export("cloud.ply", "a.x", type), 3, {"cloud.ply", "has no faces"});
  }
  ExpectError(Export("mesh.ply", "a.glb", "GLB", {"--up", "0,0"}), 2, {"--up '0,0'"});
  ExpectError(Export("mesh.ply", "a.glb", "GLB", {"--origin", "1,2,3"}), 2, {"--origin"});
  for (const char* origin : {"91,0,0", "48", "48,16,x", "48,16,171,2"}) {
    ExpectError(Export("mesh.ply", "a", "3DTILES", {"--origin", origin}), 2, {"--origin", origin});
  }
  ExpectError(Export("mesh.ply", "a", "3DTILES", {"--Tileset.max_tile_faces", "1"}), 2,
              {"max_tile_faces"});
  WriteFileAtomically(Path("page0.png"), "no picture");
  ExpectError(Export("mesh.ply", "a.glb", "GLB"), 3, {"page0.png"});
  fs::remove(Path("page0.png"));
  ExpectError(Export("mesh.ply", "a.glb", "GLB"), 3, {"page0.png is missing"});
  EXPECT_FALSE(fs::exists(Path("a.glb")));
}

}  // namespace
}  // namespace lsmvs
