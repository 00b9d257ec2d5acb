#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/image/image_store.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/test_evaluation/test_meshes.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/texturing/mesh_texturer.h"

namespace lsmvs::test {

// The rectangle [0, 2] x [0, 1.5] at z = 0, photographed from above; what a photo shows at a point
// of the plane is given as a function.
class PlaneScene {
 public:
  using Paint = std::function<Eigen::Vector3d(double x, double y)>;  // grey levels

  // A photo of 200 x 160 from `center`, straight down.
  void AddPhoto(const Eigen::Vector3d& center, const Paint& paint, double focal = 200) {
    View view = DownwardView(center, 200, 160, focal);
    view.name = std::to_string(scene.views.size()) + ".png";
    view.image_id = ImageId(static_cast<uint32_t>(scene.views.size() + 1));
    ColorImage photo(view.camera.width, view.camera.height);
    for (int row = 0; row < photo.height; ++row) {
      for (int column = 0; column < photo.width; ++column) {
        const Eigen::Vector3d ray =
            view.cam_from_world.rotation.transpose() * view.camera.PixelRay(column, row);
        const Eigen::Vector3d x = center - center.z() / ray.z() * ray;
        photo(column, row) =
            paint(x.x(), x.y()).array().round().max(0.0).min(255.0).cast<uint8_t>().matrix();
      }
    }
    WritePng(folder_.path() / view.name, photo);
    scene.image_folder = folder_.path().string();
    scene.views.push_back(view);
    photos.push_back(std::move(photo));
  }

  // Pages are kept in `pages`.
  TexturingResult Texture(const TriangleMesh& mesh, const MeshTexturerOptions& options = {},
                          int num_threads = 2, size_t image_budget = size_t{1} << 30) {
    ImageStoreOptions store;
    store.budget_bytes = image_budget;
    const auto images = MakeImageStore(scene, store);
    pages.clear();
    return TextureMesh(
        scene, *images, mesh, "mesh.ply", options,
        [&](int page_idx, ColorImage&& page) {
          pages.push_back(std::move(page));
          return std::filesystem::path(std::to_string(page_idx) + ".png");
        },
        RunContext(num_threads));
  }

  Scene scene;
  std::vector<ColorImage> photos, pages;

 private:
  TemporaryFolder folder_;
};

// A pattern with structure of some pixels.
inline Eigen::Vector3d Pattern(double x, double y) {
  return {120 + 50 * std::sin(31 * x + 3 * y), 120 + 40 * std::sin(9 * x - 23 * y),
          110 + 60 * std::cos(17 * x * y + 5 * x)};
}

// Calls visit(face, x, y, page, column, row) for the texels whose centres lie inside a face, with
// the point of the plane that the texel shows.
template <class Visit>
void ForTexelsInFaces(const TexturedMesh& textured, const Visit& visit) {
  for (size_t f = 0; f < textured.mesh.faces.size(); ++f) {
    const auto& uv = textured.texcoords[f];
    Eigen::Matrix2d edges;
    edges << (uv[1] - uv[0]).cast<double>(), (uv[2] - uv[0]).cast<double>();
    Eigen::Vector2f low = uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]);
    Eigen::Vector2f high = uv[0].cwiseMax(uv[1]).cwiseMax(uv[2]);
    for (int row = static_cast<int>(low.y()); row <= static_cast<int>(high.y()); ++row) {
      for (int column = static_cast<int>(low.x()); column <= static_cast<int>(high.x()); ++column) {
        const Eigen::Vector2d b = edges.inverse() * (Eigen::Vector2d(column + 0.5, row + 0.5) -
                                                     uv[0].template cast<double>());
        constexpr double kInside = 1e-6;
        if (b.x() < kInside || b.y() < kInside || b.sum() > 1 - kInside) continue;
        const Eigen::Vector3i& face = textured.mesh.faces[f];
        const Eigen::Vector3d x =
            textured.mesh.vertices[face[0]] +
            b.x() * (textured.mesh.vertices[face[1]] - textured.mesh.vertices[face[0]]) +
            b.y() * (textured.mesh.vertices[face[2]] - textured.mesh.vertices[face[0]]);
        visit(f, x.x(), x.y(), textured.page_idx[f], column, row);
      }
    }
  }
}

}  // namespace lsmvs::test
