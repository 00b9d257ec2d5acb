#include "lsmvs/texturing/charts/charts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

// Rectangles that are filled this well, or as small as this, are not looked at.
constexpr double kFilled = 0.9;
constexpr double kSmallArea = 256;
constexpr size_t kMaxSlices = 64;
// The parts' rectangles must take this part of the one's area at most.
constexpr double kMaxPartAfterSplit = 0.98;

struct FaceBox {
  uint32_t face;
  Eigen::AlignedBox2d box;
  double area;
};

struct Split {
  int axis = 0;
  std::vector<size_t> ends;  // of the parts, in faces sorted along the axis
  double area = 0;           // of all rectangles
};

// A rectangle on a page.
struct TexelBox {
  Eigen::Vector2i low, high;
  Eigen::Vector2i Size() const { return high - low; }
  double Area() const { return static_cast<double>(Size().x()) * Size().y(); }
};

// Least padding: what bilinear filtering reaches; and what a part is taken to cost when charts are
// split, so that not too many small ones come of it.
constexpr int kMinPadding = 1, kPaddingToSplit = 2;

// With padding.
TexelBox TexelsOf(const Eigen::AlignedBox2d& box, int max_padding,
                  int min_padding = kPaddingToSplit) {
  constexpr int kPaddingPart = 8;
  TexelBox texels = {box.min().array().floor().cast<int>(), box.max().array().ceil().cast<int>()};
  const int wanted = std::max(min_padding, texels.Size().maxCoeff() / kPaddingPart);
  const int padding = std::min(max_padding, wanted);
  texels.low.array() -= padding;
  texels.high.array() += padding;
  return texels;
}

class ChartSplitter {
 public:
  ChartSplitter(int max_side, Charts* charts) : max_side_(max_side), charts_(*charts) {}

  void Add(int32_t label, const ChartLayout& layout, std::span<FaceBox> faces) {
    const TexelBox texels = TexelsOf(BoxOf(faces), layout.padding);
    if (faces.size() > 1) {
      if (const std::optional<Split> split = FindSplit(faces, texels, layout.padding)) {
        SortAlong(split->axis, faces);
        size_t begin = 0;
        for (const size_t end : split->ends) {
          Add(label, layout, faces.subspan(begin, end - begin));
          begin = end;
        }
        return;
      }
    }
    Emit(label, layout, faces, TexelsOf(BoxOf(faces), layout.padding, kMinPadding));
  }

 private:
  static Eigen::AlignedBox2d BoxOf(std::span<const FaceBox> faces) {
    Eigen::AlignedBox2d box;
    for (const FaceBox& f : faces) box.extend(f.box);
    return box;
  }

  static void SortAlong(int axis, std::span<FaceBox> faces) {
    std::sort(faces.begin(), faces.end(), [axis](const FaceBox& a, const FaceBox& b) {
      const double x = a.box.center()[axis], y = b.box.center()[axis];
      return x != y ? x < y : a.face < b.face;
    });
  }

  std::optional<Split> FindSplit(std::span<FaceBox> faces, const TexelBox& texels,
                                 int padding) const {
    const bool too_large = texels.Size().maxCoeff() > max_side_;
    double filled = 0;
    for (const FaceBox& f : faces) filled += f.area;
    const bool is_good = filled >= kFilled * texels.Area() || texels.Area() <= kSmallArea;
    if (!too_large && is_good) return std::nullopt;
    std::optional<Split> best;
    for (int axis = 0; axis < 2; ++axis) {
      if (too_large && texels.Size()[axis] <= max_side_) continue;
      SortAlong(axis, faces);
      Split split = BestSlices(axis, faces, padding);
      if (!best || split.area < best->area) best = std::move(split);
    }
    if (best->ends.size() < 2) best = Halves(best->axis, faces.size());
    if (!too_large && best->area > kMaxPartAfterSplit * texels.Area()) return std::nullopt;
    return best;
  }

  static Split Halves(int axis, size_t count) {
    return {axis, {count / 2, count}, std::numeric_limits<double>::infinity()};
  }

