#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/textured_mesh.h"
#include "lsmvs/util/unnamed_file.h"

namespace lsmvs {

// Decodes the pages of a textured mesh when they are wanted, each once. Those unused for longest
// are put aside in a file without a name when pages would take more than a budget (the page in use
// is always held). Thread-safe.
class TexturePages {
 public:
  // `textured` outlives this. The file lies in the folder that TMPDIR says, else in /tmp; where it
  // finds no room, pages are decoded again.
  TexturePages(const TexturedMesh& textured, size_t budget_bytes);

  // Throws InputError if the file is gone or broken. The page stays valid while it is held.
  std::shared_ptr<const ColorImage> Page(size_t page) const;
  // Width and height of the page's file [px].
  Eigen::Vector2i PageSize(size_t page) const;
  // Copies a block of a page to `target` in `out`. Of a page that was put aside, only the block is
  // read.
  void CopyBlock(size_t page, const Eigen::Vector2i& corner, const Eigen::Vector2i& size,
                 const Eigen::Vector2i& target, ColorImage* out) const;

  // Times that a page was decoded.
  size_t num_decoded() const { return num_decoded_; }

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
    Eigen::Vector2i size = Eigen::Vector2i::Zero();  // known after the first use
    std::optional<uint64_t> offset;                  // where it was put aside
  };
  std::shared_ptr<const ColorImage> Hold(size_t page) const;  // needs the lock
  ColorImage Load(const Entry& entry, size_t page) const;
  void Evict(size_t kept) const;
  void PutAside(Entry* entry) const;

  const TexturedMesh& textured_;
  const size_t budget_bytes_;
  mutable std::mutex mutex_;
  mutable std::vector<Entry> entries_;
  mutable uint64_t clock_ = 0;
  mutable size_t held_bytes_ = 0, num_decoded_ = 0;
  mutable std::unique_ptr<UnnamedFile> file_;  // from the first page on that has no room
  mutable uint64_t file_end_ = 0;
  mutable bool has_no_room_ = false;  // on the disk
};

// Bilinear interpolation at image coordinates (centre of the first texel at (0.5, 0.5)), clamped at
// the image's edge as viewers do.
Eigen::Vector3f SampleColor(const ColorImage& image, const Eigen::Vector2f& x_px);

}  // namespace lsmvs
