#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "lsmvs/geometry/distances.h"
#include "lsmvs/mesh/self_intersections.h"
#include "lsmvs/mesh/simplification/deviation_bound.h"
#include "lsmvs/mesh/simplification/edge_collapser.h"
#include "lsmvs/mesh/simplification/proper_surface.h"
#include "lsmvs/mesh/simplify.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/valid_options.h"

namespace lsmvs {

namespace {

using internal::DeviationBound;
using internal::EdgeCollapser;
using internal::ProperSurface;
using internal::VertexStars;

// Corners of the overlay of both surfaces are tested in the manner of J. Cohen, D. Manocha, M.
// Olano, "Simplifying polygonal models using successive mappings", Visualization 1997; we look for
// corresponding points near each other instead of keeping a mapping.

constexpr double kMinFlatness = 0.05, kMinNormalCosine = 0.25;
constexpr size_t kMaxFacesOfVertex = 16;
// Part of the tolerance by which a new vertex may be rounded to what a file holds.
constexpr double kRoundingPart = 0.01;
constexpr size_t kVerticesPerBlock = 4096;

// Whether the faces at a vertex are one fan of one orientation: a closed one, or one that begins
// and ends at the border.
bool IsRegular(const VertexStars& stars, int32_t v) {
  struct Spoke {
    int32_t from, to;
  };
  std::vector<Spoke> spokes;
  stars.ForFaces(v, [&](int32_t f, int k) {
    const Eigen::Vector3i& face = stars.face(f);
    spokes.push_back({face[(k + 1) % 3], face[(k + 2) % 3]});
  });
  const auto after = [&](int32_t rim) {
    return std::find_if(spokes.begin(), spokes.end(),
                        [=](const Spoke& s) { return s.from == rim; });
  };
  const auto start = std::find_if(spokes.begin(), spokes.end(), [&](const Spoke& first) {
    return std::none_of(spokes.begin(), spokes.end(),
                        [&](const Spoke& s) { return s.to == first.from; });
  });
  auto spoke = start == spokes.end() ? spokes.begin() : start;
  const int32_t first = spoke->from;
  size_t count = 1;
  for (; count < spokes.size(); ++count) {
    spoke = after(spoke->to);
    if (spoke == spokes.end() || spoke->from == first) return false;
  }
  return start != spokes.end() || spoke->to == first;
}

class BoundedSimplifier {
 public:
  BoundedSimplifier(const TriangleMesh& mesh, const std::vector<double>& tolerance,
                    const BoundedSimplificationOptions& options, const RunContext& context)
      : mesh_(mesh), options_(options), context_(context), surface_(internal::ProperPart(mesh)) {
    for (const int v : surface_.source) {
      tolerance_.push_back((1 - kRoundingPart) * tolerance[static_cast<size_t>(v)]);
    }
  }

  SimplifiedMesh Run() {
    const VertexStars input(surface_.vertices, surface_.faces);
    std::vector<uint8_t> locked(surface_.vertices.size());
    ParallelFor(context_, locked.size(), kVerticesPerBlock,
                [&](size_t v) { locked[v] = !IsRegular(input, static_cast<int32_t>(v)); });
    SimplifiedMesh result;
    std::vector<internal::CollapseStep> steps;
    while (!Simplify(&locked, &steps, &result)) {
    }
    TakeAttributes(input, &result);
    return result;
  }

 private:
  // Collapses edges, or, where there are steps already, repeats them. False if faces cross that did
  // not in the input; what is around them is then locked, too.
  bool Simplify(std::vector<uint8_t>* locked, std::vector<internal::CollapseStep>* steps,
                SimplifiedMesh* result) const {
    VertexStars stars(surface_.vertices, surface_.faces);
    DeviationBound bound(surface_.vertices, surface_.faces, tolerance_, stars);
    internal::CollapseRules rules;
    rules.border_weight = options_.boundary_weight;
    rules.min_flatness = kMinFlatness;
    rules.min_normal_cosine = kMinNormalCosine;
    rules.max_faces_of_vertex = kMaxFacesOfVertex;
    EdgeCollapser collapser(rules, tolerance_, &stars, &bound);
    collapser.Lock(*locked);
    if (steps->empty()) {
      collapser.Run(MinFaces(), context_);
    } else {
      collapser.Repeat(*steps, context_);
    }
    *steps = collapser.steps();
    const std::vector<Eigen::Vector3d> positions = FilePositions(stars, bound);
    if (LockCrossings(positions, stars, bound, locked)) return false;
    std::vector<int> source;
    for (const int32_t v : collapser.sources()) {
      source.push_back(surface_.source[static_cast<size_t>(v)]);
    }
    *result = internal::CompactMesh(positions, stars.Faces(), source);
    return true;
  }

  size_t MinFaces() const {
    return static_cast<size_t>(
        std::ceil(options_.target_face_ratio * static_cast<double>(surface_.faces.size())));
  }

  // In the world, as a mesh file holds them.
  std::vector<Eigen::Vector3d> FilePositions(const VertexStars& stars,
                                             const DeviationBound& bound) const {
    std::vector<Eigen::Vector3d> positions(stars.num_vertices());
    ParallelFor(context_, positions.size(), kVerticesPerBlock, [&](size_t v) {
      const auto vertex = static_cast<int32_t>(v);
      positions[v] = bound.IsInPlace(vertex)
                         ? mesh_.vertices[static_cast<size_t>(surface_.source[v])]
                         : RoundToFile(stars.position(vertex) + surface_.origin,
                                       kRoundingPart * tolerance_[v]);
    });
    return positions;
  }

