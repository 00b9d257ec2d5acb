#include "lsmvs/exporting/tiles/chart_unfolding.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr double kGrowCosine = 0.6;       // of a new face's normal and the mean of the chart
constexpr double kFlattestCosine = 0.35;  // of any face's normal and the final direction
constexpr int kNumTurns = 8;              // of a chart in the plane, to fill its rectangle well
constexpr float kReachPx = 1.5f;
constexpr double kLargestSidePx = 2048;

// The face across each side, or -1: [3 * face + corner].
std::vector<int> Neighbors(const TriangleMesh& mesh) {
  std::vector<int> neighbors(3 * mesh.faces.size(), -1);
  const std::vector<HalfEdge> sides = SortedHalfEdges(mesh.faces, mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    if (end - begin != 2) return;
    neighbors[static_cast<size_t>(3 * begin[0].face + begin[0].corner)] = begin[1].face;
    neighbors[static_cast<size_t>(3 * begin[1].face + begin[1].corner)] = begin[0].face;
  });
  return neighbors;
}

// Signed distance [px] of a point from a triangle in the plane: below 0 inside.
float DistanceOutside(const std::array<Eigen::Vector2f, 3>& t, const Eigen::Vector2f& x) {
  float nearest = std::numeric_limits<float>::infinity();
  bool all_left = true, all_right = true;
  for (size_t c = 0; c < 3; ++c) {
    const Eigen::Vector2f a = t[c], edge = t[(c + 1) % 3] - a, to_x = x - a;
    const float cross = edge.x() * to_x.y() - edge.y() * to_x.x();
    all_left &= cross >= 0;
    all_right &= cross <= 0;
    const float length2 = edge.squaredNorm();
    const float s = length2 > 0 ? std::clamp(edge.dot(to_x) / length2, 0.0f, 1.0f) : 0.0f;
    nearest = std::min(nearest, (to_x - s * edge).norm());
  }
  return all_left || all_right ? -nearest : nearest;
}

