#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <tuple>

#include "lsmvs/evaluation/mesh_tracer.h"
#include "lsmvs/geometry/distances.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/repair.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "simple_meshes.h"

namespace lsmvs {
namespace {

// Rounding of the tracer that measures.
constexpr double kRounding = 1e-6;

// Joins vertices at one place: closes what UnitSquareMesh leaves open.
void Weld(TriangleMesh* mesh) {
  std::map<std::tuple<double, double, double>, int> index;
  std::vector<int> renamed;
  for (const Eigen::Vector3d& x : mesh->vertices) {
    const auto round = [](double c) { return std::round(c * 1e9); };
    renamed.push_back(index
                          .try_emplace({round(x.x()), round(x.y()), round(x.z())},
                                       static_cast<int>(renamed.size()))
                          .first->second);
  }
  for (Eigen::Vector3i& face : mesh->faces) {
    for (int& v : face) v = renamed[static_cast<size_t>(v)];
  }
  RemoveUnusedVertices(mesh);
}

TriangleMesh TorusMesh(int n) {
  TriangleMesh mesh = UnitSquareMesh(n, [](double s, double t) {
    const double u = 2 * std::numbers::pi * s, v = 2 * std::numbers::pi * t;
    const double r = 1 + 0.4 * std::cos(v);
    return Eigen::Vector3d(r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v));
  });
  Weld(&mesh);
  return mesh;
}

// Open at both ends.
TriangleMesh CylinderMesh(int n) {
  TriangleMesh mesh = UnitSquareMesh(n, [](double s, double t) {
    const double u = 2 * std::numbers::pi * s;
    return Eigen::Vector3d(std::cos(u), std::sin(u), 2 * t);
  });
  Weld(&mesh);
  return mesh;
}

TriangleMesh CubeMesh(int n) {
  TriangleMesh cube;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double at = side % 2;
    const TriangleMesh face = UnitSquareMesh(n, [&](double s, double t) {
      Eigen::Vector3d x;
      x[axis] = at;
      x[(axis + 1) % 3] = at > 0 ? s : t;
      x[(axis + 2) % 3] = at > 0 ? t : s;
      return x;
    });
    const int first = static_cast<int>(cube.vertices.size());
    cube.vertices.insert(cube.vertices.end(), face.vertices.begin(), face.vertices.end());
    for (const Eigen::Vector3i& f : face.faces) cube.faces.emplace_back(f.array() + first);
  }
  Weld(&cube);
  return cube;
}

std::vector<double> Uniform(const TriangleMesh& mesh, double tolerance) {
  return std::vector<double>(mesh.vertices.size(), tolerance);
}

SimplifiedMesh Simplify(const TriangleMesh& mesh, double tolerance) {
  return SimplifyWithinTolerance(mesh, Uniform(mesh, tolerance), {}, RunContext(2));
}

// Largest distance of points of a mesh, corners and edges among them, from another.
double LargestDistance(const TriangleMesh& from, const TriangleMesh& to) {
  const MeshTracer tracer(to, RunContext(2));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  double largest = 0;
  for (const Eigen::Vector3i& f : from.faces) {
    for (int k = 0; k < 12; ++k) {
      Eigen::Vector3d weights(number(random), number(random), number(random));
      if (k < 3) weights = Eigen::Vector3d::Unit(k);
      if (k >= 3 && k < 6) weights[k - 3] = 0;
      weights /= weights.sum();
      const Eigen::Vector3d x = weights[0] * from.vertices[f[0]] +
                                weights[1] * from.vertices[f[1]] + weights[2] * from.vertices[f[2]];
      largest = std::max(largest, tracer.Closest(x)->distance);
    }
  }
  return largest;
}

