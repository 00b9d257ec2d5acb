#include "lsmvs/merging/mesh_merger.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lsmvs/evaluation/surface_evaluator.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/mesh/inspect.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/synthetic/analytic_shapes.h"
#include "lsmvs/synthetic/overlapping_pieces.h"
#include "lsmvs/test_support/expect_valid_mesh.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

struct PieceOptions {
  double edge_length = 0.1;
  double noise = 0;       // standard deviation, in edge lengths
  bool is_smooth = true;  // over some edges, or every vertex for itself
  double offset = 0;      // in edge lengths, along (0, 0.6, 0.8)
};

// Half the width of the pieces' overlap.
constexpr double kHalfOverlap = 0.8;
// Of F1: a few standard errors of 40,000 samples.
constexpr double kScoreError = 0.002;

enum class World { kSphere, kTorus, kRelief };

TriangleMesh TruthOf(World world, double edge_length, uint64_t seed) {
  TriangleMesh mesh;
  if (world == World::kSphere) mesh = Sphere(Eigen::Vector3d::Zero(), 2).Mesh(edge_length);
  if (world == World::kTorus) mesh = Torus(Eigen::Vector3d::Zero(), 2, 0.8).Mesh(edge_length);
  if (world == World::kRelief) return ReliefMesh(edge_length, seed);
  // Another tessellation of the same shape for each seed.
  const Eigen::AngleAxisd turn(0.3 * static_cast<double>(seed), Eigen::Vector3d::UnitZ());
  for (Eigen::Vector3d& x : mesh.vertices) x = turn * x;
  return mesh;
}

// The part of a mesh in which the piece lies.
TriangleMesh PartOf(World world, int index, const TriangleMesh& mesh) {
  const double middle = world == World::kRelief ? 5 : 0;
  return CutPiece(mesh, [&](const Eigen::Vector3d& x) {
    return index == 0 ? x.x() < middle + kHalfOverlap : x.x() > middle - kHalfOverlap;
  });
}

TriangleMesh MakePiece(World world, int index, const PieceOptions& options) {
  TriangleMesh mesh = TruthOf(world, options.edge_length, static_cast<uint64_t>(index) + 1);
  mesh = PartOf(world, index, mesh);
  const double edge = MeanEdgeLength(mesh);
  AddNormalNoise(options.noise * edge, options.is_smooth ? 3 * edge : 0,
                 static_cast<uint64_t>(index) + 7, &mesh);
  for (Eigen::Vector3d& x : mesh.vertices) {
    x += options.offset * edge * Eigen::Vector3d(0, 0.6, 0.8);
    x = x.cast<float>().cast<double>();
  }
  return mesh;
}

MergingInput Input(const std::string& name, const TriangleMesh& mesh) {
  MergingInput input;
  input.name = name;
  input.mesh = mesh;
  return input;
}

size_t NumCrossings(const TriangleMesh& mesh) {
  const std::vector<uint8_t> all(mesh.faces.size(), 1);
  return FaceGrid(mesh.vertices, mesh.faces).CrossingPairs(all, RunContext(2)).size();
}

SurfaceEvaluation Score(const TriangleMesh& mesh, const TriangleMesh& truth, double unit) {
  SurfaceEvaluationOptions options;
  options.thresholds = fmt::format("{},{},{},{}", 0.25 * unit, 0.5 * unit, unit, 2 * unit);
  options.unit = DistanceUnit::kWorld;
  options.num_samples = 40000;
  options.min_num_views = 0;
  return EvaluateSurface(mesh, truth, {}, options, RunContext(2));
}

struct MergingCase {
  std::string name;
  World world;
  PieceOptions first, second;
};
void PrintTo(const MergingCase& c, std::ostream* out) { *out << c.name; }

class MergesPieces : public testing::TestWithParam<MergingCase> {
 protected:
  MergesPieces()
      : world_(GetParam().world),
        pieces_{MakePiece(world_, 0, GetParam().first), MakePiece(world_, 1, GetParam().second)},
        truth_(TruthOf(world_, 0.04, 9)),
        parts_{PartOf(world_, 0, truth_), PartOf(world_, 1, truth_)},
        merged_(MergeMeshes({Input("a.ply", pieces_[0]), Input("b.ply", pieces_[1])}, {}, {},
                            RunContext(2))) {}