class Unfolder {
 public:
  Unfolder(const TriangleMesh& mesh, double texel_size)
      : mesh_(mesh), texel_size_(texel_size), neighbors_(Neighbors(mesh)) {
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      normals_.push_back(FaceNormalTimesTwiceArea(mesh, f));
    }
    is_taken_.resize(mesh.faces.size(), 0);
    seen_by_.resize(mesh.faces.size(), -1);
  }

  std::vector<UnfoldedChart> Unfold() {
    std::vector<UnfoldedChart> charts;
    for (size_t seed = 0; seed < mesh_.faces.size(); ++seed) {
      // Faces that a chart gives back start charts of their own later; its seed it keeps.
      if (!is_taken_[seed]) charts.push_back(MakeChart(static_cast<int>(seed)));
    }
    return charts;
  }

 private:
  UnfoldedChart MakeChart(int seed) {
    std::vector<int> faces = Grow(seed);
    const Eigen::Vector3d direction = KeepFacing(seed, &faces);
    UnfoldedChart chart = Flatten(direction, seed, faces);
    for (const int f : chart.faces) is_taken_[static_cast<size_t>(f)] = 1;
    return chart;
  }

  // Faces connected to the seed, in the order in which they are reached.
  std::vector<int> Grow(int seed) {
    std::vector<int> faces;
    std::deque<int> queue = {seed};
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::AlignedBox3d box;
    seen_by_[static_cast<size_t>(seed)] = seed;
    while (!queue.empty()) {
      const int f = queue.front();
      queue.pop_front();
      const Eigen::Vector3d& normal = normals_[static_cast<size_t>(f)];
      Eigen::AlignedBox3d grown = box;
      for (const int v : mesh_.faces[f]) grown.extend(mesh_.vertices[v]);
      if (f != seed && (normal.dot(sum) < kGrowCosine * normal.norm() * sum.norm() ||
                        grown.diagonal().norm() > kLargestSidePx * texel_size_)) {
        continue;
      }
      box = grown;
      faces.push_back(f);
      sum += normal;
      for (int c = 0; c < 3; ++c) {
        const int next = neighbors_[static_cast<size_t>(3 * f + c)];
        if (next < 0 || is_taken_[static_cast<size_t>(next)] ||
            seen_by_[static_cast<size_t>(next)] == seed) {
          continue;
        }
        seen_by_[static_cast<size_t>(next)] = seed;
        queue.push_back(next);
      }
    }
    return faces;
  }

  // Drops what is turned away from the mean normal; returns it, or the seed's.
  Eigen::Vector3d KeepFacing(int seed, std::vector<int>* faces) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int f : *faces) sum += normals_[static_cast<size_t>(f)];
    const auto faces_it = [&](const Eigen::Vector3d& direction, int f) {
      const Eigen::Vector3d& normal = normals_[static_cast<size_t>(f)];
      return normal.dot(direction) >= kFlattestCosine * normal.norm() * direction.norm();
    };
    if (!faces_it(sum, seed)) sum = normals_[static_cast<size_t>(seed)];
    std::erase_if(*faces, [&](int f) { return f != seed && !faces_it(sum, f); });
    return sum.norm() > 0 ? Eigen::Vector3d(sum.normalized())
                          : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  }

  using Flat = std::array<Eigen::Vector2d, 3>;

  // Projects, turns so that the rectangle is small, and drops faces that would overlap others.
  UnfoldedChart Flatten(const Eigen::Vector3d& direction, int seed, std::vector<int> faces) const {
    const Eigen::Vector3d axis_x = direction.unitOrthogonal(), axis_y = direction.cross(axis_x);
    std::vector<Flat> flat;
    for (const int f : faces) {
      Flat t;
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d x =
            (mesh_.vertices[mesh_.faces[f][c]] - mesh_.vertices[mesh_.faces[seed][0]]) /
            texel_size_;
        t[static_cast<size_t>(c)] = {x.dot(axis_x), x.dot(axis_y)};
      }
      flat.push_back(t);
    }
    return Rasterize(Turned(flat), std::move(faces));
  }

  static Eigen::AlignedBox2d BoxOf(const std::vector<Flat>& flat, const Eigen::Matrix2d& turn) {
    Eigen::AlignedBox2d box;
    for (const Flat& t : flat) {
      for (const Eigen::Vector2d& x : t) box.extend(Eigen::Vector2d(turn * x));
    }
    return box;
  }

  static std::vector<Flat> Turned(std::vector<Flat> flat) {
    Eigen::Matrix2d best = Eigen::Matrix2d::Identity();
    for (int i = 1; i < kNumTurns; ++i) {
      const Eigen::Matrix2d turn =
          Eigen::Rotation2Dd(0.5 * std::numbers::pi * i / kNumTurns).toRotationMatrix();
      if (BoxOf(flat, turn).volume() < BoxOf(flat, best).volume()) best = turn;
    }
    const Eigen::Vector2d shift =
        Eigen::Vector2d::Constant(kChartGutterPx) - BoxOf(flat, best).min();
    for (Flat& t : flat) {
      for (Eigen::Vector2d& x : t) x = best * x + shift;
    }
    return flat;
  }

  static UnfoldedChart Rasterize(const std::vector<Flat>& flat, std::vector<int> faces) {
    Eigen::AlignedBox2d box = BoxOf(flat, Eigen::Matrix2d::Identity());
    UnfoldedChart chart;
    chart.size =
        box.max().array().ceil().matrix().cast<int>() + Eigen::Vector2i::Constant(kChartGutterPx);
    chart.face_of_texel = Raster<int32_t>(chart.size.x(), chart.size.y(), -1);
    Raster<float> distance(chart.size.x(), chart.size.y(), kReachPx);
    for (size_t i = 0; i < faces.size(); ++i) {
      std::array<Eigen::Vector2f, 3> t;
      for (size_t c = 0; c < 3; ++c) t[c] = flat[i][c].cast<float>();
      const int number = static_cast<int>(chart.faces.size());
      if (!chart.faces.empty() && Overlaps(t, chart.face_of_texel, distance)) continue;
      Draw(t, number, &chart.face_of_texel, &distance);
      chart.faces.push_back(faces[i]);
      chart.texcoords.push_back(t);
    }
    return chart;
  }

  template <class Visit>
  static void ForTexels(const std::array<Eigen::Vector2f, 3>& t, const Raster<float>& image,
                        const Visit& visit) {
    const Eigen::Vector2f low = t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() - kReachPx - 0.5f;
    const Eigen::Vector2f high = t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() + kReachPx - 0.5f;
    const int left = std::max(0, static_cast<int>(std::ceil(low.x()))),
              top = std::max(0, static_cast<int>(std::ceil(low.y()))),
              right = std::min(image.width - 1, static_cast<int>(std::floor(high.x()))),
              bottom = std::min(image.height - 1, static_cast<int>(std::floor(high.y())));
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const Eigen::Vector2f center(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        visit(x, y, DistanceOutside(t, center));
      }
    }
  }

  // Whether a texel lies well inside both this and a face drawn before.
  static bool Overlaps(const std::array<Eigen::Vector2f, 3>& t, const Raster<int32_t>& face,
                       const Raster<float>& distance) {
    bool overlaps = false;
    ForTexels(t, distance, [&](int x, int y, float d) {
      overlaps |= d < -1e-3f && face(x, y) >= 0 && distance(x, y) < -1e-3f;
    });
    return overlaps;
  }

  static void Draw(const std::array<Eigen::Vector2f, 3>& t, int number, Raster<int32_t>* face,
                   Raster<float>* distance) {
    ForTexels(t, *distance, [&](int x, int y, float d) {
      if (d >= (*distance)(x, y)) return;
      (*distance)(x, y) = d;
      (*face)(x, y) = number;
    });
  }

  const TriangleMesh& mesh_;
  const double texel_size_;
  const std::vector<int> neighbors_;
  std::vector<Eigen::Vector3d> normals_;
  std::vector<uint8_t> is_taken_;
  std::vector<int> seen_by_;  // #F: the seed from which a face was last reached
};

}  // namespace

std::vector<UnfoldedChart> UnfoldCharts(const TriangleMesh& mesh, double texel_size) {
  return Unfolder(mesh, texel_size).Unfold();
}

}  // namespace lsmvs
