#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lsmvs/mesh/face_neighbors.h"
#include "lsmvs/mesh/triangle_mesh.h"
#include "lsmvs/texturing/charts/chart_map.h"

namespace lsmvs {

// A part of the surface that lies in one piece on a page. Its corners are at map(vertex) - origin +
// position.
struct Chart {
  int32_t label = -1;           // what its faces have in common
  uint32_t begin = 0, end = 0;  // of Charts::faces
  ChartMap map;
  int photo_level = 0;  // pyramid level of the photos that it is baked from
  Eigen::Vector2i origin = Eigen::Vector2i::Zero();  // what lies at the upper left texel
  Eigen::Vector2i size = Eigen::Vector2i::Zero();    // texels, with the padding
  uint16_t page_idx = 0;
  Eigen::Vector2i position = Eigen::Vector2i::Zero();  // upper left texel on the page
};

struct Charts {
  std::vector<uint32_t> faces;  // #F, chart by chart
  std::vector<Chart> charts;

  std::span<const uint32_t> FacesOf(const Chart& chart) const {
    return {faces.data() + chart.begin, chart.end - chart.begin};
  }
};

struct ChartLayout {
  ChartMap map;
  int photo_level = 0;
  // Texels around a chart. Charts smaller than 8 times as much have an eighth of their longer side,
  // 1 at least: what bilinear filtering reaches.
  int padding = 2;
};

// Cuts a labelled mesh into charts: connected faces of a label, split where they are larger than
// `max_side` texels (with the padding) or fill their rectangle badly and two rectangles are clearly
// smaller. `layout_of(label, faces)` says how a connected region is laid out. Every face is in one
// chart, those with a negative label in none. The order of charts depends on the faces alone. O(F
// log F).
Charts MakeCharts(const TriangleMesh& mesh, const FaceNeighbors& neighbors,
                  std::span<const int32_t> labels, int max_side,
                  const std::function<ChartLayout(int32_t, std::span<const uint32_t>)>& layout_of);

}  // namespace lsmvs