// Largest distance of points of the border from the other mesh's border.
double LargestBorderDistance(const TriangleMesh& from, const TriangleMesh& to) {
  double largest = 0;
  const auto loops = FindBorderLoops(to);
  for (const auto& loop : FindBorderLoops(from)) {
    for (size_t i = 0; i < loop.size(); ++i) {
      const Eigen::Vector3d &a = from.vertices[loop[i]],
                            &b = from.vertices[loop[(i + 1) % loop.size()]];
      for (const double share : {0.0, 0.3, 0.5, 0.8}) {
        const Eigen::Vector3d x = a + share * (b - a);
        double least = std::numeric_limits<double>::infinity();
        for (const auto& other : loops) {
          for (size_t k = 0; k < other.size(); ++k) {
            const Eigen::Vector3d on = ClosestOnSegment(x, to.vertices[other[k]],
                                                        to.vertices[other[(k + 1) % other.size()]]);
            least = std::min(least, (on - x).norm());
          }
        }
        largest = std::max(largest, least);
      }
    }
  }
  return largest;
}

void ExpectWithin(const TriangleMesh& input, const SimplifiedMesh& result, double tolerance) {
  ExpectValidMesh(result.mesh);
  EXPECT_LE(LargestDistance(input, result.mesh), tolerance + kRounding);
  EXPECT_LE(LargestDistance(result.mesh, input), tolerance + kRounding);
  EXPECT_LE(LargestBorderDistance(input, result.mesh), tolerance + kRounding);
  EXPECT_LE(LargestBorderDistance(result.mesh, input), tolerance + kRounding);
  ASSERT_EQ(result.source_vertex.size(), result.mesh.vertices.size());
  const std::vector<uint8_t> all(result.mesh.faces.size(), 1);
  EXPECT_TRUE(
      FaceGrid(result.mesh.vertices, result.mesh.faces).CrossingPairs(all, RunContext(1)).empty());
}

// Least of twice the area over the longest edge squared.
double LeastFlatness(const TriangleMesh& mesh) {
  double least = 1;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& v = mesh.faces[f];
    double longest = 0;
    for (int k = 0; k < 3; ++k) {
      longest =
          std::max(longest, (mesh.vertices[v[k]] - mesh.vertices[v[(k + 1) % 3]]).squaredNorm());
    }
    least = std::min(least, FaceNormalTimesTwiceArea(mesh, f).norm() / longest);
  }
  return least;
}

TEST(SimplifyWithinTolerance, Sphere) {
  const TriangleMesh sphere = SphereMesh(5);
  for (const double tolerance : {2e-3, 1e-2, 5e-2}) {
    const SimplifiedMesh result = Simplify(sphere, tolerance);
    ExpectWithin(sphere, result, tolerance);
    ExpectValidClosedMesh(result.mesh);
    EXPECT_EQ(Inspect(result.mesh).Genus(), 0);
    // The largest equilateral triangle within tolerance of the sphere has a circumradius of 2
    // sqrt(tolerance).
    const double best = 4 * std::numbers::pi / (3 * std::numbers::sqrt3 * tolerance);
    EXPECT_LT(static_cast<double>(result.mesh.faces.size()), 2.4 * best);
    EXPECT_NEAR(Inspect(result.mesh).volume, Inspect(sphere).volume,
                4 * std::numbers::pi * tolerance);
    EXPECT_GT(LeastFlatness(result.mesh), 0.049);
  }
}

TEST(SimplifyWithinTolerance, FlatSquareKeepsItsCorners) {
  const TriangleMesh square =
      UnitSquareMesh(30, [](double x, double y) { return Eigen::Vector3d(x, y, 0.5 * x + 2 * y); });
  const SimplifiedMesh result = Simplify(square, 1e-4);
  ExpectWithin(square, result, 1e-4);
  EXPECT_LT(result.mesh.faces.size(), 30u);
  EXPECT_NEAR(Inspect(result.mesh).area, Inspect(square).area, 1e-3);
  for (const int corner : {0, 30, 30 * 31, 31 * 31 - 1}) {
    EXPECT_NE(std::find(result.mesh.vertices.begin(), result.mesh.vertices.end(),
                        square.vertices[static_cast<size_t>(corner)]),
              result.mesh.vertices.end());
  }
}