  // Noise makes surfaces larger than the truth: by how much in the mean of the inputs.
  double MeanExcess() const {
    double sum = 0;
    for (int i = 0; i < 2; ++i) sum += Inspect(pieces_[i]).area / Inspect(parts_[i]).area;
    return sum / 2;
  }

  World world_;
  std::array<TriangleMesh, 2> pieces_;
  TriangleMesh truth_;
  std::array<TriangleMesh, 2> parts_;  // of the truth
  MergedMesh merged_;
};

TEST_P(MergesPieces, IntoOneManifold) {
  const TriangleMesh& mesh = merged_.mesh;
  ExpectValidMesh(mesh);
  const MeshInspection inspection = Inspect(mesh);
  EXPECT_EQ(inspection.num_components, 1u);
  EXPECT_EQ(merged_.counters.num_open_seam_edges, 0u);
  EXPECT_LE(NumCrossings(mesh), NumCrossings(pieces_[0]) + NumCrossings(pieces_[1]));
  if (world_ == World::kRelief) {
    EXPECT_EQ(inspection.euler_characteristic, 1);
  } else {
    EXPECT_EQ(inspection.num_border_edges, 0u);
    EXPECT_EQ(inspection.Genus(), world_ == World::kTorus ? 1 : 0);
  }
  EXPECT_NEAR(inspection.area / Inspect(truth_).area / MeanExcess(), 1, 0.01);
}

TEST_P(MergesPieces, AsGoodAsTheInputs) {
  const double edge = std::max(GetParam().first.edge_length, GetParam().second.edge_length);
  const std::vector<double> f1 = Score(merged_.mesh, truth_, edge).f1;
  const std::vector<double> first = Score(pieces_[0], parts_[0], edge).f1,
                            second = Score(pieces_[1], parts_[1], edge).f1;
  double sum = 0, sum_inputs = 0;
  for (size_t k = 0; k < f1.size(); ++k) {
    EXPECT_GE(f1[k], std::min(first[k], second[k]) - kScoreError);
    sum += f1[k];
    sum_inputs += 0.5 * (first[k] + second[k]);
  }
  // Of two meshes that lie apart one is wrong, and nothing says which: the band in which they are
  // moved together costs the right one some of its points, in proportion to its width, and so does
  // each edge length that the seam lies on its side of midway (0.008 of the relief). A band of four
  // times the way that each moves costs 0.013 of the relief, a cliff of one edge 0.010.
  const bool are_apart = GetParam().first.offset > 0 || GetParam().second.offset > 0;
  EXPECT_GE(sum / 4, sum_inputs / 4 - (are_apart ? 0.0135 : kScoreError));
}

