#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

// Reads the pages of a textured mesh when they are wanted and forgets the one unused for longest
// when they would take more than a budget (the page in use is always held). Thread-safe.
class TexturePages {
 public:
  // `textured` outlives this.
  TexturePages(const TexturedMesh& textured, size_t budget_bytes);

  // Throws InputError if the file is gone or broken. The page stays valid while it is held.
  std::shared_ptr<const ColorImage> Page(size_t page) const;

  // Colour (grey levels in [0, 255]) of a point of a face, by bilinear interpolation.
  // `barycentric` are the weights of the face's second and third corner.
  Eigen::Vector3f Sample(size_t face, const Eigen::Vector2f& barycentric) const;
  // Texture coordinates of the point in pixels of the page's file.
  Eigen::Vector2f FilePixel(size_t face, const Eigen::Vector2f& barycentric,
                            const ColorImage& page) const;

  const TexturedMesh& textured() const { return textured_; }

 private:
  struct Entry {
    std::shared_ptr<const ColorImage> image;
    uint64_t last_use = 0;
  };
  void Evict(size_t kept) const;

  const TexturedMesh& textured_;
  const size_t budget_bytes_;
  mutable std::mutex mutex_;
  mutable std::vector<Entry> entries_;
  mutable uint64_t clock_ = 0;
  mutable size_t held_bytes_ = 0;
};

// Bilinear interpolation at image coordinates (centre of the first texel at (0.5, 0.5)), clamped at
// the image's edge as viewers do.
Eigen::Vector3f SampleColor(const ColorImage& image, const Eigen::Vector2f& x_px);

}  // namespace lsmvs
