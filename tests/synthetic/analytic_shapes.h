#pragma once

#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// Area 4 pi r^2, volume 4/3 pi r^3, genus 0.
class Sphere : public Shape {
 public:
  Sphere(const Eigen::Vector3d& center, double radius) : center_(center), radius_(radius) {}

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  Eigen::Vector3d center_;
  double radius_;
};

// Around the z axis through `center`: `major_radius` to the middle of the tube, `minor_radius` of
// the tube. Area 4 pi^2 R r, volume 2 pi^2 R r^2, genus 1. Rays are intersected by sphere tracing.
class Torus : public Shape {
 public:
  Torus(const Eigen::Vector3d& center, double major_radius, double minor_radius)
      : center_(center), major_radius_(major_radius), minor_radius_(minor_radius) {}

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  Eigen::Vector3d center_;
  double major_radius_, minor_radius_;
};

// All points within `radius` of the segment from `a` to `b` (distinct): a pole with rounded ends.
// Area 2 pi r L + 4 pi r^2.
class Capsule : public Shape {
 public:
  Capsule(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius)
      : a_(a), b_(b), radius_(radius) {}

  std::optional<RayHit> Intersect(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const override;
  SurfacePoint Closest(const Eigen::Vector3d& x) const override;
  Eigen::AlignedBox3d Bounds() const override;
  TriangleMesh Mesh(double edge_length) const override;

 private:
  Eigen::Vector3d a_, b_;
  double radius_;
};

}  // namespace lsmvs