std::vector<MergingCase> Cases() {
  std::vector<MergingCase> cases;
  for (const auto& [name, world] : {std::pair("sphere", World::kSphere),
                                    {"torus", World::kTorus},
                                    {"relief", World::kRelief}}) {
    const auto add = [&cases, name = name, world = world](const char* what, const PieceOptions& a,
                                                          const PieceOptions& b) {
      cases.push_back({std::string(name) + "_" + what, world, a, b});
    };
    add("exact", {0.1}, {0.1});
    add("noise03", {0.1, 0.3}, {0.1, 0.3});
    add("noise1", {0.1, 1.0}, {0.1, 1.0});
    add("white03", {0.1, 0.3, false}, {0.1, 0.3, false});
    add("offset2", {0.1}, {0.1, 0, true, 2});
    add("offset2noise", {0.1, 0.3}, {0.1, 0.3, true, 2});
    add("ratio3", {0.15, 0.3}, {0.05, 0.3});
    add("ratio10", {0.4, 0.3}, {0.04, 0.3});
    add("ratio10offset", {0.4, 0.3, true, 1}, {0.04, 0.3});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Worlds, MergesPieces, testing::ValuesIn(Cases()),
                         [](const auto& test) { return test.param.name; });

// A bumpy plane [0, 10] x [0, 6] in two halves.
std::vector<TriangleMesh> ReliefHalves() {
  const PieceOptions options{0.15, 0.2};
  return {MakePiece(World::kRelief, 0, options), MakePiece(World::kRelief, 1, options)};
}

bool HasVertex(const TriangleMesh& mesh, const Eigen::Vector3d& x) {
  return std::find(mesh.vertices.begin(), mesh.vertices.end(), x) != mesh.vertices.end();
}

TEST(MeshMerger, KeepsWhatIsFarFromTheSeam) {
  const auto pieces = ReliefHalves();
  const TriangleMesh mesh =
      MergeMeshes({Input("a", pieces[0]), Input("b", pieces[1])}, {}, {}, RunContext(1)).mesh;
  for (const TriangleMesh& piece : pieces) {
    for (const Eigen::Vector3d& x : piece.vertices) {
      if (std::abs(x.x() - 5) < 3.5) continue;
      EXPECT_TRUE(HasVertex(mesh, x)) << x.transpose();
    }
  }
}

TEST(MeshMerger, MergesThreeInAnyOrder) {
  const TriangleMesh whole = ReliefMesh(0.15, 3);
  std::vector<MergingInput> inputs;
  for (const auto& [begin, end] : {std::pair(0.0, 4.2), {3.0, 7.0}, {5.8, 10.0}}) {
    TriangleMesh piece =
        CutPiece(ReliefMesh(0.15, inputs.size() + 4),
                 [&, b = begin, e = end](const auto& x) { return x.x() > b && x.x() < e; });
    for (Eigen::Vector3d& x : piece.vertices) x = x.cast<float>().cast<double>();
    inputs.push_back(Input(std::string(1, static_cast<char>('a' + inputs.size())), piece));
  }
  const MergedMesh first = MergeMeshes(inputs, {}, {}, RunContext(2));
  ExpectValidMesh(first.mesh);
  EXPECT_EQ(Inspect(first.mesh).num_components, 1u);
  EXPECT_EQ(Inspect(first.mesh).euler_characteristic, 1);
  std::vector<size_t> order = {0, 1, 2};
  while (std::next_permutation(order.begin(), order.end())) {
    const MergedMesh again =
        MergeMeshes({inputs[order[0]], inputs[order[1]], inputs[order[2]]}, {}, {}, RunContext(1));
    EXPECT_EQ(again.mesh.vertices, first.mesh.vertices);
    EXPECT_EQ(again.mesh.faces, first.mesh.faces);
  }
}

TEST(MeshMerger, FillsHolesThatTheOtherCovers) {
  const TriangleMesh holed = CutPiece(ReliefMesh(0.15, 1), [](const Eigen::Vector3d& x) {
    return x.x() < 7 && (x.head<2>() - Eigen::Vector2d(4, 3)).norm() > 0.8;
  });
  const TriangleMesh other =
      CutPiece(ReliefMesh(0.15, 2), [](const Eigen::Vector3d& x) { return x.x() > 2; });
  const TriangleMesh mesh =
      MergeMeshes({Input("a", holed), Input("b", other)}, {}, {}, RunContext(2)).mesh;
  ExpectValidMesh(mesh);
  EXPECT_EQ(Inspect(mesh).euler_characteristic, 1);  // a disc
}

// A strip so narrow that its outline could be closed by triangles across it.
TEST(MeshMerger, LeavesTheOutlineOpen) {
  const TriangleMesh a = CutPiece(ReliefMesh(0.25, 1), [](const auto& x) { return x.x() < 6; });
  const TriangleMesh b = CutPiece(ReliefMesh(0.25, 2), [](const auto& x) { return x.x() > 4; });
  for (const auto method : {MergingMethod::kSurface, MergingMethod::kAuto}) {
    MeshMergerOptions options;
    options.method = method;
    const MergedMesh merged =
        MergeMeshes({Input("a", a), Input("b", b)}, {}, options, RunContext(2));
    ExpectValidMesh(merged.mesh);
    EXPECT_EQ(Inspect(merged.mesh).euler_characteristic, 1);  // a disc
    EXPECT_EQ(merged.counters.num_seam_crossings, 0u);
    EXPECT_EQ(merged.counters.num_open_seam_edges, 0u);
    EXPECT_NEAR(Inspect(merged.mesh).area / Inspect(ReliefMesh(0.25, 3)).area, 1, 0.02);
  }
}

// Faces that cross at the ends of a seam are smoothed, which must not draw the outline in.
TEST(MeshMerger, KeepsTheOutlineOfCoarseMeshes) {
  for (const double edge : {0.3, 0.5}) {
    for (const double half_overlap : {0.5 * edge, 1.5 * edge, 3 * edge}) {
      SCOPED_TRACE(testing::Message() << "edge " << edge << " half overlap " << half_overlap);
      const TriangleMesh a =
          CutPiece(ReliefMesh(edge, 1), [&](const auto& x) { return x.x() < 5 + half_overlap; });
      const TriangleMesh b =
          CutPiece(ReliefMesh(edge, 2), [&](const auto& x) { return x.x() > 5 - half_overlap; });
      const MergedMesh merged = MergeMeshes({Input("a", a), Input("b", b)}, {}, {}, RunContext(2));
      ExpectValidMesh(merged.mesh);
      EXPECT_NEAR(Inspect(merged.mesh).area / Inspect(ReliefMesh(0.04, 9)).area, 1, 0.015);
    }
  }
}

TEST(MeshMerger, TakesOneOfTwoContradictingPatches) {
  // A box-like hill that only one of both has.
  TriangleMesh with_hill = ReliefMesh(0.1, 1);
  for (Eigen::Vector3d& x : with_hill.vertices) {
    const double distance = (x.head<2>() - Eigen::Vector2d(5, 3)).norm();
    x.z() += 1.5 / (1 + std::exp((distance - 0.9) / 0.05));
  }
  with_hill = CutPiece(with_hill, [](const auto& x) { return x.x() < 8; });
  const TriangleMesh without =
      CutPiece(ReliefMesh(0.1, 2), [](const Eigen::Vector3d& x) { return x.x() > 2; });
  for (const bool hill_is_newer : {false, true}) {
    MeshMergerOptions options;
    options.conflict_winner = ConflictWinner::kNewer;
    MergingInput a = Input("a", with_hill), b = Input("b", without);
    a.modification_time = hill_is_newer ? 2 : 0;
    b.modification_time = 1;
    for (const auto method : {MergingMethod::kSurface, MergingMethod::kAuto}) {
      options.method = method;
      SCOPED_TRACE(testing::Message()
                   << "newer " << hill_is_newer << " method " << static_cast<int>(method));
      const MergedMesh merged = MergeMeshes({a, b}, {}, options, RunContext(2));
      ExpectValidMesh(merged.mesh);
      EXPECT_GT(merged.counters.num_conflict_faces, 0u);
      EXPECT_EQ(Inspect(merged.mesh).num_components, 1u);
      // The surface cut alone is made for meshes that agree: it may leave a handle at a steep wall.
      if (method == MergingMethod::kAuto) {
        EXPECT_EQ(Inspect(merged.mesh).euler_characteristic, 1);
      }
      double highest = -1e9;
      for (const Eigen::Vector3d& x : merged.mesh.vertices) {
        if ((x.head<2>() - Eigen::Vector2d(5, 3)).norm() < 0.5) {
          highest = std::max(highest, x.z() - ReliefHeight(x.x(), x.y()));
        }
      }
      EXPECT_NEAR(highest, hill_is_newer ? 1.5 : 0, 0.3);
    }
  }
}

// Raises a mesh to a steep hill of 1.5 around a place.
void AddHill(const Eigen::Vector2d& place, TriangleMesh* mesh) {
  for (Eigen::Vector3d& x : mesh->vertices) {
    const double distance = (x.head<2>() - place).norm();
    x.z() += 1.5 / (1 + std::exp((distance - 0.9) / 0.05));
  }
}

double HeightAt(const TriangleMesh& mesh, const Eigen::Vector2d& place) {
  double highest = -1e9;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    if ((x.head<2>() - place).norm() > 0.5) continue;
    highest = std::max(highest, x.z() - ReliefHeight(x.x(), x.y()));
  }
  return highest;
}

