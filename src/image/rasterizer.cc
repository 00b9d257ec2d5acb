#include "lsmvs/image/rasterizer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

// Faces are clipped at this part of their farthest vertex' depth.
constexpr double kNearPart = 1e-5;

struct ProjectedVertex {
  Eigen::Vector3d x_in_cam;
  Eigen::Vector2d x_px;  // meaningless behind the camera
};

// Inverse depth on a face's plane as an affine function of image coordinates.
struct InverseDepth {
  double at_origin, per_column, per_row;
  // Range over the face: what rounding on faces seen nearly edge-on must not leave.
  double min, max;
};

// First column or row whose centre is not below `coordinate`, within [0, size].
int FirstCenterFrom(double coordinate, int size) {
  const double clamped = std::clamp(coordinate - 0.5, -1.0, static_cast<double>(size));
  return std::max(0, static_cast<int>(std::ceil(clamped)));
}

// Where an edge crosses the horizontal line y; `upper` and `lower` in an order that does not depend
// on the face, so that both faces at the edge compute the same number.
double Crossing(const Eigen::Vector2d& upper, const Eigen::Vector2d& lower, double y) {
  return upper.x() + (y - upper.y()) * ((lower.x() - upper.x()) / (lower.y() - upper.y()));
}

class Rasterizer {
 public:
  Rasterizer(const PinholeCamera& camera, const RasterizerOptions& options, SurfaceMaps* maps)
      : camera_(camera), options_(options), maps_(*maps) {
    maps_.depth.width = maps_.face.width = camera.width;
    maps_.depth.height = maps_.face.height = camera.height;
    const size_t size = static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
    maps_.depth.pixels.assign(size, 0.0f);
    maps_.face.pixels.assign(size, -1);
  }

  void DrawFace(int face_idx, const std::array<const ProjectedVertex*, 3>& corners) {
    int num_before = 0;
    double farthest = 0;
    for (const ProjectedVertex* corner : corners) {
      farthest = std::max(farthest, corner->x_in_cam.z());
    }
    const double near_depth = kNearPart * farthest;
    for (const ProjectedVertex* corner : corners) num_before += corner->x_in_cam.z() > near_depth;
    if (num_before == 0) return;
    InverseDepth plane;
    if (!FindPlane(corners, near_depth, &plane)) return;
    if (num_before == 3) {
      DrawTriangle(face_idx, plane, {corners[0]->x_px, corners[1]->x_px, corners[2]->x_px});
    } else {
      DrawClipped(face_idx, plane, corners, near_depth);
    }
  }

  // The maps hold inverse depth while faces are drawn.
  void Finish() {
    for (float& value : maps_.depth.pixels) value = value > 0 ? 1.0f / value : 0.0f;
  }

 private:
  // False where the face is seen edge-on, or from behind if those are left out.
  bool FindPlane(const std::array<const ProjectedVertex*, 3>& corners, double near_depth,
                 InverseDepth* plane) const {
    const Eigen::Vector3d& a = corners[0]->x_in_cam;
    const Eigen::Vector3d normal = (corners[1]->x_in_cam - a).cross(corners[2]->x_in_cam - a);
    const double distance = normal.dot(a);
    if (distance == 0 || (options_.cull_back_faces && distance > 0)) return false;
    const Eigen::Vector3d n = normal / distance;
    plane->per_column = n.x() / camera_.fx;
    plane->per_row = n.y() / camera_.fy;
    plane->at_origin = n.z() - plane->per_column * camera_.cx - plane->per_row * camera_.cy;
    const auto [nearest, farthest] =
        std::minmax({a.z(), corners[1]->x_in_cam.z(), corners[2]->x_in_cam.z()});
    plane->min = 1.0 / farthest;
    plane->max = 1.0 / std::max(nearest, near_depth);
    return std::isfinite(plane->at_origin);
  }