TEST(SimplifyWithinTolerance, BordersOfHolesStay) {
  TriangleMesh plate = UnitSquareMesh(40, [](double x, double y) {
    return Eigen::Vector3d(x, y, 0.05 * std::sin(6 * x) * std::cos(5 * y));
  });
  FilterFaces(&plate, [&](size_t f) {
    const Eigen::Vector3d middle = plate.vertices[plate.faces[f][0]];
    return (middle - Eigen::Vector3d(0.5, 0.5, middle.z())).norm() > 0.2;
  });
  RemoveUnusedVertices(&plate);
  for (const double tolerance : {1e-3, 5e-3, 3e-2}) {
    const SimplifiedMesh result = Simplify(plate, tolerance);
    ExpectWithin(plate, result, tolerance);
    EXPECT_EQ(FindBorderLoops(result.mesh).size(), 2u);
    EXPECT_LT(result.mesh.faces.size(), plate.faces.size() * 2 / 3);
  }
}

TEST(SimplifyWithinTolerance, TorusStaysATorus) {
  const TriangleMesh torus = TorusMesh(48);
  for (const double tolerance : {5e-3, 5e-2}) {
    const SimplifiedMesh result = Simplify(torus, tolerance);
    ExpectWithin(torus, result, tolerance);
    EXPECT_EQ(Inspect(result.mesh).Genus(), 1);
    EXPECT_LT(result.mesh.faces.size(), torus.faces.size() / 2);
  }
}

TEST(SimplifyWithinTolerance, CylinderKeepsItsRims) {
  const TriangleMesh cylinder = CylinderMesh(64);
  const SimplifiedMesh result = Simplify(cylinder, 0.01);
  ExpectWithin(cylinder, result, 0.01);
  EXPECT_EQ(FindBorderLoops(result.mesh).size(), 2u);
  EXPECT_LT(result.mesh.faces.size(), cylinder.faces.size() / 10);
}

TEST(SimplifyWithinTolerance, CubeKeepsItsEdges) {
  const TriangleMesh cube = CubeMesh(16);
  ExpectValidClosedMesh(cube);
  const SimplifiedMesh result = Simplify(cube, 1e-3);
  ExpectWithin(cube, result, 1e-3);
  EXPECT_LT(result.mesh.faces.size(), cube.faces.size() / 7);
  EXPECT_NEAR(Inspect(result.mesh).volume, 1, 6e-3);
}

TEST(SimplifyWithinTolerance, KeepsToItOnRoughSurfaces) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.004);
  const TriangleMesh rough = UnitSquareMesh(60, [&](double x, double y) {
    return Eigen::Vector3d(x, y, 0.1 * std::sin(9 * x * y) + noise(random));
  });
  size_t last = rough.faces.size() + 1;
  for (const double tolerance : {0.002, 0.005, 0.01, 0.02}) {
    const SimplifiedMesh result = Simplify(rough, tolerance);
    ExpectWithin(rough, result, tolerance);
    EXPECT_LT(result.mesh.faces.size(), last);
    last = result.mesh.faces.size();
  }
  EXPECT_LT(last, rough.faces.size() / 10);
}

TEST(SimplifyWithinTolerance, ToleranceMayVary) {
  const TriangleMesh sphere = SphereMesh(5);
  std::vector<double> tolerance;
  for (const Eigen::Vector3d& x : sphere.vertices) tolerance.push_back(x.z() > 0 ? 0.02 : 0.002);
  const SimplifiedMesh result = SimplifyWithinTolerance(sphere, tolerance, {}, RunContext(1));
  ExpectValidClosedMesh(result.mesh);
  const MeshTracer tracer(result.mesh, RunContext(1));
  for (size_t v = 0; v < tolerance.size(); ++v) {
    EXPECT_LE(tracer.Closest(sphere.vertices[v])->distance, tolerance[v] + kRounding);
  }
  size_t num_coarse = 0;
  for (const Eigen::Vector3d& x : result.mesh.vertices) num_coarse += x.z() > 0;
  EXPECT_LT(4 * num_coarse, result.mesh.vertices.size() - num_coarse);
}