// Views of a vertex, as many as `count` says for its place.
template <class Count>
void AddViews(const Count& count, MergingInput* input) {
  input->view_begin = {0};
  for (const Eigen::Vector3d& x : input->mesh.vertices) {
    for (uint32_t view = 0; view < count(x); ++view) input->view_idxs.push_back(view);
    input->view_begin.push_back(input->view_idxs.size());
  }
}

// Two hills of the first mesh that the second does not have: at one of them more views see the
// first mesh, at the other one the second.
TEST(MeshMerger, DecidesEachConflictForItself) {
  const Eigen::Vector2d left(3.5, 3), right(7, 3);
  TriangleMesh hills = ReliefMesh(0.1, 1);
  AddHill(left, &hills);
  AddHill(right, &hills);
  MergingInput a = Input("a", CutPiece(hills, [](const auto& x) { return x.x() < 9; }));
  MergingInput b =
      Input("b", CutPiece(ReliefMesh(0.1, 2), [](const auto& x) { return x.x() > 1.5; }));
  AddViews([](const Eigen::Vector3d& x) { return x.x() < 5.2 ? 5u : 2u; }, &a);
  AddViews([](const Eigen::Vector3d&) { return 3u; }, &b);
  for (const auto method :
       {MergingMethod::kSurface, MergingMethod::kAuto, MergingMethod::kTetrahedra}) {
    SCOPED_TRACE(static_cast<int>(method));
    MeshMergerOptions options;
    options.method = method;
    const MergedMesh merged = MergeMeshes({a, b}, {}, options, RunContext(2));
    ExpectValidMesh(merged.mesh);
    EXPECT_NEAR(HeightAt(merged.mesh, left), 1.5, 0.3);
    EXPECT_NEAR(HeightAt(merged.mesh, right), 0, 0.3);
  }
}