  void DrawClipped(int face_idx, const InverseDepth& plane,
                   const std::array<const ProjectedVertex*, 3>& corners, double near_depth) {
    std::array<Eigen::Vector2d, 4> polygon;
    size_t size = 0;
    for (size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = corners[k]->x_in_cam;
      const Eigen::Vector3d& b = corners[(k + 1) % 3]->x_in_cam;
      const bool a_before = a.z() > near_depth, b_before = b.z() > near_depth;
      if (a_before) polygon[size++] = corners[k]->x_px;
      if (a_before == b_before) continue;
      // From the vertex before the camera, whichever face asks.
      const Eigen::Vector3d& from = a_before ? a : b;
      const Eigen::Vector3d& to = a_before ? b : a;
      const double t = (from.z() - near_depth) / (from.z() - to.z());
      polygon[size++] = camera_.Project(from + t * (to - from));
    }
    for (size_t k = 2; k < size; ++k) {
      DrawTriangle(face_idx, plane, {polygon[0], polygon[k - 1], polygon[k]});
    }
  }

  void DrawTriangle(int face_idx, const InverseDepth& plane, std::array<Eigen::Vector2d, 3> p) {
    // From top to bottom; of equally high ones from left to right.
    const auto above = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return a.y() != b.y() ? a.y() < b.y() : a.x() < b.x();
    };
    if (above(p[1], p[0])) std::swap(p[0], p[1]);
    if (above(p[2], p[1])) std::swap(p[1], p[2]);
    if (above(p[1], p[0])) std::swap(p[0], p[1]);
    const int first_row = FirstCenterFrom(p[0].y(), camera_.height);
    const int end_row = FirstCenterFrom(p[2].y(), camera_.height);
    for (int row = first_row; row < end_row; ++row) {
      const double y = row + 0.5;
      const double x_long = Crossing(p[0], p[2], y);
      const double x_short = y < p[1].y() ? Crossing(p[0], p[1], y) : Crossing(p[1], p[2], y);
      DrawSpan(face_idx, plane, row, FirstCenterFrom(std::min(x_long, x_short), camera_.width),
               FirstCenterFrom(std::max(x_long, x_short), camera_.width));
    }
  }

  void DrawSpan(int face_idx, const InverseDepth& plane, int row, int begin, int end) {
    const double at_row = plane.at_origin + plane.per_row * (row + 0.5);
    float* depth = maps_.depth.Row(row);
    int32_t* face = maps_.face.Row(row);
    for (int column = begin; column < end; ++column) {
      const double on_plane = at_row + plane.per_column * (column + 0.5);
      const float inverse = static_cast<float>(std::clamp(on_plane, plane.min, plane.max));
      if (!(inverse > depth[column])) continue;
      depth[column] = inverse;
      face[column] = face_idx;
    }
  }

  const PinholeCamera& camera_;
  const RasterizerOptions& options_;
  SurfaceMaps& maps_;
};

}  // namespace

void RasterizeMesh(const PinholeCamera& camera, const Rigid3& cam_from_world,
                   std::span<const Eigen::Vector3d> vertices,
                   std::span<const Eigen::Vector3i> faces, const RasterizerOptions& options,
                   SurfaceMaps* maps) {
  std::vector<ProjectedVertex> projected(vertices.size());
  for (size_t v = 0; v < vertices.size(); ++v) {
    projected[v].x_in_cam = cam_from_world * vertices[v];
    projected[v].x_px = camera.Project(projected[v].x_in_cam);
  }
  Rasterizer rasterizer(camera, options, maps);
  for (size_t f = 0; f < faces.size(); ++f) {
    const Eigen::Vector3i& face = faces[f];
    rasterizer.DrawFace(static_cast<int>(f), {&projected[static_cast<size_t>(face[0])],
                                              &projected[static_cast<size_t>(face[1])],
                                              &projected[static_cast<size_t>(face[2])]});
  }
  rasterizer.Finish();
}

}  // namespace lsmvs
