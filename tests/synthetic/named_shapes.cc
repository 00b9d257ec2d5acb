#include "lsmvs/synthetic/named_shapes.h"

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/box_union.h"
#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/shape_union.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

Eigen::AlignedBox3d Box(double x0, double x1, double y0, double y1, double z0, double z1) {
  return {Eigen::Vector3d(x0, y0, z0), Eigen::Vector3d(x1, y1, z1)};
}

ShapePtr Boxes(std::vector<Eigen::AlignedBox3d> boxes) {
  return std::make_shared<BoxUnion>(std::move(boxes));
}

ShapePtr Union(std::vector<ShapePtr> parts) {
  return std::make_shared<ShapeUnion>(std::move(parts));
}

ShapePtr ThinWalls(double gsd) {
  const double half_gap = 2.5 * gsd, outer = half_gap + 3.0 * gsd;
  return Boxes({Box(-1.5, 1.5, -1.5, 1.5, -0.2, 0.0), Box(-1, 1, -outer, -half_gap, -0.1, 1.0),
                Box(-1, 1, half_gap, outer, -0.1, 1.0)});
}

ShapePtr Pole(double gsd) {
  const double radius = 3.0 * gsd;
  return Union({Boxes({Box(-1, 1, -1, 1, -0.2, 0.0)}),
                std::make_shared<Capsule>(Eigen::Vector3d(0, 0, -0.1),
                                          Eigen::Vector3d(0, 0, 1.0 - radius), radius)});
}

// Closed body between z = height(x, y) over [-half, half]^2 and a flat bottom, on a grid of `steps`
// x `steps` cells.
TriangleMesh HeightField(const std::function<double(double, double)>& height, double half,
                         double bottom, int steps) {
  TriangleMesh mesh;
  const auto vertex = [&](int i, int j) { return j * (steps + 1) + i; };
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= steps; ++i) {
      const double x = half * (2.0 * i / steps - 1), y = half * (2.0 * j / steps - 1);
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) {
      const int a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1);
      mesh.faces.insert(mesh.faces.end(), {{a, b, c}, {a, c, vertex(i, j + 1)}});
    }
  }
  // The rim, counter-clockwise seen from above, its copy at the bottom, and a fan that closes it.
  std::vector<int> rim;
  for (int i = 0; i < steps; ++i) rim.push_back(vertex(i, 0));
  for (int j = 0; j < steps; ++j) rim.push_back(vertex(steps, j));
  for (int i = steps; i > 0; --i) rim.push_back(vertex(i, steps));
  for (int j = steps; j > 0; --j) rim.push_back(vertex(0, j));
  const int first = static_cast<int>(mesh.vertices.size()), count = static_cast<int>(rim.size());
  for (const int v : rim) {
    mesh.vertices.emplace_back(mesh.vertices[v].x(), mesh.vertices[v].y(), bottom);
  }
  const int middle = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, bottom);
  for (int i = 0; i < count; ++i) {
    const int next = (i + 1) % count;
    mesh.faces.insert(mesh.faces.end(), {{rim[i], first + i, first + next},
                                         {rim[i], first + next, rim[next]},
                                         {first + next, first + i, middle}});
  }
  return mesh;
}

double HillHeight(double x, double y) {
  return 0.10 * std::sin(1.3 * x + 0.4) * std::cos(1.1 * y - 0.3) +
         0.05 * std::sin(2.9 * x - 1.0) * std::sin(2.3 * y + 0.7) +
         0.02 * std::cos(5.1 * x + 3.7 * y);
}

// Prism over [x0,x1] x [y0,y1] with eaves at z0 and the ridge at z1 along x; it reaches down to
// `base`.
ShapePtr Gable(const Eigen::AlignedBox3d& body, double ridge) {
  const Eigen::Vector3d a = body.min(), b = body.max();
  const double y = 0.5 * (a.y() + b.y());
  TriangleMesh mesh;
  mesh.vertices = {{a.x(), a.y(), a.z()}, {b.x(), a.y(), a.z()}, {b.x(), b.y(), a.z()},
                   {a.x(), b.y(), a.z()}, {a.x(), a.y(), b.z()}, {b.x(), a.y(), b.z()},
                   {b.x(), b.y(), b.z()}, {a.x(), b.y(), b.z()}, {a.x(), y, ridge},
                   {b.x(), y, ridge}};
  mesh.faces = {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {2, 3, 7}, {2, 7, 6},
                {1, 2, 6}, {1, 6, 9}, {1, 9, 5}, {3, 0, 4}, {3, 4, 8}, {3, 8, 7},
                {4, 5, 9}, {4, 9, 8}, {6, 7, 8}, {6, 8, 9}};
  return std::make_shared<MeshShape>(std::move(mesh));
}

