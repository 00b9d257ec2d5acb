#include "lsmvs/merging/overlap/overlap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lsmvs/geometry/distances.h"
#include "lsmvs/mesh/edge_lengths.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr size_t kVerticesPerBlock = 1 << 10;
constexpr double kMinNormalCosine = 0.5;
// A point counts as being on an edge up to this part of the edge length.
constexpr double kOnEdge = 1e-5;
constexpr size_t kNumSamples = 4000;

// Cells of a cubic grid, a bit set of 21 bits an axis.
class CellGrid {
 public:
  CellGrid(const Eigen::Vector3d& origin, double size) : origin_(origin), size_(size) {}

  Eigen::Array3i CellOf(const Eigen::Vector3d& x) const {
    return ((x - origin_) / size_).array().floor().max(-kMost).min(kMost).cast<int>();
  }
  static uint64_t KeyOf(const Eigen::Array3i& cell) {
    const auto bits = [](int value) { return static_cast<uint64_t>(value + (1 << 20)) & 0x1FFFFF; };
    return bits(cell[0]) << 42 | bits(cell[1]) << 21 | bits(cell[2]);
  }
  template <class Visit>
  void ForCells(const TriangleMesh& mesh, size_t face, int margin, const Visit& visit) const {
    Eigen::AlignedBox3d box;
    for (const int v : mesh.faces[face]) box.extend(mesh.vertices[static_cast<size_t>(v)]);
    const Eigen::Array3i low = CellOf(box.min()) - margin, high = CellOf(box.max()) + margin;
    for (int x = low[0]; x <= high[0]; ++x) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int z = low[2]; z <= high[2]; ++z) visit(KeyOf({x, y, z}));
      }
    }
  }

 private:
  static constexpr double kMost = (1 << 20) - 4;
  Eigen::Vector3d origin_;
  double size_;
};

void SortUnique(std::vector<uint64_t>* keys) {
  std::sort(keys->begin(), keys->end());
  keys->erase(std::unique(keys->begin(), keys->end()), keys->end());
}

}  // namespace

BandSurface::BandSurface(const MeshBand& b)
    : band(&b),
      topology(b.mesh, b.cut_edges),
      frames(ComputeVertexFrames(b.mesh, topology)),
      index(b.mesh.vertices, b.mesh.faces) {}

double BandSurface::EdgeLengthAt(int32_t face) const {
  const Eigen::Vector3i& f = mesh().faces[static_cast<size_t>(face)];
  double sum = 0;
  for (const int v : f) sum += frames.edge_length[static_cast<size_t>(v)];
  return sum / 3;
}

Eigen::Vector3d BandSurface::NormalAt(int32_t face) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int v : mesh().faces[static_cast<size_t>(face)]) {
    sum += frames.normal[static_cast<size_t>(v)];
  }
  return sum.normalized();
}

bool BandSurface::IsAtBorder(int32_t face, const Eigen::Vector3d& point) const {
  const Eigen::Vector3i& f = mesh().faces[static_cast<size_t>(face)];
  const double tolerance = kOnEdge * EdgeLengthAt(face);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d& a = mesh().vertices[static_cast<size_t>(f[k])];
    if (topology.IsOnBorder(f[k]) && (a - point).norm() < tolerance) return true;
    if (!topology.IsBorderSide(face, k)) continue;
    const Eigen::Vector3d& b = mesh().vertices[static_cast<size_t>(f[(k + 1) % 3])];
    if ((ClosestOnSegment(point, a, b) - point).norm() < tolerance) return true;
  }
  return false;
}

std::vector<SurfaceMatch> MatchVertices(const BandSurface& surface, const BandSurface& other,
                                        double max_edges, const RunContext& context) {
  double longest = 0;
  for (const double length : other.frames.edge_length) longest = std::max(longest, length);
  std::vector<SurfaceMatch> matches(surface.mesh().vertices.size());
  ParallelFor(context, matches.size(), kVerticesPerBlock, [&](size_t v) {
    const Eigen::Vector3d& x = surface.mesh().vertices[v];
    const Eigen::Vector3d& normal = surface.frames.normal[v];
    const double own = surface.frames.edge_length[v];
    const double reach = max_edges * std::max(own, longest);
    const auto accept = [&](int32_t face) {
      return other.NormalAt(face).dot(normal) > kMinNormalCosine;
    };
    const SurfaceIndex::Hit hit = other.index.Closest(x, reach, accept);
    if (hit.face < 0 || hit.distance > max_edges * std::max(own, other.EdgeLengthAt(hit.face))) {
      return;
    }
    matches[v] = {hit.face, other.IsAtBorder(hit.face, hit.point), hit.point, hit.distance};
  });
  return matches;
}

