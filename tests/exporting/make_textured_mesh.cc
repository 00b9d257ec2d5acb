// Makes a painted mesh for the tests of readers: make_textured_mesh FOLDER EDGE_LENGTH PAGE_PX
// CHART_PX writes FOLDER/mesh.ply with its pages, FOLDER/colored.ply, the same mesh with vertex
// colours, and how our renderer draws both from one pose: mesh.png, colored.png, camera.json. The
// background is pure green, which the mesh is nowhere.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "lsmvs/evaluation/mesh_renderer.h"
#include "lsmvs/exporting_test/textured_blob.h"
#include "lsmvs/image/image_codec.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/synthetic/textured_atlas.h"
#include "lsmvs/util/atomic_file.h"

namespace lsmvs {
namespace {

PosedCamera TestViewpoint() {
  PosedCamera viewpoint;
  viewpoint.camera = {800, 600, 900, 900, 400, 300};
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()))
                                       .toRotationMatrix();
  viewpoint.cam_from_world = Rigid3(rotation, Eigen::Vector3d(0.05, -0.1, 4.6));
  return viewpoint;
}

void Draw(const std::filesystem::path& path, const TriangleMesh& mesh,
          const TexturePages* texture) {
  const RunContext context(2);
  const MeshTracer tracer(mesh, context);
  const PosedCamera viewpoint = TestViewpoint();
  RenderOptions options;
  options.style = RenderStyle::kColor;
  options.antialiasing = 1;
  ColorImage image = RenderMesh(mesh, tracer, viewpoint, options, context, texture);
  const Raster<float> depth =
      TraceDepth(tracer, viewpoint.camera, viewpoint.cam_from_world, context);
  for (size_t i = 0; i < image.size(); ++i) {
    if (!(depth.pixels[i] > 0)) image.pixels[i] = Color(0, 255, 0);
  }
  WritePng(path, image);
}

void WriteCamera(const std::filesystem::path& path) {
  const PosedCamera viewpoint = TestViewpoint();
  std::string rotation;
  for (int i = 0; i < 9; ++i) {
    rotation +=
        fmt::format("{}{:.17g}", i ? "," : "", viewpoint.cam_from_world.rotation(i / 3, i % 3));
  }
  const Eigen::Vector3d& t = viewpoint.cam_from_world.translation;
  WriteFileAtomically(
      path, fmt::format("{{\"width\":{},\"height\":{},\"focal\":{},\"rotation\":[{}],"
                        "\"translation\":[{},{},{}]}}\n",
                        viewpoint.camera.width, viewpoint.camera.height, viewpoint.camera.fx,
                        rotation, t[0], t[1], t[2]));
}

}  // namespace
}  // namespace lsmvs

int main(int argc, char** argv) {
  using namespace lsmvs;
  if (argc != 5) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  TriangleMesh mesh = BlobMesh(std::atof(argv[2]));
  AtlasOptions options;
  options.page_width = options.page_height = std::atoi(argv[3]);
  options.chart_px = std::atoi(argv[4]);
  const TexturedMesh textured = PaintAtlas(mesh, BlobColor, folder, options);
  WriteTexturedPly(folder / "mesh.ply", textured);
  const TexturePages pages(textured, size_t{1} << 30);
  Draw(folder / "mesh.png", mesh, &pages);
  for (const Eigen::Vector3d& x : mesh.vertices) mesh.vertex_colors.push_back(BlobColor(x));
  WriteMeshPly(folder / "colored.ply", mesh);
  Draw(folder / "colored.png", mesh, nullptr);
  WriteCamera(folder / "camera.json");
}
