#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace lsmvs {

namespace internal {

// First column or row whose centre is not below `coordinate`, within [0, size].
inline int FirstCenterFrom(double coordinate, int size) {
  // The ceiling, by truncation of a number that is not negative.
  const double clamped = std::clamp(coordinate - 0.5, -1.0, static_cast<double>(size));
  const int below = static_cast<int>(clamped + 1.0) - 1;
  return std::max(0, below + (below < clamped));
}

// Swaps the points unless the first lies above, or to the left at the same height. Without
// branches, whose outcome nobody could predict.
inline void SortFromTop(Eigen::Vector2d* a, Eigen::Vector2d* b) {
  const bool swaps = (b->y() < a->y()) | ((b->y() == a->y()) & (b->x() < a->x()));
  const Eigen::Vector2d first = *a, second = *b;
  *a = {swaps ? second.x() : first.x(), swaps ? second.y() : first.y()};
  *b = {swaps ? first.x() : second.x(), swaps ? first.y() : second.y()};
}

// Where an edge crosses horizontal lines; `upper` and `lower` in an order that does not depend on
// the face, so that both faces at the edge compute the same numbers.
struct SpanEdge {
  SpanEdge(const Eigen::Vector2d& upper, const Eigen::Vector2d& lower)
      : start(upper), slope((lower.x() - upper.x()) / (lower.y() - upper.y())) {}
  double At(double y) const { return start.x() + (y - start.y()) * slope; }

  Eigen::Vector2d start;
  double slope;
};

}  // namespace internal

// Calls visit(row, begin, end) for the pixels [begin, end) of each row of a width x height raster
// whose centres lie inside the triangle or on its left or top edge: triangles with a common edge
// neither overlap nor leave a gap. Corners in image coordinates, in either orientation.
template <class Visit>
void ForTriangleSpans(std::array<Eigen::Vector2d, 3> p, int width, int height, const Visit& visit) {
  using internal::FirstCenterFrom;
  // From top to bottom; of equally high ones from left to right.
  internal::SortFromTop(&p[0], &p[1]);
  internal::SortFromTop(&p[1], &p[2]);
  internal::SortFromTop(&p[0], &p[1]);
  const internal::SpanEdge edge_long(p[0], p[2]), edge_upper(p[0], p[1]), edge_lower(p[1], p[2]);
  const int first_row = FirstCenterFrom(p[0].y(), height);
  const int end_row = FirstCenterFrom(p[2].y(), height);
  for (int row = first_row; row < end_row; ++row) {
    const double y = row + 0.5;
    const double x_long = edge_long.At(y);
    const double x_short = y < p[1].y() ? edge_upper.At(y) : edge_lower.At(y);
    visit(row, FirstCenterFrom(std::min(x_long, x_short), width),
          FirstCenterFrom(std::max(x_long, x_short), width));
  }
}

}  // namespace lsmvs