// A camera at `center` that looks down.
View LookDown(const Eigen::Vector3d& center) {
  View view;
  view.camera.width = view.camera.height = 400;
  view.camera.fx = view.camera.fy = 300;
  view.camera.cx = view.camera.cy = 200;
  view.cam_from_world.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
  return view;
}

// A plate that hangs over the ground in one mesh; the other's views saw the ground through it.
TEST(MeshMerger, TakesOutWhatStandsInSpaceSeenEmpty) {
  TriangleMesh with_plate = ReliefMesh(0.15, 1);
  TriangleMesh plate = CutPiece(ReliefMesh(0.15, 3), [](const Eigen::Vector3d& x) {
    return (x.head<2>() - Eigen::Vector2d(5, 3)).norm() < 0.8;
  });
  const int first = static_cast<int>(with_plate.vertices.size());
  for (const Eigen::Vector3d& x : plate.vertices) {
    with_plate.vertices.push_back(x + Eigen::Vector3d(0, 0, 2));
  }
  for (const Eigen::Vector3i& face : plate.faces) {
    with_plate.faces.push_back(face + Eigen::Vector3i::Constant(first));
  }
  std::vector<View> views;
  for (const double x : {3.0, 5.0, 7.0, 4.5}) views.push_back(LookDown({x, 3, 9}));
  MergingInput a = Input("a", with_plate), b = Input("b", ReliefMesh(0.15, 2));
  AddViews([](const Eigen::Vector3d&) { return 2u; }, &a);
  AddViews([](const Eigen::Vector3d&) { return 4u; }, &b);
  const MergedMesh merged = MergeMeshes({a, b}, views, {}, RunContext(2));
  ExpectValidMesh(merged.mesh);
  EXPECT_GT(merged.counters.num_conflict_faces, 0u);
  EXPECT_NEAR(HeightAt(merged.mesh, {5, 3}), 0, 0.3);
  // Without views nothing is known about the plate.
  a.view_begin = b.view_begin = {};
  a.view_idxs = b.view_idxs = {};
  EXPECT_NEAR(HeightAt(MergeMeshes({a, b}, {}, {}, RunContext(2)).mesh, {5, 3}), 2, 0.3);
}

