#include "lsmvs/synthetic/box_union.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where a ray enters a box: the first plane it meets of each pair, and the distance.
struct Entry {
  Eigen::Vector3d planes;
  double distance;  // infinity: it does not
};

Entry EnterBox(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& inverse) {
  const Eigen::Vector3d a = (box.min() - origin).cwiseProduct(inverse);
  const Eigen::Vector3d b = (box.max() - origin).cwiseProduct(inverse);
  const Eigen::Vector3d first = a.cwiseMin(b);
  const double enter = first.maxCoeff(), leave = a.cwiseMax(b).minCoeff();
  return {first, enter <= leave ? enter : kInfinity};
}

// Reciprocals that stay finite, so that no product is NaN: a component of 0 counts as 1e-300.
Eigen::Vector3d FiniteInverse(const Eigen::Vector3d& direction) {
  return direction.unaryExpr([](double d) { return 1.0 / (d == 0 ? 1e-300 : d); });
}

// The coordinates of `cuts` with each gap cut into equal parts of at most `edge_length`; `first[i]`
// is the position of cuts[i].
struct FineCuts {
  std::vector<double> values;
  std::vector<int> first;
  FineCuts(const std::vector<double>& cuts, double edge_length) {
    for (size_t i = 0; i < cuts.size(); ++i) {
      first.push_back(static_cast<int>(values.size()));
      values.push_back(cuts[i]);
      if (i + 1 == cuts.size()) break;
      const double gap = cuts[i + 1] - cuts[i];
      const int parts = std::max(1, static_cast<int>(std::ceil(gap / edge_length - 1e-9)));
      for (int p = 1; p < parts; ++p) values.push_back(cuts[i] + gap * p / parts);
    }
  }
};

// Collects quadrangles whose corners are nodes of a grid.
class GridMesher {
 public:
  explicit GridMesher(const std::array<FineCuts, 3>& cuts) : cuts_(cuts) {}

  // Square at grid node `corner`, spanned by the axes after `axis`.
  void AddQuad(const Eigen::Vector3i& corner, int axis, bool positive) {
    const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
    const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
    const int a = Vertex(corner), b = Vertex(corner + u), c = Vertex(corner + u + v);
    const int d = Vertex(corner + v);
    if (positive) {
      mesh.faces.insert(mesh.faces.end(), {{a, b, c}, {a, c, d}});
    } else {
      mesh.faces.insert(mesh.faces.end(), {{a, c, b}, {a, d, c}});
    }
  }

  TriangleMesh mesh;

 private:
  int Vertex(const Eigen::Vector3i& node) {
    const uint64_t key = (static_cast<uint64_t>(node[2]) << 42) |
                         (static_cast<uint64_t>(node[1]) << 21) | static_cast<uint64_t>(node[0]);
    const auto [entry, is_new] = index_.try_emplace(key, static_cast<int>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.emplace_back(cuts_[0].values[node[0]], cuts_[1].values[node[1]],
                                 cuts_[2].values[node[2]]);
    }
    return entry->second;
  }

  const std::array<FineCuts, 3>& cuts_;
  std::unordered_map<uint64_t, int> index_;
};

}  // namespace

BoxUnion::BoxUnion(std::vector<Eigen::AlignedBox3d> boxes) : boxes_(std::move(boxes)) {
  LSMVS_CHECK(!boxes_.empty());
  FillGrid();
  boundary_ = std::make_unique<MeshShape>(Mesh(kInfinity));
}

