#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/colmap_adapter/files/visibility_file.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/scene/visibility_cloud.h"

namespace lsmvs::internal {

// A guess of what the indices of a .vis file mean: view_idxs[image_idx] is a view.
struct ImageOrder {
  std::string name;  // for messages: "the order of image ids"
  std::vector<uint32_t> view_idxs;
};

// The views in the order of the scene.
ImageOrder SceneOrder(const Scene& scene);
// Other orders that versions of COLMAP wrote, without those that equal the scene's: of images.bin,
// of image ids, of names.
std::vector<ImageOrder> OtherOrders(const Scene& scene, const std::filesystem::path& sparse_folder);

// How well points from `first_point` on fit the views that an order gives them, each in [0, 1],
// over a fixed sample of points.
struct OrderFit {
  double inside = 0;  // projected into the image, in front of the camera
  double facing = 0;  // normal turned towards the camera (1 if there are no normals)

  double Total() const { return inside + facing; }
};
OrderFit MeasureFit(const Scene& scene, const VisibilityCloud& points, const VisibilityFile& file,
                    size_t first_point, const ImageOrder& order);

}  // namespace lsmvs::internal
