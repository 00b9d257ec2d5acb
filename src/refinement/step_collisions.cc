#include "lsmvs/refinement/step_collisions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lsmvs {

namespace {

constexpr size_t kItemsPerBlock = 1 << 14;
constexpr double kCellEdges = 2.0;
// A face that touches more cells than this along an axis is entered in these many, so that one huge
// face does not fill the grid; it then meets others only there.
constexpr int64_t kMaxCellsAlongAxis = 64;
constexpr int kBitsPerAxis = 21;
// Each pass takes back a ring more.
constexpr int kMaxPasses = 30;

double Orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool EdgeCrosses(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  if (Orientation(a, b, c, p) * Orientation(a, b, c, q) >= 0) return false;
  const double ab = Orientation(p, q, a, b), bc = Orientation(p, q, b, c);
  if (ab * bc <= 0) return false;
  return ab * Orientation(p, q, c, a) > 0;
}

bool OnOneSide(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& plane,
               const Eigen::Vector3i& face) {
  const Eigen::Vector3d& a = vertices[static_cast<size_t>(plane[0])];
  const Eigen::Vector3d normal = (vertices[static_cast<size_t>(plane[1])] - a)
                                     .cross(vertices[static_cast<size_t>(plane[2])] - a);
  int num_above = 0, num_below = 0;
  for (const int v : face) {
    const double height = normal.dot(vertices[static_cast<size_t>(v)] - a);
    num_above += height > 0;
    num_below += height < 0;
  }
  return num_above == 0 || num_below == 0;
}

int NumShared(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  int count = 0;
  for (const int v : a) count += v == b[0] || v == b[1] || v == b[2];
  return count;
}

Eigen::AlignedBox3d Box(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& face) {
  Eigen::AlignedBox3d box;
  for (const int v : face) box.extend(vertices[static_cast<size_t>(v)]);
  return box;
}

double MeanEdge(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces) {
  double sum = 0;
  for (const Eigen::Vector3i& f : faces) {
    sum += (vertices[static_cast<size_t>(f[1])] - vertices[static_cast<size_t>(f[0])]).norm();
  }
  return faces.empty() ? 1.0 : sum / static_cast<double>(faces.size());
}

}  // namespace

bool FacesCross(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& a,
                const Eigen::Vector3i& b) {
  if (OnOneSide(vertices, a, b) || OnOneSide(vertices, b, a)) return false;
  const auto at = [&](const Eigen::Vector3i& face, int k) -> const Eigen::Vector3d& {
    return vertices[static_cast<size_t>(face[k % 3])];
  };
  for (int k = 0; k < 3; ++k) {
    if (EdgeCrosses(at(a, k), at(a, k + 1), at(b, 0), at(b, 1), at(b, 2))) return true;
    if (EdgeCrosses(at(b, k), at(b, k + 1), at(a, 0), at(a, 1), at(a, 2))) return true;
  }
  return false;
}

FaceGrid::FaceGrid(std::span<const Eigen::Vector3d> vertices,
                   std::span<const Eigen::Vector3i> faces)
    : vertices_(vertices), faces_(faces) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& x : vertices) bounds.extend(x);
  if (faces.empty()) return;
  // So large that a cell's numbers fit their bits.
  const double largest = bounds.sizes().maxCoeff() / static_cast<double>((1 << kBitsPerAxis) - 2);
  const double cell_size = std::max(kCellEdges * MeanEdge(vertices, faces), largest);
  if (!(cell_size > 0) || !std::isfinite(cell_size)) return;
  items_.reserve(6 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    AddFace(static_cast<int32_t>(f), cell_size, bounds.min());
  }
  std::sort(items_.begin(), items_.end(), [](const Item& a, const Item& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.face < b.face;
  });
}