// Where the meshes part, what views saw decides where the tetrahedra change over.
TEST(MeshMerger, TetrahedraKeepToWhatViewsSaw) {
  const PieceOptions options{0.15, 0.3};
  MergingInput a = Input("a", MakePiece(World::kRelief, 0, options)),
               b = Input("b", MakePiece(World::kRelief, 1, options));
  std::vector<View> views;
  for (const double x : {2.0, 4.0, 6.0, 8.0}) views.push_back(LookDown({x, 3, 9}));
  AddViews([](const Eigen::Vector3d&) { return 4u; }, &a);
  AddViews([](const Eigen::Vector3d&) { return 4u; }, &b);
  MeshMergerOptions merging;
  merging.method = MergingMethod::kTetrahedra;
  const MergedMesh merged = MergeMeshes({a, b}, views, merging, RunContext(2)),
                   one_thread = MergeMeshes({b, a}, views, merging, RunContext(1)),
                   blind = MergeMeshes({a, b}, {}, merging, RunContext(2));
  ExpectValidMesh(merged.mesh);
  EXPECT_EQ(Inspect(merged.mesh).num_components, 1u);
  EXPECT_EQ(merged.mesh.vertices, one_thread.mesh.vertices);
  EXPECT_EQ(merged.mesh.faces, one_thread.mesh.faces);
  EXPECT_NE(merged.mesh.faces, blind.mesh.faces);
  const TriangleMesh truth = TruthOf(World::kRelief, 0.04, 9);
  EXPECT_GE(Score(merged.mesh, truth, 0.15).f1[1], Score(blind.mesh, truth, 0.15).f1[1] - 0.02);
}

TEST(MeshMerger, CarriesAttributes) {
  std::vector<MergingInput> inputs;
  for (int i = 0; i < 2; ++i) {
    MergingInput input = Input(std::string(1, static_cast<char>('a' + i)),
                               MakePiece(World::kRelief, i, {0.15, 0.3}));
    for (const Eigen::Vector3d& x : input.mesh.vertices) {
      input.mesh.vertex_quality.push_back(static_cast<float>(x.x() / 10));
      input.mesh.vertex_colors.emplace_back(static_cast<uint8_t>(20 + 20 * x.x()),
                                            static_cast<uint8_t>(10 + 35 * x.y()), 100 * i);
    }
    input.mesh.vertex_normals = ComputeVertexNormals(input.mesh);
    AddViews([](const Eigen::Vector3d& x) { return static_cast<uint32_t>(x.y()) + 1; }, &input);
    inputs.push_back(std::move(input));
  }
  for (const auto method :
       {MergingMethod::kSurface, MergingMethod::kAuto, MergingMethod::kTetrahedra}) {
    SCOPED_TRACE(static_cast<int>(method));
    MeshMergerOptions options;
    options.method = method;
    const MergedMesh merged = MergeMeshes(inputs, {}, options, RunContext(2));
    const TriangleMesh& mesh = merged.mesh;
    const size_t num_vertices = mesh.vertices.size();
    ASSERT_EQ(mesh.vertex_quality.size(), num_vertices);
    ASSERT_EQ(mesh.vertex_colors.size(), num_vertices);
    ASSERT_EQ(mesh.vertex_normals.size(), num_vertices);
    ASSERT_EQ(merged.view_begin.size(), num_vertices + 1);
    const std::vector<Eigen::Vector3f> fresh = ComputeVertexNormals(mesh);
    double similarity = 0;
    for (size_t v = 0; v < num_vertices; ++v) {
      const Eigen::Vector3d& x = mesh.vertices[v];
      // Within some edge lengths of where it comes from.
      EXPECT_NEAR(mesh.vertex_quality[v], x.x() / 10, 0.08);
      EXPECT_NEAR(mesh.vertex_colors[v][0], 20 + 20 * x.x(), 16);
      EXPECT_NEAR(mesh.vertex_colors[v][1], 10 + 35 * x.y(), 28);
      EXPECT_NEAR(static_cast<double>(merged.view_begin[v + 1] - merged.view_begin[v]), x.y() + 0.5,
                  1.0);
      similarity += mesh.vertex_normals[v].dot(fresh[v]) / static_cast<double>(num_vertices);
    }
    EXPECT_GT(similarity, 0.99);
  }
}