  // Locks the input vertices around faces that cross and are not the input's own; false if there
  // are none.
  bool LockCrossings(const std::vector<Eigen::Vector3d>& positions, const VertexStars& stars,
                     const DeviationBound& bound, std::vector<uint8_t>* locked) const {
    std::vector<int32_t> ids;
    for (int32_t f = 0; f < static_cast<int32_t>(stars.num_all_faces()); ++f) {
      if (stars.IsLeft(f)) ids.push_back(f);
    }
    const std::vector<Eigen::Vector3i> faces = stars.Faces();
    std::vector<uint8_t> changed(faces.size());
    for (size_t i = 0; i < faces.size(); ++i) {
      changed[i] = faces[i] != surface_.faces[static_cast<size_t>(ids[i])];
      for (const int v : faces[i]) changed[i] |= !bound.IsInPlace(v);
    }
    const auto pairs = FaceGrid(positions, faces).CrossingPairs(changed, context_);
    bool any = false;
    const auto lock = [&](int32_t v) {
      uint8_t& is_locked = (*locked)[static_cast<size_t>(v)];
      any |= !is_locked;
      is_locked = 1;
    };
    for (const auto& [a, b] : pairs) {
      for (const int32_t face : {a, b}) {
        for (const int v : faces[static_cast<size_t>(face)]) {
          lock(v);
          stars.ForFaces(v, [&](int32_t f, int) { bound.ForVerticesBy(f, lock); });
        }
      }
    }
    return any;
  }

  void TakeAttributes(const VertexStars& input, SimplifiedMesh* result) const {
    TriangleMesh& output = result->mesh;
    output.vertex_colors = CarryToSimplified(*result, mesh_.vertex_colors);
    output.vertex_quality = CarryToSimplified(*result, mesh_.vertex_quality);
    if (options_.interpolate_colors && !mesh_.vertex_colors.empty()) {
      InterpolateColors(input, result);
    }
    if (!mesh_.vertex_normals.empty()) output.vertex_normals = ComputeVertexNormals(output);
  }

  void InterpolateColors(const VertexStars& input, SimplifiedMesh* result) const {
    std::vector<int32_t> index_of(mesh_.vertices.size(), -1);
    for (size_t v = 0; v < surface_.source.size(); ++v) {
      index_of[static_cast<size_t>(surface_.source[v])] = static_cast<int32_t>(v);
    }
    ParallelFor(context_, result->source_vertex.size(), kVerticesPerBlock, [&](size_t v) {
      const int32_t source = index_of[static_cast<size_t>(result->source_vertex[v])];
      result->mesh.vertex_colors[v] =
          ColorAt(input, source, result->mesh.vertices[v] - surface_.origin);
    });
  }

  // Colour of the input near x, of the faces at a vertex.
  Eigen::Matrix<uint8_t, 3, 1> ColorAt(const VertexStars& input, int32_t vertex,
                                       const Eigen::Vector3d& x) const {
    double nearest = std::numeric_limits<double>::infinity();
    Eigen::Vector3d color = Eigen::Vector3d::Zero();
    input.ForFaces(vertex, [&](int32_t f, int) {
      const Eigen::Vector3i& face = input.face(f);
      const Triangle3 triangle = {input.position(face[0]), input.position(face[1]),
                                  input.position(face[2])};
      const Eigen::Vector3d on_face = ClosestOnTriangle(x, triangle);
      const double distance = (on_face - x).squaredNorm();
      if (distance >= nearest) return;
      nearest = distance;
      const Eigen::Vector3d weights = BarycentricCoordinates(on_face, triangle);
      color.setZero();
      for (int k = 0; k < 3; ++k) {
        const int source = surface_.source[static_cast<size_t>(face[k])];
        color += weights[k] * mesh_.vertex_colors[static_cast<size_t>(source)].cast<double>();
      }
    });
    return color.array().round().max(0).min(255).cast<uint8_t>();
  }

  const TriangleMesh& mesh_;
  const BoundedSimplificationOptions& options_;
  const RunContext& context_;
  const ProperSurface surface_;
  std::vector<double> tolerance_;  // of surface_.vertices
};

}  // namespace

void BoundedSimplificationOptions::Describe(OptionSet* options) {
  options->Add("MeshSimplification.target_face_ratio", &target_face_ratio,
               "Stop when this share of the faces is left; 0: as few as the error allows.",
               {0.0, 1.0});
  options->Add("MeshSimplification.boundary_weight", &boundary_weight,
               "Weight of the border's course against that of the faces in the order of collapses.",
               {0.0, 1e9});
  options->Add("MeshSimplification.interpolate_colors", &interpolate_colors,
               "Vertices take the colour of the input at their place, not that of the nearest "
               "vertex.");
}

SimplifiedMesh SimplifyWithinTolerance(const TriangleMesh& mesh,
                                       const std::vector<double>& tolerance,
                                       const BoundedSimplificationOptions& options,
                                       const RunContext& context) {
  RequireValid(options);
  LSMVS_CHECK_EQ(tolerance.size(), mesh.vertices.size());
  return BoundedSimplifier(mesh, tolerance, options, context).Run();
}

}  // namespace lsmvs
