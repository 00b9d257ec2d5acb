#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "lsmvs/geometry/camera.h"
#include "lsmvs/image/raster.h"

namespace lsmvs {

// Where the pixels of one view come from.
struct ImageSource {
  std::string path;
  std::string
      mask_path;  // empty: no mask. An image of the same size whose pixels of value 0 are ignored
  PinholeCamera camera;  // of the full-size image; the file must have this size
  // Pixels with an alpha of 0 are ignored, too, where the image has an alpha channel that is not 0
  // everywhere.
  bool alpha_is_mask = false;
  // There is no file: the image is black, and all of it is masked.
  bool is_missing = false;
};

struct ImageStoreOptions {
  // Longer side of level 0 in pixels; images that are larger are reduced. 0: full size.
  int max_image_size = 0;
  // Bytes that decoded images may hold; the least recently used are dropped. Images in use are not
  // counted out: a caller keeps as many as it holds pointers to.
  size_t budget_bytes = size_t{1} << 30;
};

// Decodes images when they are needed and keeps what fits the budget. Level l is level 0 reduced by
// 2^l (area averaged), for l >= 0. Thread-safe; two threads that ask for the same image at once
// decode it once. Colours are decoded as stored; grey = 0.299 R + 0.587 G + 0.114 B, in [0, 255], 4
// bytes per pixel. Images of 16 bits or of floats keep their precision in grey; what is 255 there
// is the same for all images of the store: the least 2^n - 1 (n >= 8) that none exceeds for 16
// bits, 1 or the largest value for floats; 0 stays 0, unless all values lie within an eighth of
// that range (thermal cameras), which is stretched then. To find it, all such images are decoded
// once. Throws InputError if a file is missing, cannot be decoded or has another size than its
// camera.
class ImageStore {
 public:
  ImageStore(std::vector<ImageSource> sources, const ImageStoreOptions& options);
  ~ImageStore();
  ImageStore(const ImageStore&) = delete;
  ImageStore& operator=(const ImageStore&) = delete;

  size_t num_views() const { return sources_.size(); }
  const ImageSource& source(int view_idx) const { return sources_[static_cast<size_t>(view_idx)]; }

  // Camera of the image at a level: its size is the size of Gray(), Colors() and Mask() there.
  PinholeCamera Camera(int view_idx, int level) const;

  std::shared_ptr<const GrayImage> Gray(int view_idx, int level) const;
  std::shared_ptr<const ColorImage> Colors(int view_idx, int level) const;
  // Null if the view has no mask and no transparent pixel. A reduced pixel is used only if all its
  // pixels are.
  std::shared_ptr<const ByteImage> Mask(int view_idx, int level) const;

  // Lets go of decoded images, the longest unused first, until `max_bytes` at most are held: what a
  // phase needs at a time, or 0 between phases that need others. What is asked for again is decoded
  // again.
  void Trim(size_t max_bytes) const;

  // Takes the place of ImageStoreOptions::budget_bytes: for a stage that may hold less.
  void SetBudget(size_t budget_bytes) const;

  // Bytes of the decoded images that the store holds at present.
  size_t HeldBytes() const;

 private:
  struct Cache;

  // Of images of more than 8 bits: the values that become 0 and 255.
  struct DeepRange {
    double black = 0, white = 255;
  };
  DeepRange FindDeepRange() const;

  std::vector<ImageSource> sources_;
  ImageStoreOptions options_;
  std::unique_ptr<Cache> cache_;
};

// Width and height that a file's header declares, without decoding the pixels where the format
// allows. Throws InputError.
Eigen::Vector2i ReadImageSize(const std::string& path);

// Whether the file has an alpha channel; of formats without a readable header: false. Throws
// InputError.
bool HasAlpha(const std::string& path);

// Used pixels (255) of an image with alpha: those whose alpha is not 0; all of them if alpha is 0
// everywhere or there is none. Throws InputError.
ByteImage ReadAlphaMask(const std::string& path);
// Used pixels (255) of a mask file: those that are not 0. Throws InputError.
ByteImage ReadMask(const std::string& path);

}  // namespace lsmvs
