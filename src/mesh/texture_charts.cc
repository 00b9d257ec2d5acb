#include "lsmvs/mesh/texture_charts.h"

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

constexpr float kSamePlacePx = 1.0f / 256;

const Eigen::Vector2f& TexcoordOf(const TexturedMesh& textured, int face, int vertex) {
  const Eigen::Vector3i& corners = textured.mesh.faces[face];
  return textured.texcoords[face][corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2];
}

}  // namespace

bool ContinueInTexture(const TexturedMesh& textured, int face, int other_face, int vertex_a,
                       int vertex_b) {
  if (textured.page_idx[face] != textured.page_idx[other_face]) return false;
  for (const int v : {vertex_a, vertex_b}) {
    const Eigen::Vector2f step =
        TexcoordOf(textured, face, v) - TexcoordOf(textured, other_face, v);
    if (!(step.cwiseAbs().maxCoeff() <= kSamePlacePx)) return false;
  }
  return true;
}

TextureCharts FindTextureCharts(const TexturedMesh& textured) {
  TextureCharts charts;
  if (!textured.has_texture()) return charts;
  const size_t num_faces = textured.mesh.faces.size();
  DisjointSets sets(num_faces);
  const std::vector<HalfEdge> sides =
      SortedHalfEdges(textured.mesh.faces, textured.mesh.vertices.size());
  ForEdges(sides, [&](const HalfEdge* begin, const HalfEdge* end) {
    for (const HalfEdge* a = begin; a != end; ++a) {
      for (const HalfEdge* b = a + 1; b != end; ++b) {
        if (!ContinueInTexture(textured, a->face, b->face, a->low, a->high)) continue;
        sets.Unite(static_cast<uint32_t>(a->face), static_cast<uint32_t>(b->face));
      }
    }
  });
  charts.chart_of_face.resize(num_faces);
  for (uint32_t f = 0; f < num_faces; ++f) {  // the lowest face stands for its set
    const uint32_t first = sets.Find(f);
    charts.chart_of_face[f] = first == f ? charts.num_charts++ : charts.chart_of_face[first];
  }
  return charts;
}

}  // namespace lsmvs