TEST(SimplifyWithinTolerance, NoToleranceKeepsTheSurface) {
  const TriangleMesh sphere = SphereMesh(3);
  const SimplifiedMesh same = Simplify(sphere, 0);
  EXPECT_EQ(same.mesh.faces.size(), sphere.faces.size());
  const TriangleMesh square =
      UnitSquareMesh(8, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  const SimplifiedMesh result = Simplify(square, 0);
  EXPECT_NEAR(LargestDistance(square, result.mesh), 0, kRounding);
  EXPECT_NEAR(Inspect(result.mesh).area, 1, 1e-12);
}

TEST(SimplifyWithinTolerance, SheetsNearEachOtherDoNotCross) {
  TriangleMesh sheets;
  for (int sheet = 0; sheet < 2; ++sheet) {
    const TriangleMesh one = UnitSquareMesh(50, [&](double x, double y) {
      return Eigen::Vector3d(x, y, 0.05 * std::sin(8 * x) * std::sin(7 * y) + 0.004 * sheet);
    });
    const int first = static_cast<int>(sheets.vertices.size());
    sheets.vertices.insert(sheets.vertices.end(), one.vertices.begin(), one.vertices.end());
    for (const Eigen::Vector3i& f : one.faces) sheets.faces.emplace_back(f.array() + first);
  }
  const SimplifiedMesh result = Simplify(sheets, 0.01);
  ExpectWithin(sheets, result, 0.01);  // and nothing crosses
  EXPECT_LT(result.mesh.faces.size(), sheets.faces.size() / 3);
}

TEST(SimplifyWithinTolerance, SameForAnyNumberOfThreadsAndAnyPlace) {
  TriangleMesh torus = TorusMesh(40);
  const auto run = [&](int num_threads) {
    return SimplifyWithinTolerance(torus, Uniform(torus, 0.01), {}, RunContext(num_threads));
  };
  const SimplifiedMesh one = run(1), four = run(4);
  EXPECT_EQ(one.mesh.vertices, four.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, four.mesh.faces);
  EXPECT_EQ(one.source_vertex, four.source_vertex);
  for (Eigen::Vector3d& x : torus.vertices) x += Eigen::Vector3d(4096, -2048, 1024);
  const SimplifiedMesh moved = run(1);
  EXPECT_NEAR(static_cast<double>(moved.mesh.faces.size()),
              static_cast<double>(one.mesh.faces.size()),
              0.02 * static_cast<double>(one.mesh.faces.size()));
}

TEST(SimplifyWithinTolerance, StopsAtTheShareOfFaces) {
  const TriangleMesh sphere = SphereMesh(5);
  BoundedSimplificationOptions options;
  options.target_face_ratio = 0.5;
  const SimplifiedMesh result =
      SimplifyWithinTolerance(sphere, Uniform(sphere, 0.05), options, RunContext(1));
  EXPECT_NEAR(static_cast<double>(result.mesh.faces.size()),
              0.5 * static_cast<double>(sphere.faces.size()), 2);
}

TEST(SimplifyWithinTolerance, ColoursAreThoseOfTheInputAtThePlace) {
  TriangleMesh square = UnitSquareMesh(40, [](double x, double y) {
    return Eigen::Vector3d(x, y, 0.1 * std::sin(5 * x) * std::sin(4 * y));
  });
  for (const Eigen::Vector3d& x : square.vertices) {
    square.vertex_colors.emplace_back(static_cast<uint8_t>(std::lround(250 * x.x())),
                                      static_cast<uint8_t>(std::lround(250 * x.y())), 7);
  }
  square.vertex_normals = ComputeVertexNormals(square);
  square.vertex_quality.assign(square.vertices.size(), 0.25f);
  const SimplifiedMesh result = Simplify(square, 0.005);
  EXPECT_EQ(result.mesh.vertex_quality, std::vector<float>(result.mesh.vertices.size(), 0.25f));
  ASSERT_EQ(result.mesh.vertex_colors.size(), result.mesh.vertices.size());
  ASSERT_EQ(result.mesh.vertex_normals.size(), result.mesh.vertices.size());
  for (size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    EXPECT_NEAR(result.mesh.vertex_colors[v][0], 250 * result.mesh.vertices[v].x(), 2);
    EXPECT_NEAR(result.mesh.vertex_colors[v][1], 250 * result.mesh.vertices[v].y(), 2);
    EXPECT_EQ(result.mesh.vertex_colors[v][2], 7);
    EXPECT_GT(result.mesh.vertex_normals[v].z(), 0.5f);
  }
}

TEST(SimplifyWithinTolerance, ValuesComeFromTheNearestVertices) {
  const TriangleMesh sphere = SphereMesh(5);
  const SimplifiedMesh result = Simplify(sphere, 0.01);
  std::vector<double> heights;
  for (const Eigen::Vector3d& x : sphere.vertices) heights.push_back(x.z());
  const std::vector<double> carried = CarryToSimplified(result, heights);
  ASSERT_EQ(carried.size(), result.mesh.vertices.size());
  for (size_t v = 0; v < carried.size(); ++v) {
    EXPECT_NEAR(carried[v], result.mesh.vertices[v].z(), 0.05);  // the input's edges are as long
  }
  EXPECT_TRUE(CarryToSimplified(result, std::vector<float>()).empty());
}

TEST(SimplifyWithinTolerance, IrregularPlacesStay) {
  // Three fins on one edge, a cone tip that touches another sheet, and bad faces.
  TriangleMesh mesh =
      UnitSquareMesh(20, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  const TriangleMesh fin =
      UnitSquareMesh(20, [](double x, double y) { return Eigen::Vector3d(x, 0.5, y); });
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), fin.vertices.begin(), fin.vertices.end());
  for (const Eigen::Vector3i& f : fin.faces) mesh.faces.emplace_back(f.array() + first);
  Weld(&mesh);
  const MeshInspection before = Inspect(mesh);
  ASSERT_EQ(before.num_nonmanifold_edges, 20u);
  const int nan = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  mesh.vertices.emplace_back(9, 9, 9);
  mesh.faces.emplace_back(0, 1, nan);
  mesh.faces.emplace_back(3, 3, 4);
  const SimplifiedMesh result = Simplify(mesh, 1e-3);
  const MeshInspection after = Inspect(result.mesh);
  EXPECT_EQ(after.num_nonmanifold_edges, 20u);
  EXPECT_EQ(after.num_degenerate_faces, 0u);
  EXPECT_EQ(after.num_unused_vertices, 0u);
  EXPECT_NEAR(after.area, before.area, 1e-3);
  EXPECT_LT(after.num_faces, before.num_faces / 3);
  for (const Eigen::Vector3d& x : result.mesh.vertices) EXPECT_TRUE(x.allFinite());
}