namespace {

// Unit vectors at border vertices, in the surface, away from it.
std::vector<Eigen::Vector3d> OutwardDirections(const BandSurface& surface) {
  std::vector<Eigen::Vector3d> outward(surface.mesh().vertices.size(), Eigen::Vector3d::Zero());
  for (size_t f = 0; f < surface.mesh().faces.size(); ++f) {
    const Eigen::Vector3i& face = surface.mesh().faces[f];
    for (int k = 0; k < 3; ++k) {
      if (!surface.topology.IsBorderSide(static_cast<int32_t>(f), k)) continue;
      const size_t a = static_cast<size_t>(face[k]), b = static_cast<size_t>(face[(k + 1) % 3]);
      const Eigen::Vector3d along = surface.mesh().vertices[b] - surface.mesh().vertices[a];
      const Eigen::Vector3d out =
          along.cross(surface.frames.normal[a] + surface.frames.normal[b]).normalized();
      outward[a] += along.norm() * out;
      outward[b] += along.norm() * out;
    }
  }
  for (Eigen::Vector3d& direction : outward) direction.normalize();
  return outward;
}

}  // namespace

std::vector<uint8_t> FindEnds(const BandSurface& surface, const std::vector<SurfaceMatch>& matches,
                              const BandSurface& other, double num_edges, double max_edges,
                              const RunContext& context) {
  const std::vector<Eigen::Vector3d> outward = OutwardDirections(surface);
  std::vector<uint8_t> is_end(matches.size(), 0);
  ParallelFor(context, matches.size(), kVerticesPerBlock, [&](size_t v) {
    const SurfaceMatch& match = matches[v];
    if (outward[v].isZero(0.0) || match.face < 0 || match.at_border) return;
    const double edge = std::max(surface.frames.edge_length[v], other.EdgeLengthAt(match.face));
    const auto accept = [&](int32_t face) {
      return other.NormalAt(face).dot(surface.frames.normal[v]) > 0;
    };
    // From the match: surfaces that lie apart do not meet straight out.
    const SurfaceIndex::Hit hit =
        other.index.Closest(match.point + num_edges * edge * outward[v], max_edges * edge, accept);
    is_end[v] = hit.face >= 0 && !other.IsAtBorder(hit.face, hit.point);
  });
  return is_end;
}

std::vector<uint8_t> FacesNear(const TriangleMesh& mesh, const TriangleMesh& other, double reach) {
  std::vector<uint8_t> is_near(mesh.faces.size(), 0);
  if (mesh.faces.empty() || other.faces.empty()) return is_near;
  // Both meshes share the grid, whichever comes first.
  const CellGrid grid(Eigen::Vector3d::Zero(), reach);
  std::vector<uint64_t> taken;
  size_t last_size = 0;
  for (size_t f = 0; f < other.faces.size(); ++f) {
    grid.ForCells(other, f, 0, [&](uint64_t key) {
      if (taken.empty() || taken.back() != key) taken.push_back(key);
    });
    if (taken.size() > 2 * last_size + (1 << 20)) {
      SortUnique(&taken);
      last_size = taken.size();
    }
  }
  SortUnique(&taken);
  std::vector<uint64_t> wide;
  wide.reserve(27 * taken.size());
  for (const uint64_t key : taken) {
    for (const uint64_t x : {key - (uint64_t{1} << 42), key, key + (uint64_t{1} << 42)}) {
      for (const uint64_t y : {x - (uint64_t{1} << 21), x, x + (uint64_t{1} << 21)}) {
        wide.insert(wide.end(), {y - 1, y, y + 1});
      }
    }
  }
  SortUnique(&wide);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    grid.ForCells(mesh, f, 0, [&](uint64_t key) {
      if (!is_near[f]) is_near[f] = std::binary_search(wide.begin(), wide.end(), key);
    });
  }
  return is_near;
}

Registration MeasureRegistration(const BandSurface& surface, const BandSurface& other, double reach,
                                 const RunContext& context) {
  const size_t num_vertices = surface.mesh().vertices.size();
  const size_t step = std::max<size_t>(1, num_vertices / kNumSamples);
  struct Sample {
    double distance = std::numeric_limits<double>::infinity(), edges = 0;
    bool is_over = false, is_opposite = false;
  };
  std::vector<Sample> samples((num_vertices + step - 1) / step);
  ParallelFor(context, samples.size(), kVerticesPerBlock / 8, [&](size_t i) {
    const Eigen::Vector3d& x = surface.mesh().vertices[i * step];
    const SurfaceIndex::Hit hit = other.index.Closest(x, reach);
    if (hit.face < 0) return;
    const double edge =
        std::max(surface.frames.edge_length[i * step], other.EdgeLengthAt(hit.face));
    samples[i] = {hit.distance, hit.distance / edge, !other.IsAtBorder(hit.face, hit.point),
                  other.NormalAt(hit.face).dot(surface.frames.normal[i * step]) < -0.5};
  });
  Registration result;
  result.least_distance = std::numeric_limits<double>::infinity();
  std::vector<double> distances, edges;
  for (const Sample& sample : samples) {
    result.least_distance = std::min(result.least_distance, sample.distance);
    if (!sample.is_over) continue;
    distances.push_back(sample.distance);
    edges.push_back(sample.edges);
    result.share_opposite += sample.is_opposite;
  }
  result.num_over = distances.size();
  if (distances.empty()) return result;
  result.share_opposite /= static_cast<double>(distances.size());
  result.offset = Median(&distances);
  result.offset_edges = Median(&edges);
  return result;
}

}  // namespace lsmvs