  // Of sorted faces: cut into kMaxSlices thin slices, those that follow each other are joined where
  // that makes the sum of the rectangles' areas least.
  static Split BestSlices(int axis, std::span<const FaceBox> faces, int padding) {
    const size_t n = std::min(faces.size(), kMaxSlices);
    std::vector<Eigen::AlignedBox2d> slices(n);
    const auto begin_of = [&](size_t slice) { return slice * faces.size() / n; };
    for (size_t i = 0; i < n; ++i) {
      slices[i] = BoxOf(faces.subspan(begin_of(i), begin_of(i + 1) - begin_of(i)));
    }
    std::vector<double> least(n + 1, std::numeric_limits<double>::infinity());
    std::vector<size_t> from(n + 1, 0);
    least[0] = 0;
    for (size_t end = 1; end <= n; ++end) {
      Eigen::AlignedBox2d box;
      for (size_t begin = end; begin-- > 0;) {
        box.extend(slices[begin]);
        const double area = least[begin] + TexelsOf(box, padding).Area();
        if (area >= least[end]) continue;
        least[end] = area;
        from[end] = begin;
      }
    }
    Split split{axis, {}, least[n]};
    for (size_t end = n; end > 0; end = from[end]) split.ends.push_back(begin_of(end));
    std::reverse(split.ends.begin(), split.ends.end());
    return split;
  }

  void Emit(int32_t label, const ChartLayout& layout, std::span<FaceBox> faces,
            const TexelBox& texels) {
    Chart chart;
    chart.label = label;
    chart.map = layout.map;
    chart.photo_level = layout.photo_level;
    chart.begin = static_cast<uint32_t>(charts_.faces.size());
    for (const FaceBox& f : faces) charts_.faces.push_back(f.face);
    chart.end = static_cast<uint32_t>(charts_.faces.size());
    std::sort(charts_.faces.begin() + chart.begin, charts_.faces.end());
    chart.origin = texels.low;
    chart.size = texels.Size();
    charts_.charts.push_back(chart);
  }

  int max_side_;
  Charts& charts_;
};

// Connected faces of a label, region by region, in the order of their first faces.
std::vector<uint32_t> OrderByRegion(const FaceNeighbors& neighbors, std::span<const int32_t> labels,
                                    std::vector<uint32_t>* region_of) {
  DisjointSets regions(labels.size());
  for (uint32_t f = 0; f < labels.size(); ++f) {
    for (const int32_t other : neighbors[f]) {
      if (other < 0 || labels[f] != labels[static_cast<size_t>(other)]) continue;
      regions.Unite(f, static_cast<uint32_t>(other));
    }
  }
  region_of->resize(labels.size());
  std::vector<uint32_t> order;
  for (uint32_t f = 0; f < labels.size(); ++f) {
    (*region_of)[f] = regions.Find(f);
    if (labels[f] >= 0) order.push_back(f);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return (*region_of)[a] < (*region_of)[b]; });
  return order;
}

FaceBox BoxOfFace(const TriangleMesh& mesh, uint32_t face, const ChartMap& map) {
  FaceBox result{face, {}, 0};
  std::array<Eigen::Vector2d, 3> corners;
  for (size_t k = 0; k < 3; ++k) {
    corners[k] = map(mesh.vertices[mesh.faces[face][k]]);
    result.box.extend(corners[k]);
  }
  const Eigen::Vector2d u = corners[1] - corners[0], v = corners[2] - corners[0];
  result.area = 0.5 * std::abs(u.x() * v.y() - u.y() * v.x());
  return result;
}

}  // namespace

Charts MakeCharts(const TriangleMesh& mesh, const FaceNeighbors& neighbors,
                  std::span<const int32_t> labels, int max_side,
                  const std::function<ChartLayout(int32_t, std::span<const uint32_t>)>& layout_of) {
  std::vector<uint32_t> region_of;
  const std::vector<uint32_t> order = OrderByRegion(neighbors, labels, &region_of);
  Charts charts;
  charts.faces.reserve(order.size());
  ChartSplitter splitter(max_side, &charts);
  std::vector<FaceBox> boxes;
  for (size_t begin = 0; begin < order.size();) {
    size_t end = begin;
    while (end < order.size() && region_of[order[end]] == region_of[order[begin]]) ++end;
    const int32_t label = labels[order[begin]];
    const ChartLayout layout = layout_of(label, {order.data() + begin, end - begin});
    boxes.clear();
    for (size_t i = begin; i < end; ++i) boxes.push_back(BoxOfFace(mesh, order[i], layout.map));
    splitter.Add(label, layout, boxes);
    begin = end;
  }
  return charts;
}

}  // namespace lsmvs