TEST(SimplifyWithinTolerance, TakesBordersThatMeetInAVertex) {
  TriangleMesh mesh =
      UnitSquareMesh(20, [](double x, double y) { return Eigen::Vector3d(x, y, 0); });
  // Two square holes with a common corner.
  FilterFaces(&mesh, [&](size_t f) {
    Eigen::Vector3d m = Eigen::Vector3d::Zero();
    for (const int v : mesh.faces[f]) m += mesh.vertices[v] / 3;
    const auto in = [&](double low, double high) {
      return m.x() > low && m.x() < high && m.y() > low && m.y() < high;
    };
    return !in(0.3, 0.5) && !in(0.5, 0.7);
  });
  RemoveUnusedVertices(&mesh);
  ASSERT_EQ(Inspect(mesh).num_nonmanifold_vertices, 1u);
  const SimplifiedMesh result = Simplify(mesh, 1e-3);
  EXPECT_EQ(Inspect(result.mesh).num_nonmanifold_vertices, 1u);
  EXPECT_EQ(Inspect(result.mesh).num_nonmanifold_edges, 0u);
  EXPECT_NEAR(Inspect(result.mesh).area, 1 - 0.08, 1e-3);
  EXPECT_LT(result.mesh.faces.size(), 120u);
}

TEST(SimplifyWithinTolerance, EmptyAndWrongArguments) {
  EXPECT_TRUE(Simplify({}, 1).mesh.faces.empty());
  EXPECT_THROW(SimplifyWithinTolerance(SphereMesh(1), {1, 2}, {}, RunContext(1)), std::logic_error);
  BoundedSimplificationOptions options;
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.target_face_ratio = 1.5;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THROW(
      SimplifyWithinTolerance(SphereMesh(1), Uniform(SphereMesh(1), 1), options, RunContext(1)),
      std::logic_error);
}

}  // namespace
}  // namespace lsmvs
