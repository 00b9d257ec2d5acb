#include "lsmvs/image/rasterizer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lsmvs/image/triangle_spans.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

using internal::FirstCenterFrom;

// Faces are clipped at this part of their farthest vertex' depth.
constexpr double kNearPart = 1e-5;

struct CornerInCamera {
  Eigen::Vector3d x_in_cam;
  Eigen::Vector2d x_px;  // meaningless behind the camera
};

// Image coordinates, and 1 / depth; 0 behind the camera.
struct ProjectedVertex {
  double x, y, inverse_depth;
};

// The first pixel centre that is not before a vertex, to the right and below, within the image;
// kBehind twice behind the camera. A face whose corners agree in one of them covers no centre.
struct FirstCenter {
  int32_t column, row;
};
constexpr int32_t kBehind = -1;

// Inverse depth on a face's plane as an affine function of image coordinates.
struct InverseDepth {
  double at_origin, per_column, per_row;
  // Range over the face: what rounding on faces seen nearly edge-on must not leave.
  double min, max;
};

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

  // A face that lies well before the camera.
  void DrawFace(int face_idx, const ProjectedVertex& a, const ProjectedVertex& b,
                const ProjectedVertex& c) {
    InverseDepth plane;
    if (!FindPlane(a, b, c, &plane)) return;
    DrawTriangle(face_idx, plane, {Eigen::Vector2d(a.x, a.y), {b.x, b.y}, {c.x, c.y}});
  }

  // Any face.
  void DrawFace(int face_idx, const std::array<CornerInCamera, 3>& corners) {
    const auto [nearest, farthest] =
        std::minmax({corners[0].x_in_cam.z(), corners[1].x_in_cam.z(), corners[2].x_in_cam.z()});
    if (!(farthest > 0)) return;
    const double near_depth = kNearPart * farthest;
    const bool is_clipped = nearest <= near_depth;
    InverseDepth plane;
    plane.min = 1.0 / farthest;
    plane.max = 1.0 / std::max(nearest, near_depth);
    if (!FindPlane(corners, &plane)) return;
    if (is_clipped) {
      DrawClipped(face_idx, plane, corners, near_depth);
    } else {
      DrawTriangle(face_idx, plane, {corners[0].x_px, corners[1].x_px, corners[2].x_px});
    }
  }

  // The maps hold inverse depth while faces are drawn.
  void Finish() {
    for (float& value : maps_.depth.pixels) value = value > 0 ? 1.0f / value : 0.0f;
  }

 private:
  // False where the face is seen edge-on, or from behind if those are left out. Inverse depth is an
  // affine function of image coordinates.
  bool FindPlane(const ProjectedVertex& a, const ProjectedVertex& b, const ProjectedVertex& c,
                 InverseDepth* plane) const {
    const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    const double twice_area = bx * cy - cx * by;
    if (twice_area == 0 || (options_.cull_back_faces && twice_area > 0)) return false;
    const double inverse_area = 1.0 / twice_area;
    const double bw = b.inverse_depth - a.inverse_depth, cw = c.inverse_depth - a.inverse_depth;
    plane->per_column = (bw * cy - cw * by) * inverse_area;
    plane->per_row = (bx * cw - cx * bw) * inverse_area;
    plane->at_origin = a.inverse_depth - plane->per_column * a.x - plane->per_row * a.y;
    plane->min = std::min({a.inverse_depth, b.inverse_depth, c.inverse_depth});
    plane->max = std::max({a.inverse_depth, b.inverse_depth, c.inverse_depth});
    return std::isfinite(plane->at_origin);
  }
  bool FindPlane(const std::array<CornerInCamera, 3>& corners, InverseDepth* plane) const {
    const Eigen::Vector3d& a = corners[0].x_in_cam;
    const Eigen::Vector3d normal = (corners[1].x_in_cam - a).cross(corners[2].x_in_cam - a);
    const double distance = normal.dot(a);
    if (distance == 0 || (options_.cull_back_faces && distance > 0)) return false;
    const Eigen::Vector3d n = normal / distance;
    plane->per_column = n.x() / camera_.fx;
    plane->per_row = n.y() / camera_.fy;
    plane->at_origin = n.z() - plane->per_column * camera_.cx - plane->per_row * camera_.cy;
    return std::isfinite(plane->at_origin);
  }

  void DrawClipped(int face_idx, const InverseDepth& plane,
                   const std::array<CornerInCamera, 3>& corners, double near_depth) {
    std::array<Eigen::Vector2d, 4> polygon;
    size_t size = 0;
    for (size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = corners[k].x_in_cam;
      const Eigen::Vector3d& b = corners[(k + 1) % 3].x_in_cam;
      const bool a_before = a.z() > near_depth, b_before = b.z() > near_depth;
      if (a_before) polygon[size++] = corners[k].x_px;
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

  void DrawTriangle(int face_idx, const InverseDepth& plane,
                    const std::array<Eigen::Vector2d, 3>& p) {
    ForTriangleSpans(p, camera_.width, camera_.height, [&](int row, int begin, int end) {
      DrawSpan(face_idx, plane, row, begin, end);
    });
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

// What drawing a face takes of a vertex: where it lies, and the first centre, by which the faces
// that cover none can be told from the others.
struct DrawnVertex {
  ProjectedVertex projected;
  FirstCenter center;
};

// The vertices that were asked for last: neighbouring faces share them.
class DrawnVertices {
 public:
  DrawnVertices(const PinholeCamera& camera, const Rigid3& cam_from_world,
                std::span<const Eigen::Vector3d> vertices)
      : camera_(camera), cam_from_world_(cam_from_world), vertices_(vertices), entries_(kSize) {}

  FirstCenter CenterOf(int32_t vertex) { return Find(vertex).center; }
  ProjectedVertex Of(int32_t vertex) { return Find(vertex).projected; }

 private:
  static constexpr size_t kSize = 4096;
  struct Entry {
    int32_t vertex = -1;
    DrawnVertex drawn;
  };

  const DrawnVertex& Find(int32_t vertex) {
    Entry& entry = entries_[static_cast<size_t>(vertex) % kSize];
    if (entry.vertex != vertex) entry = {vertex, Project(static_cast<size_t>(vertex))};
    return entry.drawn;
  }

  DrawnVertex Project(size_t vertex) const {
    const Eigen::Vector3d x = cam_from_world_ * vertices_[vertex];
    if (!(x.z() > 0)) return {{0, 0, 0}, {kBehind, kBehind}};
    const double inverse = 1.0 / x.z();
    const ProjectedVertex p = {camera_.fx * (x.x() * inverse) + camera_.cx,
                               camera_.fy * (x.y() * inverse) + camera_.cy, inverse};
    return {p, {FirstCenterFrom(p.x, camera_.width), FirstCenterFrom(p.y, camera_.height)}};
  }

  const PinholeCamera& camera_;
  const Rigid3& cam_from_world_;
  std::span<const Eigen::Vector3d> vertices_;
  std::vector<Entry> entries_;
};

// Whether no corner lies behind the camera or so near that the face must be clipped.
bool IsWellBefore(const ProjectedVertex& a, const ProjectedVertex& b, const ProjectedVertex& c) {
  const double nearest = std::max({a.inverse_depth, b.inverse_depth, c.inverse_depth});
  return std::min({a.inverse_depth, b.inverse_depth, c.inverse_depth}) > kNearPart * nearest;
}

// Most faces of a fine mesh: too small, outside of the image or behind.
bool CoversNoCenter(const FirstCenter& a, const FirstCenter& b, const FirstCenter& c) {
  return (a.column == b.column && a.column == c.column) || (a.row == b.row && a.row == c.row);
}

}  // namespace

void RasterizeMesh(const PinholeCamera& camera, const Rigid3& cam_from_world,
                   std::span<const Eigen::Vector3d> vertices,
                   std::span<const Eigen::Vector3i> faces, const RasterizerOptions& options,
                   SurfaceMaps* maps) {
  DrawnVertices drawn(camera, cam_from_world, vertices);
  Rasterizer rasterizer(camera, options, maps);
  const auto corner = [&](int v) -> CornerInCamera {
    const Eigen::Vector3d x = cam_from_world * vertices[static_cast<size_t>(v)];
    return {x, camera.Project(x)};
  };
  const auto draw = [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      const Eigen::Vector3i& face = faces[f];
      if (CoversNoCenter(drawn.CenterOf(face[0]), drawn.CenterOf(face[1]),
                         drawn.CenterOf(face[2]))) {
        continue;
      }
      const ProjectedVertex a = drawn.Of(face[0]), b = drawn.Of(face[1]), c = drawn.Of(face[2]);
      if (IsWellBefore(a, b, c)) {
        rasterizer.DrawFace(static_cast<int>(f), a, b, c);
      } else {
        rasterizer.DrawFace(static_cast<int>(f),
                            {corner(face[0]), corner(face[1]), corner(face[2])});
      }
    }
  };
  if (options.blocks == nullptr) {
    draw(0, faces.size());
  } else {
    for (const size_t block : options.blocks->SeenBy(camera, cam_from_world)) {
      const size_t begin = block * FaceBlocks::kFacesPerBlock;
      draw(begin, std::min(begin + FaceBlocks::kFacesPerBlock, faces.size()));
    }
  }
  rasterizer.Finish();
}

}  // namespace lsmvs