void FaceGrid::AddFace(int32_t face, double cell_size, const Eigen::Vector3d& origin) {
  const Eigen::AlignedBox3d box = Box(vertices_, faces_[static_cast<size_t>(face)]);
  const Eigen::Array<int64_t, 3, 1> low =
      ((box.min() - origin) / cell_size).array().cast<int64_t>();
  Eigen::Array<int64_t, 3, 1> high = ((box.max() - origin) / cell_size).array().cast<int64_t>();
  high = high.min(low + kMaxCellsAlongAxis - 1);
  for (int64_t z = low[2]; z <= high[2]; ++z) {
    for (int64_t y = low[1]; y <= high[1]; ++y) {
      for (int64_t x = low[0]; x <= high[0]; ++x) {
        const uint64_t cell = static_cast<uint64_t>(x) | static_cast<uint64_t>(y) << kBitsPerAxis |
                              static_cast<uint64_t>(z) << 2 * kBitsPerAxis;
        items_.push_back({cell, face});
      }
    }
  }
}

std::vector<std::pair<int32_t, int32_t>> FaceGrid::CrossingPairs(const std::vector<uint8_t>& moved,
                                                                 const RunContext& context) const {
  const size_t num_blocks = (items_.size() + kItemsPerBlock - 1) / kItemsPerBlock;
  std::vector<std::vector<std::pair<int32_t, int32_t>>> found(num_blocks);
  ParallelFor(context, items_.size(), kItemsPerBlock, [&](size_t i) {
    const int32_t a = items_[i].face;
    const Eigen::Vector3i& face_a = faces_[static_cast<size_t>(a)];
    const Eigen::AlignedBox3d box = Box(vertices_, face_a);
    for (size_t k = i + 1; k < items_.size() && items_[k].cell == items_[i].cell; ++k) {
      const int32_t b = items_[k].face;
      if (!moved[static_cast<size_t>(a)] && !moved[static_cast<size_t>(b)]) continue;
      const Eigen::Vector3i& face_b = faces_[static_cast<size_t>(b)];
      if (NumShared(face_a, face_b) > 1 || !box.intersects(Box(vertices_, face_b))) continue;
      if (FacesCross(vertices_, face_a, face_b)) found[i / kItemsPerBlock].emplace_back(a, b);
    }
  });
  std::vector<std::pair<int32_t, int32_t>> pairs;
  for (const auto& block : found) pairs.insert(pairs.end(), block.begin(), block.end());
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

size_t UndoCollisions(std::span<const Eigen::Vector3i> faces,
                      const std::vector<Eigen::Vector3d>& before,
                      std::vector<Eigen::Vector3d>* after, const RunContext& context) {
  size_t num_undone = 0;
  std::vector<uint8_t> has_moved(before.size());
  for (size_t v = 0; v < before.size(); ++v) has_moved[v] = before[v] != (*after)[v];
  const auto touches = [&](const Eigen::Vector3i& f, const std::vector<uint8_t>& mark) {
    return mark[static_cast<size_t>(f[0])] || mark[static_cast<size_t>(f[1])] ||
           mark[static_cast<size_t>(f[2])];
  };
  std::vector<uint8_t> changed = has_moved, moved(faces.size());
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    context.ThrowIfCancelled();
    for (size_t f = 0; f < faces.size(); ++f) moved[f] = touches(faces[f], changed);
    const auto pairs = FaceGrid(*after, faces).CrossingPairs(moved, context);
    std::fill(changed.begin(), changed.end(), uint8_t{0});
    bool any = false;
    for (const auto& [a, b] : pairs) {
      const Eigen::Vector3i &face_a = faces[static_cast<size_t>(a)],
                            &face_b = faces[static_cast<size_t>(b)];
      if (FacesCross(before, face_a, face_b)) continue;
      for (const Eigen::Vector3i& face : {face_a, face_b}) {
        for (const int v : face) {
          const size_t vertex = static_cast<size_t>(v);
          if (!has_moved[vertex]) continue;
          (*after)[vertex] = before[vertex];
          has_moved[vertex] = 0;
          changed[vertex] = 1;
          any = true;
          ++num_undone;
        }
      }
    }
    if (!any) break;
  }
  return num_undone;
}

}  // namespace lsmvs
