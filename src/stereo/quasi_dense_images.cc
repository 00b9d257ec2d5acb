#include "lsmvs/stereo/quasi_dense_images_internal.h"

namespace lsmvs::quasi_dense {

std::shared_ptr<const CellImage> CellImages::Get(int view_idx, int level) {
  const Key key{view_idx, level};
  const auto found = entries_.find(key);
  if (found != entries_.end()) {
    order_.splice(order_.begin(), order_, found->second.place);
    return found->second.image;
  }
  auto image = std::make_shared<const CellImage>(*images_.Gray(view_idx, level));
  order_.push_front(key);
  entries_[key] = {image, order_.begin()};
  held_bytes_ += image->bytes();
  while (held_bytes_ > budget_bytes_ && order_.size() > 1) {
    const auto oldest = entries_.find(order_.back());
    held_bytes_ -= oldest->second.image->bytes();
    entries_.erase(oldest);
    order_.pop_back();
  }
  return image;
}

}  // namespace lsmvs::quasi_dense