void BoxUnion::FillGrid() {
  for (int k = 0; k < 3; ++k) {
    std::vector<double>& cuts = cuts_[k];
    for (const Eigen::AlignedBox3d& box : boxes_) {
      LSMVS_CHECK_LT(box.min()[k], box.max()[k]);
      cuts.insert(cuts.end(), {box.min()[k], box.max()[k]});
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  }
  const auto cells = [&](int k) { return cuts_[k].size() - 1; };
  occupied_.assign(cells(0) * cells(1) * cells(2), false);
  const auto position = [&](int k, double value) {
    return static_cast<size_t>(std::lower_bound(cuts_[k].begin(), cuts_[k].end(), value) -
                               cuts_[k].begin());
  };
  for (const Eigen::AlignedBox3d& box : boxes_) {
    for (size_t z = position(2, box.min().z()); z < position(2, box.max().z()); ++z) {
      for (size_t y = position(1, box.min().y()); y < position(1, box.max().y()); ++y) {
        for (size_t x = position(0, box.min().x()); x < position(0, box.max().x()); ++x) {
          occupied_[(z * cells(1) + y) * cells(0) + x] = true;
        }
      }
    }
  }
}

bool BoxUnion::Occupied(const Eigen::Vector3i& cell) const {
  size_t index = 0;
  for (int k = 2; k >= 0; --k) {
    const int count = static_cast<int>(cuts_[k].size()) - 1;
    if (cell[k] < 0 || cell[k] >= count) return false;
    index = index * static_cast<size_t>(count) + static_cast<size_t>(cell[k]);
  }
  return occupied_[index];
}

std::vector<BoxUnion::BoundarySide> BoxUnion::Boundary() const {
  std::vector<BoundarySide> sides;
  Eigen::Vector3i cell;
  for (cell[2] = 0; cell[2] + 1 < static_cast<int>(cuts_[2].size()); ++cell[2]) {
    for (cell[1] = 0; cell[1] + 1 < static_cast<int>(cuts_[1].size()); ++cell[1]) {
      for (cell[0] = 0; cell[0] + 1 < static_cast<int>(cuts_[0].size()); ++cell[0]) {
        if (!Occupied(cell)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
          if (!Occupied(cell + step)) sides.push_back({cell, axis, true});
          if (!Occupied(cell - step)) sides.push_back({cell, axis, false});
        }
      }
    }
  }
  return sides;
}

bool BoxUnion::Contains(const Eigen::Vector3d& x) const {
  return std::any_of(boxes_.begin(), boxes_.end(),
                     [&](const Eigen::AlignedBox3d& box) { return box.contains(x); });
}

std::optional<RayHit> BoxUnion::Intersect(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d inverse = FiniteInverse(direction);
  Entry nearest{Eigen::Vector3d::Zero(), kInfinity};
  for (const Eigen::AlignedBox3d& box : boxes_) {
    const Entry entry = EnterBox(box, origin, inverse);
    if (entry.distance >= 0 && entry.distance < nearest.distance) nearest = entry;
  }
  if (nearest.distance == kInfinity) return std::nullopt;
  int axis = 0;
  nearest.planes.maxCoeff(&axis);
  return RayHit{nearest.distance, Eigen::Vector3d::Unit(axis) * (direction[axis] > 0 ? -1.0 : 1.0)};
}

SurfacePoint BoxUnion::Closest(const Eigen::Vector3d& x) const {
  SurfacePoint result = boundary_->Closest(x);
  const double distance = std::abs(result.signed_distance);
  result.signed_distance = Contains(x) ? -distance : distance;
  return result;
}

Eigen::AlignedBox3d BoxUnion::Bounds() const { return boundary_->Bounds(); }

TriangleMesh BoxUnion::Mesh(double edge_length) const {
  const std::array<FineCuts, 3> fine = {FineCuts(cuts_[0], edge_length),
                                        FineCuts(cuts_[1], edge_length),
                                        FineCuts(cuts_[2], edge_length)};
  GridMesher mesher(fine);
  for (const BoundarySide& side : Boundary()) {
    const int u = (side.axis + 1) % 3, v = (side.axis + 2) % 3;
    Eigen::Vector3i corner;
    corner[side.axis] = fine[side.axis].first[side.cell[side.axis] + (side.positive ? 1 : 0)];
    for (int i = fine[u].first[side.cell[u]]; i < fine[u].first[side.cell[u] + 1]; ++i) {
      for (int j = fine[v].first[side.cell[v]]; j < fine[v].first[side.cell[v] + 1]; ++j) {
        corner[u] = i;
        corner[v] = j;
        mesher.AddQuad(corner, side.axis, side.positive);
      }
    }
  }
  return std::move(mesher.mesh);
}

}  // namespace lsmvs
