#include "lsmvs/evaluation/mesh_renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/statistics.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3d kClay(0.55, 0.52, 0.48);  // linear light

uint32_t Mix(uint32_t x) {  // lowbias32, by C. Wellons
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

double ToLinear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double ToSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

const std::array<double, 256>& LinearTable() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = ToLinear(static_cast<double>(i) / 255);
    return values;
  }();
  return table;
}

Color Encode(const Eigen::Vector3d& linear) {
  Color color;
  for (int k = 0; k < 3; ++k) {
    color[k] = static_cast<uint8_t>(
        std::lround(255 * std::clamp(ToSrgb(std::clamp(linear[k], 0.0, 1.0)), 0.0, 1.0)));
  }
  return color;
}

Eigen::AlignedBox3d FiniteBox(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if (x.allFinite()) box.extend(x);
  }
  return box;
}

// What a ray meets, ready to be lit.
struct SurfacePoint {
  Eigen::Vector3d x_in_world, normal;  // the normal faces the camera
  Eigen::Vector3d albedo;              // linear light
  double depth = 0;
};

class Renderer {
 public:
  Renderer(const TriangleMesh& mesh, const MeshTracer& tracer, const PosedCamera& viewpoint,
           const RenderOptions& options, const TexturePages* texture)
      : mesh_(mesh),
        tracer_(tracer),
        texture_(texture),
        viewpoint_(viewpoint),
        options_(options),
        center_(viewpoint.cam_from_world.OriginInSource()),
        world_from_cam_(viewpoint.cam_from_world.rotation.transpose()) {
    const Eigen::AlignedBox3d box = FiniteBox(mesh);
    diagonal_ = box.isEmpty() ? 1 : box.diagonal().norm();
    // Light falls from above the viewer's left shoulder; in the camera frame y points down.
    to_key_light_ = world_from_cam_ * Eigen::Vector3d(-0.5, -0.75, -0.85).normalized();
    to_sky_ = world_from_cam_ * Eigen::Vector3d(0, -1, 0);
    if (options.smooth) normals_ = ComputeVertexNormals(mesh);
    if (options.style == RenderStyle::kDepth) SetDepthRange();
  }