// Strips of edges from 0.04 to 0.4.
TEST(MeshMerger, MergesResolutionsInAnyOrder) {
  std::vector<MergingInput> inputs;
  const double edges[] = {0.4, 0.04, 0.15, 0.08};
  for (size_t i = 0; i < 4; ++i) {
    const double begin = 2.4 * static_cast<double>(i), end = begin + 3.8;
    TriangleMesh piece = CutPiece(ReliefMesh(edges[i], i + 1), [&](const Eigen::Vector3d& x) {
      return x.x() > begin - 0.5 && x.x() < end && x.y() < 3;
    });
    for (Eigen::Vector3d& x : piece.vertices) x = x.cast<float>().cast<double>();
    inputs.push_back(Input(std::string(1, static_cast<char>('a' + i)), piece));
  }
  const MergedMesh first = MergeMeshes(inputs, {}, {}, RunContext(2));
  ExpectValidMesh(first.mesh);
  EXPECT_EQ(Inspect(first.mesh).num_components, 1u);
  EXPECT_EQ(Inspect(first.mesh).euler_characteristic, 1);
  for (const auto& order : {std::array<size_t, 4>{3, 1, 0, 2}, {2, 3, 1, 0}}) {
    std::vector<MergingInput> turned;
    for (const size_t i : order) turned.push_back(inputs[i]);
    const MergedMesh again = MergeMeshes(turned, {}, {}, RunContext(1));
    EXPECT_EQ(again.mesh.vertices, first.mesh.vertices);
    EXPECT_EQ(again.mesh.faces, first.mesh.faces);
  }
}

TEST(MeshMerger, RepairsWhatIsNoManifold) {
  auto pieces = ReliefHalves();
  TriangleMesh& a = pieces[0];
  a.faces.push_back(a.faces[10]);  // twice
  a.faces.emplace_back(3, 3, 4);   // no triangle
  a.vertices.push_back(a.vertices[40] + Eigen::Vector3d(0, 0, 1));
  const int fin = static_cast<int>(a.vertices.size()) - 1;
  a.faces.emplace_back(a.faces[20][0], a.faces[20][1], fin);  // a fin
  const MergedMesh merged =
      MergeMeshes({Input("a", a), Input("b", pieces[1])}, {}, {}, RunContext(2));
  EXPECT_TRUE(Inspect(merged.mesh).IsManifold());
  EXPECT_TRUE(Inspect(merged.mesh).IsOriented());
  EXPECT_GE(merged.counters.num_repaired_faces, 2u);
}

TEST(MeshMerger, TakesTheTetrahedraToo) {
  for (const World world : {World::kSphere, World::kTorus, World::kRelief}) {
    const PieceOptions piece{0.15, 0.3};
    const TriangleMesh a = MakePiece(world, 0, piece), b = MakePiece(world, 1, piece);
    MeshMergerOptions options;
    options.method = MergingMethod::kTetrahedra;
    const MergedMesh merged =
        MergeMeshes({Input("a", a), Input("b", b)}, {}, options, RunContext(2));
    ExpectValidMesh(merged.mesh);
    const MeshInspection inspection = Inspect(merged.mesh);
    EXPECT_EQ(inspection.num_components, 1u);
    // At the ends of open surfaces the tetrahedra may leave a notch of an edge.
    EXPECT_LE(merged.counters.num_open_seam_edges, world == World::kRelief ? 2u : 0u);
    EXPECT_LE(NumCrossings(merged.mesh), NumCrossings(a) + NumCrossings(b));
    const double true_area = Inspect(TruthOf(world, 0.04, 9)).area;
    EXPECT_NEAR(inspection.area / true_area, 1, 0.03);
    EXPECT_EQ(inspection.num_border_edges == 0, world != World::kRelief);
  }
}

TEST(MeshMerger, TakesOneOfTwoThatAreTheSame) {
  const TriangleMesh whole = ReliefMesh(0.15, 1);
  const TriangleMesh mesh =
      MergeMeshes({Input("a", whole), Input("b", whole)}, {}, {}, RunContext(2)).mesh;
  ExpectValidMesh(mesh);
  EXPECT_EQ(mesh.faces.size(), whole.faces.size());
  // And the whole, if the other is a part of it.
  const TriangleMesh part =
      CutPiece(ReliefMesh(0.15, 2), [](const auto& x) { return std::abs(x.x() - 5) < 2; });
  const TriangleMesh both =
      MergeMeshes({Input("a", whole), Input("b", part)}, {}, {}, RunContext(2)).mesh;
  ExpectValidMesh(both);
  EXPECT_EQ(Inspect(both).euler_characteristic, 1);
}

TEST(MeshMerger, RefusesFewerThanTwo) {
  EXPECT_THROW(MergeMeshes({Input("a", ReliefMesh(0.5, 1))}, {}, {}, RunContext(1)), UsageError);
}

}  // namespace
}  // namespace lsmvs
