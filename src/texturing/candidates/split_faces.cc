#include "lsmvs/texturing/candidates/split_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

namespace lsmvs {

namespace {

constexpr int kMaxRounds = 10;
// No further round once there are so many faces, beside twice those of the input.
constexpr size_t kMaxMoreFaces = 200000;

struct FaceInView {
  std::array<Eigen::Vector3d, 3> x_in_cam;
  Eigen::AlignedBox2d box_px;  // of the corners before the camera
  double farthest = 0;
};

class FaceSplitter {
 public:
  FaceSplitter(const Scene& scene, const ImageStore& images, double max_width_px,
               TriangleMesh* mesh)
      : scene_(scene), max_width_px_(max_width_px), mesh_(*mesh) {
    for (size_t v = 0; v < scene.views.size(); ++v) {
      cameras_.push_back(images.Camera(static_cast<int>(v), 0));
    }
    FindLongestShortEdge();
  }

  size_t Run(const RunContext& context) {
    size_t num_split = 0;
    const size_t enough = 2 * mesh_.faces.size() + kMaxMoreFaces;
    for (int round = 0; round < kMaxRounds && mesh_.faces.size() < enough; ++round) {
      context.ThrowIfCancelled();
      middles_.clear();
      for (const Eigen::Vector3i& face : mesh_.faces) MarkLongEdges(face);
      if (middles_.empty()) break;
      num_split += SplitMarked();
    }
    return num_split;
  }

 private:
  // No photo shows an edge of this length in the world wider than allowed.
  void FindLongestShortEdge() {
    double finest = 0;  // pixels per world unit
    for (size_t v = 0; v < cameras_.size(); ++v) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& x : mesh_.vertices) {
        const double z = scene_.views[v].Depth(x);
        if (z > 0) nearest = std::min(nearest, z);
      }
      finest = std::max(finest, std::max(cameras_[v].fx, cameras_[v].fy) / nearest);
    }
    // A slanted edge at the border of an image of 90 degrees is up to twice as long.
    always_short_ = finest > 0 ? max_width_px_ / (2 * finest) : 0;
  }

  size_t SplitMarked() {
    std::vector<Eigen::Vector3i> whole, parts;
    for (const Eigen::Vector3i& face : mesh_.faces) {
      if (IsMarked(face)) {
        Split(face, &parts);
      } else {
        whole.push_back(face);
      }
    }
    const size_t num_split = mesh_.faces.size() - whole.size();
    whole.insert(whole.end(), parts.begin(), parts.end());
    mesh_.faces.swap(whole);
    return num_split;
  }

