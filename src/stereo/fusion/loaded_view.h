#pragma once

#include <algorithm>
#include <memory>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"
#include "lsmvs/scene/depth_map.h"
#include "lsmvs/scene/scene.h"

namespace lsmvs {

// A view with its map loaded.
struct LoadedView {
  const View* view = nullptr;
  PinholeCamera camera;  // of the map's size
  std::shared_ptr<const DepthMap> map;
  std::shared_ptr<const ColorImage> colors;
  std::shared_ptr<const ByteImage> mask;

  Color ColorAt(int column, int row) const { return At(column, row, *colors); }
  bool MaskedOut(int column, int row) const {
    return mask != nullptr && At(column, row, *mask) == 0;
  }

 private:
  // The image's pixel that holds the centre of a pixel of the map.
  template <class T>
  const T& At(int column, int row, const Raster<T>& image) const {
    return image(std::min(image.width - 1, (2 * column + 1) * image.width / (2 * camera.width)),
                 std::min(image.height - 1, (2 * row + 1) * image.height / (2 * camera.height)));
  }
};

}  // namespace lsmvs