  Color Pixel(int column, int row) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const int n = options_.antialiasing;
    for (int s = 0; s < n * n; ++s) {
      const Eigen::Vector2d x_px(column + (s % n + 0.5) / n, row + (s / n + 0.5) / n);
      sum += Sample(x_px, Mix(Mix(Mix(column) + row) + s));
    }
    return Encode(sum / (n * n));
  }

 private:
  Eigen::Vector3d Sample(const Eigen::Vector2d& x_px, uint32_t seed) const {
    const Eigen::Vector3d ray = world_from_cam_ * viewpoint_.camera.Ray(x_px);
    const std::optional<MeshHit> hit = tracer_.Cast(center_, ray);
    if (!hit) return Background(x_px.y() / viewpoint_.camera.height);
    const SurfacePoint point = PointAt(*hit, ray);
    switch (options_.style) {
      case RenderStyle::kColor:
        return point.albedo;
      case RenderStyle::kNormals:
        return NormalColor(point.normal);
      case RenderStyle::kDepth:
        return DepthColor(point.depth);
      default:
        return point.albedo * Light(point, seed);
    }
  }

  Eigen::Vector3d Background(double height) const {
    const double level = std::clamp(options_.background / 255.0 - 0.09 * height, 0.0, 1.0);
    return Eigen::Vector3d::Constant(ToLinear(level));
  }

  SurfacePoint PointAt(const MeshHit& hit, const Eigen::Vector3d& ray) const {
    SurfacePoint point;
    point.depth = hit.distance;
    point.x_in_world = center_ + hit.distance * ray;
    const Eigen::Vector3i& face = mesh_.faces[hit.face];
    const double b1 = hit.barycentric_1, b2 = hit.barycentric_2, b0 = 1 - b1 - b2;
    Eigen::Vector3d normal = FaceNormalTimesTwiceArea(mesh_, hit.face);
    if (options_.smooth) {
      const Eigen::Vector3d mixed = b0 * normals_[face[0]].cast<double>() +
                                    b1 * normals_[face[1]].cast<double>() +
                                    b2 * normals_[face[2]].cast<double>();
      if (mixed.norm() > 1e-3) normal = mixed;
    }
    point.normal = (normal.dot(ray) > 0 ? -normal : normal).normalized();
    point.albedo = kClay;
    const bool wants_color =
        options_.style == RenderStyle::kColor || options_.style == RenderStyle::kLit;
    if (wants_color && texture_ != nullptr) {
      const Eigen::Vector3f color =
          texture_->Sample(hit.face, {hit.barycentric_1, hit.barycentric_2});
      for (int k = 0; k < 3; ++k) point.albedo[k] = ToLinear(color[k] / 255.0);
    } else if (wants_color && !mesh_.vertex_colors.empty()) {
      const auto& table = LinearTable();
      for (int k = 0; k < 3; ++k) {
        point.albedo[k] = b0 * table[mesh_.vertex_colors[face[0]][k]] +
                          b1 * table[mesh_.vertex_colors[face[1]][k]] +
                          b2 * table[mesh_.vertex_colors[face[2]][k]];
      }
    }
    return point;
  }

  // Soft light from the sky, dimmed where the neighbourhood hides it, and a key light.
  double Light(const SurfacePoint& point, uint32_t seed) const {
    const double sky = 0.75 + 0.25 * point.normal.dot(to_sky_);
    const double key = std::max(0.0, point.normal.dot(to_key_light_));
    const double open = OpenShare(point, seed);
    return 0.50 * sky * open + 0.86 * key * (0.35 + 0.65 * open);
  }

  // Share of the half-space over the point that is free of mesh within the radius; cosine-weighted.
  double OpenShare(const SurfacePoint& point, uint32_t seed) const {
    const int count = options_.num_occlusion_rays;
    if (count == 0) return 1;
    const double radius = options_.occlusion_radius * diagonal_;
    const Eigen::Vector3d axis_1 = point.normal.unitOrthogonal();
    const Eigen::Vector3d axis_2 = point.normal.cross(axis_1);
    const Eigen::Vector3d origin = point.x_in_world + 1e-3 * radius * point.normal;
    const double turn = Mix(seed) * 0x1.0p-32, lift = Mix(seed + 1) * 0x1.0p-32;
    int open = 0;
    for (int i = 0; i < count; ++i) {  // a turned lattice over the disk, lifted to the half-sphere
      const double squared = (i + lift) / count;
      const double angle = 2 * kPi * (turn + i * 0.6180339887498949);
      const Eigen::Vector3d direction = std::sqrt(squared) * std::cos(angle) * axis_1 +
                                        std::sqrt(squared) * std::sin(angle) * axis_2 +
                                        std::sqrt(1 - squared) * point.normal;
      open += !tracer_.Occluded(origin, direction, 0, radius);
    }
    return static_cast<double>(open) / count;
  }

  Eigen::Vector3d NormalColor(const Eigen::Vector3d& normal) const {
    const Eigen::Vector3d in_cam = world_from_cam_.transpose() * normal;
    const Eigen::Vector3d shown(in_cam.x(), -in_cam.y(), -in_cam.z());
    Eigen::Vector3d linear;
    for (int k = 0; k < 3; ++k) linear[k] = ToLinear(0.5 + 0.5 * shown[k]);
    return linear;
  }

  // The depths of 1 % and 99 % of a coarse grid of pixels.
  void SetDepthRange() {
    const PinholeCamera coarse = viewpoint_.camera.Resized(64, 64);
    const Raster<float> map = TraceDepth(tracer_, coarse, viewpoint_.cam_from_world, RunContext(1));
    std::vector<float> depths;
    for (const float depth : map.pixels) {
      if (depth > 0) depths.push_back(depth);
    }
    if (depths.empty()) return;
    std::sort(depths.begin(), depths.end());
    near_ = depths[depths.size() / 100];
    far_ = depths[depths.size() - 1 - depths.size() / 100];
  }

  Eigen::Vector3d DepthColor(double depth) const {
    const double range = 1 / near_ - 1 / far_;
    const double nearness = range > 0 ? (1 / depth - 1 / far_) / range : 1;
    return Eigen::Vector3d::Constant(ToLinear(0.1 + 0.8 * std::clamp(nearness, 0.0, 1.0)));
  }

  const TriangleMesh& mesh_;
  const MeshTracer& tracer_;
  const TexturePages* const texture_;
  const PosedCamera& viewpoint_;
  const RenderOptions& options_;
  const Eigen::Vector3d center_;
  const Eigen::Matrix3d world_from_cam_;
  std::vector<Eigen::Vector3f> normals_;
  Eigen::Vector3d to_key_light_, to_sky_;
  double diagonal_ = 1, near_ = 1, far_ = 1;
};

// Direction from the mesh to a camera at azimuth 0 on the horizon.
Eigen::Vector3d FrontDirection(const Eigen::Vector3d& up, const Eigen::Vector3d& wanted) {
  const Eigen::Vector3d front = wanted - wanted.dot(up) * up;
  return front.norm() > 1e-6 * wanted.norm() ? front.normalized() : up.unitOrthogonal();
}

