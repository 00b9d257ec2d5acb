// Makes a painted mesh for the tests of readers: make_textured_mesh FOLDER EDGE_LENGTH PAGE_PX
// CHART_PX writes FOLDER/mesh.ply with its pages and FOLDER/colored.ply, the same mesh with vertex
// colours.
#include <cstdlib>
#include <filesystem>

#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/synthetic/textured_atlas.h"

int main(int argc, char** argv) {
  using namespace lsmvs;
  if (argc != 5) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  TriangleMesh mesh = BlobMesh(std::atof(argv[2]));
  AtlasOptions options;
  options.page_width = options.page_height = std::atoi(argv[3]);
  options.chart_px = std::atoi(argv[4]);
  WriteTexturedPly(folder / "mesh.ply", PaintAtlas(mesh, BlobColor, folder, options));
  for (const Eigen::Vector3d& x : mesh.vertices) mesh.vertex_colors.push_back(BlobColor(x));
  WriteMeshPly(folder / "colored.ply", mesh);
}