ShapePtr Terrain() {
  constexpr int kSteps = 160;
  std::vector<ShapePtr> parts = {
      std::make_shared<MeshShape>(HeightField(HillHeight, 2.0, -0.6, kSteps))};
  std::vector<Eigen::AlignedBox3d> flat_roofs;
  const std::array<Eigen::Vector2d, 8> places = {{{-1.2, -1.0},
                                                  {-0.3, -1.2},
                                                  {0.7, -0.9},
                                                  {1.3, -0.1},
                                                  {-1.3, 0.2},
                                                  {-0.4, 0.0},
                                                  {0.4, 0.6},
                                                  {-0.9, 1.2}}};
  for (size_t i = 0; i < places.size(); ++i) {
    Random random(17, i);
    const double half_x = random.Uniform(0.14, 0.26), half_y = random.Uniform(0.12, 0.2);
    const double ground = HillHeight(places[i].x(), places[i].y());
    const Eigen::AlignedBox3d body =
        Box(places[i].x() - half_x, places[i].x() + half_x, places[i].y() - half_y,
            places[i].y() + half_y, ground - 0.25, ground + random.Uniform(0.2, 0.45));
    if (i % 2 == 0) {
      parts.push_back(Gable(body, body.max().z() + 0.8 * half_y));
    } else {
      flat_roofs.push_back(body);
      const Eigen::Vector3d inset(0.4 * half_x, 0.4 * half_y, 0.0);
      flat_roofs.emplace_back(body.min() + inset, body.max() - inset + Eigen::Vector3d(0, 0, 0.1));
    }
  }
  parts.push_back(Boxes(flat_roofs));
  return Union(std::move(parts));
}

// A facade: everything reaches back to y = 0.4, so that parts overlap instead of touching.
ShapePtr Relief() {
  std::vector<Eigen::AlignedBox3d> boxes = {Box(-2.2, 2.2, -1.4, 0.4, -0.2, 0.0),    // floor
                                            Box(-2.0, 2.0, 0.0, 0.4, -0.1, 2.4),     // wall
                                            Box(-2.0, 2.0, -0.10, 0.4, -0.1, 0.25),  // plinth
                                            Box(-2.0, 2.0, -0.12, 0.4, 2.10, 2.4),   // cornice
                                            Box(-2.0, 2.0, -0.20, 0.4, 2.25, 2.35),
                                            Box(-2.0, 2.0, -0.06, 0.4, 1.15, 1.25)};  // belt
  for (const double x : {-1.9, -0.95, 0.95, 1.9}) {                                   // pilasters
    boxes.push_back(Box(x - 0.08, x + 0.08, -0.08, 0.4, -0.1, 2.3));
    boxes.push_back(Box(x - 0.12, x + 0.12, -0.14, 0.4, 1.95, 2.05));
  }
  for (const double x : {-1.43, 1.43}) {
    for (const double z : {0.45, 1.4}) {  // window frames around niches
      boxes.push_back(Box(x - 0.30, x - 0.22, -0.07, 0.4, z, z + 0.55));
      boxes.push_back(Box(x + 0.22, x + 0.30, -0.07, 0.4, z, z + 0.55));
      boxes.push_back(Box(x - 0.34, x + 0.34, -0.11, 0.4, z + 0.5, z + 0.6));
      boxes.push_back(Box(x - 0.34, x + 0.34, -0.13, 0.4, z - 0.05, z + 0.02));
    }
  }
  for (int step = 0; step < 3; ++step) {  // stairs before the door
    boxes.push_back(Box(-0.55, 0.55, -0.55 + 0.12 * step, 0.4, -0.1, 0.07 * (step + 1)));
  }
  boxes.push_back(Box(-0.45, -0.35, -0.10, 0.4, 0.0, 1.05));
  boxes.push_back(Box(0.35, 0.45, -0.10, 0.4, 0.0, 1.05));
  boxes.push_back(Box(-0.55, 0.55, -0.16, 0.4, 0.98, 1.08));
  std::vector<ShapePtr> parts = {Boxes(boxes)};
  const auto add_sphere = [&](double x, double y, double z, double radius) {
    parts.push_back(std::make_shared<Sphere>(Eigen::Vector3d(x, y, z), radius));
  };
  add_sphere(0.0, 0.08, 1.65, 0.30);
  for (const double x : {-1.43, 1.43}) {
    add_sphere(x, 0.06, 0.72, 0.16);
    add_sphere(x, 0.06, 1.66, 0.16);
  }
  for (const double x : {-0.7, 0.7}) {
    parts.push_back(std::make_shared<Capsule>(Eigen::Vector3d(x, -0.35, -0.1),
                                              Eigen::Vector3d(x, -0.35, 0.95), 0.08));
  }
  return Union(std::move(parts));
}

}  // namespace

ShapePtr MakeShape(ShapeName name, double gsd) {
  switch (name) {
    case ShapeName::kSphere:
      return std::make_shared<Sphere>(Eigen::Vector3d::Zero(), 1.0);
    case ShapeName::kBox:
      return Boxes({Box(-1, 1, -0.8, 0.8, -0.6, 0.6)});
    case ShapeName::kTorus:
      return std::make_shared<Torus>(Eigen::Vector3d::Zero(), 1.0, 0.4);
    case ShapeName::kStep:
      return Boxes({Box(-1.5, 1.5, -1.5, 1.5, -0.5, 0.0), Box(0, 1.5, -1.5, 1.5, -0.5, 0.3)});
    case ShapeName::kThinWalls:
      return ThinWalls(gsd);
    case ShapeName::kPole:
      return Pole(gsd);
    case ShapeName::kSphereOnGround:
      return Union({Boxes({Box(-1.5, 1.5, -1.5, 1.5, -0.3, 0.0)}),
                    std::make_shared<Sphere>(Eigen::Vector3d(0, 0, 0.65), 0.7)});
    case ShapeName::kTerrain:
      return Terrain();
    case ShapeName::kRelief:
      return Relief();
    case ShapeName::kTown: {
      const Town town(TownOptions(), 6);
      return std::make_shared<MeshShape>(town.Mesh(0, town.lots_per_side()));
    }
  }
  LSMVS_CHECK(false);
  return nullptr;
}

}  // namespace lsmvs