// Rotation of a camera at the given angles that looks at the origin; its y axis points down.
Eigen::Matrix3d TurntableRotation(const TurntableOptions& options) {
  const Eigen::Vector3d up = options.up.normalized();
  const Eigen::Vector3d front = FrontDirection(up, options.front), side = up.cross(front);
  const double azimuth = options.azimuth_deg * kPi / 180;
  const double elevation = options.elevation_deg * kPi / 180;
  const Eigen::Vector3d outward = std::cos(azimuth) * front + std::sin(azimuth) * side;
  Eigen::Matrix3d rotation;
  rotation.row(2) = -(std::cos(elevation) * outward + std::sin(elevation) * up);
  rotation.row(1) = -(std::cos(elevation) * up - std::sin(elevation) * outward);
  rotation.row(0) = Eigen::Vector3d(rotation.row(1)).cross(Eigen::Vector3d(rotation.row(2)));
  return rotation;
}

// Middle of the box that holds `share` of the vertices along each axis of `rotation`.
Eigen::Vector3d FitCenter(const std::vector<Eigen::Vector3d>& points, double share) {
  Eigen::Vector3d center;
  std::vector<double> values(points.size());
  const size_t cut = static_cast<size_t>(0.5 * (1 - share) * static_cast<double>(points.size()));
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    const double low = ValueOfRank(&values, cut);
    center[axis] = 0.5 * (low + ValueOfRank(&values, values.size() - 1 - cut));
  }
  return center;
}

// How far before the camera the center must lie so that `share` of the points fall into the middle
// 94 % of the image.
double FitDistance(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& center,
                   double share, const PinholeCamera& camera) {
  const double half_width = 0.47 * camera.width, half_height = 0.47 * camera.height;
  std::vector<double> needed;
  needed.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d x = point - center;
    needed.push_back(std::max(std::abs(x.x()) * camera.fx / half_width,
                              std::abs(x.y()) * camera.fy / half_height) -
                     x.z());
  }
  return std::max(Quantile(&needed, share), 1e-9);
}

}  // namespace

void RenderOptions::Describe(OptionSet* options) {
  options->AddEnum<RenderStyle>("style", &style,
                                "How the mesh looks: shaded (clay), color (texture or vertex "
                                "colours), lit (both), normals, depth",
                                {{"shaded", RenderStyle::kShaded},
                                 {"color", RenderStyle::kColor},
                                 {"lit", RenderStyle::kLit},
                                 {"normals", RenderStyle::kNormals},
                                 {"depth", RenderStyle::kDepth}});
  options->Add("antialiasing", &antialiasing, "Rays per pixel are the square of this", {1, 16});
  options->Add("num_occlusion_rays", &num_occlusion_rays,
               "Rays for soft shadows, per ray of the picture; 0: none", {0, 1024});
  options->Add("occlusion_radius", &occlusion_radius,
               "Reach of soft shadows, as a share of the mesh's diagonal", {1e-6, 10.0});
  options->Add("smooth", &smooth, "Interpolate normals; otherwise facets show");
  options->Add("background", &background, "Grey level behind the mesh, 255 is white", {0, 255});
}

PosedCamera TurntableViewpoint(const std::vector<Eigen::Vector3d>& points_in_world,
                               const TurntableOptions& options) {
  LSMVS_CHECK(options.width >= 1 && options.height >= 1);
  LSMVS_CHECK(options.fit_share > 0 && options.fit_share <= 1 && options.up.norm() > 0);
  const double focal = 1.4 * std::max(options.width, options.height);
  PosedCamera viewpoint;
  viewpoint.camera = {options.width, options.height,      focal,
                      focal,         0.5 * options.width, 0.5 * options.height};
  const Eigen::Matrix3d rotation = TurntableRotation(options);
  std::vector<Eigen::Vector3d> points;  // turned
  points.reserve(points_in_world.size());
  for (const Eigen::Vector3d& x : points_in_world) {
    if (x.allFinite()) points.push_back(rotation * x);
  }
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double distance = 1;
  if (!points.empty()) {
    center = FitCenter(points, options.fit_share);
    distance = FitDistance(points, center, options.fit_share, viewpoint.camera);
  }
  viewpoint.cam_from_world = Rigid3(rotation, Eigen::Vector3d(0, 0, distance) - center);
  return viewpoint;
}

ColorImage RenderMesh(const TriangleMesh& mesh, const MeshTracer& tracer,
                      const PosedCamera& viewpoint, const RenderOptions& options,
                      const RunContext& context, const TexturePages* texture) {
  RequireValid(options);
  const Renderer renderer(mesh, tracer, viewpoint, options, texture);
  ColorImage image(viewpoint.camera.width, viewpoint.camera.height);
  ParallelFor(context, static_cast<size_t>(image.height), 4, [&](size_t r) {
    const int row = static_cast<int>(r);
    for (int column = 0; column < image.width; ++column) {
      image(column, row) = renderer.Pixel(column, row);
    }
  });
  return image;
}

}  // namespace lsmvs
