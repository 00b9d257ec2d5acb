#include "lsmvs/mesh/simplification/vertex_stars.h"

#include <utility>

namespace lsmvs::internal {

VertexStars::VertexStars(std::vector<Eigen::Vector3d> positions, std::vector<Eigen::Vector3i> faces)
    : positions_(std::move(positions)),
      faces_(std::move(faces)),
      head_(positions_.size(), kNone),
      next_(3 * faces_.size()),
      num_faces_(faces_.size()) {
  // From the back, so that the faces of a vertex come in their order.
  for (size_t c = next_.size(); c-- > 0;) {
    int32_t& head = head_[static_cast<size_t>(faces_[c / 3][static_cast<int>(c % 3)])];
    next_[c] = std::exchange(head, static_cast<int32_t>(c));
  }
}

void VertexStars::Unlink(int32_t v, int32_t face) {
  int32_t* link = &head_[static_cast<size_t>(v)];
  while (*link / 3 != face) link = &next_[static_cast<size_t>(*link)];
  *link = next_[static_cast<size_t>(*link)];
}

void VertexStars::Merge(int32_t keep, int32_t drop, const Eigen::Vector3d& place) {
  positions_[static_cast<size_t>(keep)] = place;
  int32_t* tail = &head_[static_cast<size_t>(drop)];
  while (*tail != kNone) {
    const int32_t f = *tail / 3;
    Eigen::Vector3i& face = faces_[static_cast<size_t>(f)];
    if (!Has(f, keep)) {
      face[*tail % 3] = keep;
      tail = &next_[static_cast<size_t>(*tail)];
      continue;
    }
    *tail = next_[static_cast<size_t>(*tail)];
    for (int k = 0; k < 3; ++k) {
      if (face[k] != drop) Unlink(face[k], f);
    }
    face.setConstant(kNone);
    --num_faces_;
  }
  int32_t& head = head_[static_cast<size_t>(keep)];
  *tail = head;
  head = std::exchange(head_[static_cast<size_t>(drop)], kNone);
}

std::vector<Eigen::Vector3i> VertexStars::Faces() const {
  std::vector<Eigen::Vector3i> left;
  left.reserve(num_faces_);
  for (const Eigen::Vector3i& face : faces_) {
    if (face[0] != kNone) left.push_back(face);
  }
  return left;
}

}  // namespace lsmvs::internal