  double LongestEdge(const Eigen::Vector3i& face) const {
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, Length(face, k));
    return longest;
  }
  double Length(const Eigen::Vector3i& face, int side) const {
    return (mesh_.vertices[face[(side + 1) % 3]] - mesh_.vertices[face[side]]).norm();
  }

  void MarkLongEdges(const Eigen::Vector3i& face) {
    if (LongestEdge(face) <= always_short_) return;
    // A copy: marking adds vertices.
    const Eigen::Vector3d corner = mesh_.vertices[face[0]];
    const Eigen::Vector3d normal =
        (mesh_.vertices[face[1]] - corner).cross(mesh_.vertices[face[2]] - corner);
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (normal.dot(scene_.views[v].CenterInWorld() - corner) <= 0) continue;
      const FaceInView seen = Project(face, v);
      if (!(seen.farthest > 0)) continue;
      const Eigen::AlignedBox2d image(Eigen::Vector2d(0, 0),
                                      Eigen::Vector2d(cameras_[v].width, cameras_[v].height));
      if (!image.intersects(seen.box_px)) continue;
      for (int side = 0; side < 3; ++side) {
        if (WidthPx(seen, cameras_[v], side) > max_width_px_) Mark(face, side);
      }
    }
  }

  FaceInView Project(const Eigen::Vector3i& face, size_t v) const {
    FaceInView seen;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d x = scene_.views[v].cam_from_world * mesh_.vertices[face[k]];
      seen.x_in_cam[static_cast<size_t>(k)] = x;
      seen.farthest = std::max(seen.farthest, x.z());
      if (x.z() > 0) seen.box_px.extend(cameras_[v].Project(x));
    }
    return seen;
  }

  // Of an edge that reaches behind the camera: what it would have at the farthest corner.
  static double WidthPx(const FaceInView& seen, const PinholeCamera& camera, int side) {
    const Eigen::Vector3d& a = seen.x_in_cam[static_cast<size_t>(side)];
    const Eigen::Vector3d& b = seen.x_in_cam[static_cast<size_t>((side + 1) % 3)];
    if (a.z() > 0 && b.z() > 0) return (camera.Project(a) - camera.Project(b)).norm();
    return camera.MeanFocalLength() * (a - b).norm() / seen.farthest;
  }

  static uint64_t Key(int a, int b) {
    return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
  }

  void Mark(const Eigen::Vector3i& face, int side) {
    const int a = face[side], b = face[(side + 1) % 3];
    const auto [place, is_new] = middles_.emplace(Key(a, b), 0);
    if (!is_new) return;
    place->second = static_cast<int>(mesh_.vertices.size());
    mesh_.vertices.push_back(0.5 * (mesh_.vertices[a] + mesh_.vertices[b]));
    if (!mesh_.vertex_normals.empty()) {
      mesh_.vertex_normals.push_back(
          (mesh_.vertex_normals[a] + mesh_.vertex_normals[b]).normalized());
    }
    if (!mesh_.vertex_quality.empty()) {
      mesh_.vertex_quality.push_back(0.5f * (mesh_.vertex_quality[static_cast<size_t>(a)] +
                                             mesh_.vertex_quality[static_cast<size_t>(b)]));
    }
  }

  // -1: not split.
  int MiddleOf(const Eigen::Vector3i& face, int side) const {
    const auto found = middles_.find(Key(face[side], face[(side + 1) % 3]));
    return found == middles_.end() ? -1 : found->second;
  }

  bool IsMarked(const Eigen::Vector3i& face) const {
    return MiddleOf(face, 0) >= 0 || MiddleOf(face, 1) >= 0 || MiddleOf(face, 2) >= 0;
  }

  void Split(const Eigen::Vector3i& face, std::vector<Eigen::Vector3i>* parts) const {
    const std::array<int, 3> middle = {MiddleOf(face, 0), MiddleOf(face, 1), MiddleOf(face, 2)};
    const auto count = std::count_if(middle.begin(), middle.end(), [](int m) { return m >= 0; });
    if (count == 3) {
      parts->emplace_back(middle[0], middle[1], middle[2]);
      for (int k = 0; k < 3; ++k) {
        parts->emplace_back(face[k], middle[static_cast<size_t>(k)],
                            middle[static_cast<size_t>((k + 2) % 3)]);
      }
      return;
    }
    // Turned so that the first edge is split, and of two the one before it, too.
    int first = 0;
    while (middle[static_cast<size_t>(first)] < 0 ||
           (count == 2 && middle[static_cast<size_t>((first + 2) % 3)] < 0)) {
      ++first;
    }
    const int a = face[first], b = face[(first + 1) % 3], c = face[(first + 2) % 3];
    const int on_ab = middle[static_cast<size_t>(first)];
    if (count == 1) {
      parts->emplace_back(a, on_ab, c);
      parts->emplace_back(on_ab, b, c);
      return;
    }
    const int on_ca = middle[static_cast<size_t>((first + 2) % 3)];
    parts->emplace_back(a, on_ab, on_ca);
    parts->emplace_back(on_ab, b, c);
    parts->emplace_back(on_ab, c, on_ca);
  }

  const Scene& scene_;
  double max_width_px_;
  TriangleMesh& mesh_;
  std::vector<PinholeCamera> cameras_;
  double always_short_ = 0;
  std::unordered_map<uint64_t, int> middles_;  // of the edges that this round splits
};

}  // namespace

size_t SplitWideFaces(const Scene& scene, const ImageStore& images, double max_width_px,
                      TriangleMesh* mesh, const RunContext& context) {
  mesh->vertex_colors.clear();
  return FaceSplitter(scene, images, max_width_px, mesh).Run(context);
}

}  // namespace lsmvs
