#include "lsmvs/evaluation/mesh_tracer.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <vector>

#include "lsmvs/evaluation/rays/embree.h"
#include "lsmvs/geometry/distances.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr double kMaxFloat = std::numeric_limits<float>::max();

Eigen::Vector3d Middle(const std::vector<Eigen::Vector3d>& vertices) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : vertices) {
    if (x.allFinite()) box.extend(x);
  }
  return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center());
}

bool IsFinite(const TriangleMesh& mesh, const Eigen::Vector3i& face) {
  for (int k = 0; k < 3; ++k) {
    if (!mesh.vertices[face[k]].allFinite()) return false;
  }
  return true;
}

float ToFloat(double value) { return static_cast<float>(std::min(value, kMaxFloat)); }

template <class Ray>
void FillRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double begin,
             double end, Ray* ray) {
  const Eigen::Vector3f o = origin.cast<float>(), d = direction.cast<float>();
  ray->org_x = o.x(), ray->org_y = o.y(), ray->org_z = o.z();
  ray->dir_x = d.x(), ray->dir_y = d.y(), ray->dir_z = d.z();
  ray->tnear = static_cast<float>(begin);
  ray->tfar = ToFloat(end);
  ray->time = 0;
  ray->mask = ~0u;
  ray->id = 0;
  ray->flags = 0;
}

}  // namespace

struct MeshTracer::State {
  State(const TriangleMesh& mesh, int num_threads) : center(Middle(mesh.vertices)) {
    device = rtcNewDevice(fmt::format("threads={}", num_threads).c_str());
    if (device == nullptr) {
      throw Error(ExitCode::kInternal, "the ray tracer (Embree) does not start on this machine");
    }
    CopyMesh(mesh);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    if (!triangles.empty()) Attach();
    rtcCommitScene(scene);
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
      Release();
      if (error == RTC_ERROR_OUT_OF_MEMORY) {
        throw MemoryError("no memory to trace rays through the mesh; use a smaller mesh");
      }
      throw Error(ExitCode::kInternal, fmt::format("Embree fails with error {}", int{error}));
    }
  }
  ~State() { Release(); }

  void Release() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  void CopyMesh(const TriangleMesh& mesh) {
    const int num_vertices = static_cast<int>(mesh.vertices.size());
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      const Eigen::Vector3i& face = mesh.faces[f];
      LSMVS_CHECK(face.minCoeff() >= 0 && face.maxCoeff() < num_vertices);
      if (!IsFinite(mesh, face)) {
        ++num_left_out;
        continue;
      }
      triangles.push_back(face.cast<uint32_t>());
      face_of_triangle.push_back(static_cast<int>(f));
    }
    if (num_left_out == 0) face_of_triangle = {};
    vertices.reserve(mesh.vertices.size() + 1);
    for (const Eigen::Vector3d& x : mesh.vertices) {
      vertices.emplace_back(Eigen::Vector3f::Zero());
      if (x.allFinite()) vertices.back() = (x - center).cast<float>();
    }
    vertices.push_back(Eigen::Vector3f::Zero());  // Embree reads 16 bytes per vertex
  }

  void Attach() {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               vertices.data(), 0, sizeof(Eigen::Vector3f), vertices.size() - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               triangles.data(), 0, sizeof(Triple), triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  int FaceOf(unsigned triangle) const {
    return face_of_triangle.empty() ? static_cast<int>(triangle) : face_of_triangle[triangle];
  }
  Triangle3 Corners(unsigned triangle) const {
    const Triple& t = triangles[triangle];
    return {vertices[t[0]].cast<double>(), vertices[t[1]].cast<double>(),
            vertices[t[2]].cast<double>()};
  }

  using Triple = Eigen::Matrix<uint32_t, 3, 1>;
  Eigen::Vector3d center;
  std::vector<Eigen::Vector3f> vertices;  // minus center
  std::vector<Triple> triangles;
  std::vector<int> face_of_triangle;  // empty: the same
  size_t num_left_out = 0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

MeshTracer::MeshTracer(const TriangleMesh& mesh, const RunContext& context)
    : state_(std::make_unique<State>(mesh, context.num_threads())) {}

MeshTracer::~MeshTracer() = default;

size_t MeshTracer::num_faces() const { return state_->triangles.size(); }
size_t MeshTracer::num_left_out() const { return state_->num_left_out; }

std::optional<MeshHit> MeshTracer::Cast(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction, double begin,
                                        double end) const {
  RTCRayHit query;
  FillRay(origin - state_->center, direction, begin, end, &query.ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  IntersectRay(state_->scene, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return MeshHit{query.ray.tfar, state_->FaceOf(query.hit.primID), query.hit.u, query.hit.v};
}

bool MeshTracer::Occluded(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double begin, double end) const {
  RTCRay ray;
  FillRay(origin - state_->center, direction, begin, end, &ray);
  OccludeRay(state_->scene, &ray);
  return ray.tfar < 0;
}

std::optional<ClosestPoint> MeshTracer::Closest(const Eigen::Vector3d& x_in_world,
                                                double max_distance) const {
  struct Search {
    const State* state;
    Eigen::Vector3d target;
    double squared_distance;
    int face = -1;
    Eigen::Vector3d closest = Eigen::Vector3d::Zero();
  };
  const Eigen::Vector3d target = x_in_world - state_->center;
  Search search{state_.get(), target, max_distance * max_distance};
  const auto visit = [](RTCPointQueryFunctionArguments* arguments) {
    Search& s = *static_cast<Search*>(arguments->userPtr);
    const Eigen::Vector3d x = ClosestOnTriangle(s.target, s.state->Corners(arguments->primID));
    const double squared = (x - s.target).squaredNorm();
    if (!(squared < s.squared_distance)) return false;
    s.squared_distance = squared;
    s.face = s.state->FaceOf(arguments->primID);
    s.closest = x;
    // A little more than the distance, so that rounding to float cuts nothing off.
    arguments->query->radius = ToFloat(std::sqrt(squared) * (1 + 1e-6));
    return true;
  };
  RTCPointQuery query;
  const Eigen::Vector3f target_float = target.cast<float>();
  query.x = target_float.x(), query.y = target_float.y(), query.z = target_float.z();
  query.time = 0;
  query.radius = ToFloat(max_distance * (1 + 1e-6));
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(state_->scene, &query, &context, visit, &search);
  if (search.face < 0) return std::nullopt;
  return ClosestPoint{std::sqrt(search.squared_distance), search.face,
                      search.closest + state_->center};
}

Raster<float> TraceDepth(const MeshTracer& tracer, const PinholeCamera& camera,
                         const Rigid3& cam_from_world, const RunContext& context) {
  Raster<float> depth(camera.width, camera.height, 0.0f);
  const Eigen::Vector3d center = cam_from_world.OriginInSource();
  const Eigen::Matrix3d world_from_cam = cam_from_world.rotation.transpose();
  ParallelFor(context, static_cast<size_t>(camera.height), 8, [&](size_t r) {
    const int row = static_cast<int>(r);
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector3d direction = world_from_cam * camera.PixelRay(column, row);
      if (const auto hit = tracer.Cast(center, direction)) {
        depth(column, row) = static_cast<float>(hit->distance);
      }
    }
  });
  return depth;
}

}  // namespace lsmvs
