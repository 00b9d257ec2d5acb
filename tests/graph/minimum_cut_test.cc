#include "lsmvs/graph/minimum_cut.h"

#include <gtest/gtest.h>

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <random>
#include <utility>
#include <vector>

#include "lsmvs/surface/point_merging.h"
#include "lsmvs/surface/visibility_weights.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/synthetic_scene.h"

namespace lsmvs {
namespace {

using Nodes = std::vector<CutNode>;

void Connect(Nodes* nodes, int a, int i, int b, int j, int forward, int backward) {
  (*nodes)[a].neighbor[i] = b;
  (*nodes)[b].neighbor[j] = a;
  (*nodes)[a].SetReverse(i, j);
  (*nodes)[b].SetReverse(j, i);
  (*nodes)[a].capacity[i] = forward;
  (*nodes)[b].capacity[j] = backward;
}

struct GraphShape {
  int num_nodes;
  int max_capacity;
  double arc_share;       // of the arc slots that are used
  double terminal_share;  // of the nodes that are tied to a terminal
};

// Random neighbours, or, with `local`, near ones only: long thin graphs with long paths.
Nodes RandomGraph(const GraphShape& shape, bool local, std::mt19937* random) {
  Nodes nodes(static_cast<size_t>(shape.num_nodes));
  std::vector<int> used(nodes.size(), 0);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto below = [&](int n) {
    return static_cast<int>((*random)() % static_cast<unsigned>(n));
  };
  const int num_arcs = static_cast<int>(2 * shape.arc_share * shape.num_nodes);
  for (int i = 0; i < num_arcs; ++i) {
    const int a = below(shape.num_nodes);
    const int b = local ? std::min(shape.num_nodes - 1, a + 1 + below(3)) : below(shape.num_nodes);
    if (a == b || used[a] == 4 || used[b] == 4) continue;
    Connect(&nodes, a, used[a]++, b, used[b]++, below(shape.max_capacity + 1),
            below(shape.max_capacity + 1));
  }
  for (int x = 0; x < shape.num_nodes; ++x) {
    if (uniform(*random) > shape.terminal_share) continue;
    const bool source = local ? x < shape.num_nodes / 2 : below(2) == 0;
    nodes[x].excess = (source ? 1 : -1) * below(2 * shape.max_capacity + 1);
  }
  return nodes;
}

// The value of the cut that the labels make, in the graph as it was.
int64_t CutValue(const Nodes& before, const Nodes& after) {
  int64_t value = 0;
  for (size_t x = 0; x < before.size(); ++x) {
    const bool source = after[x].OnSourceSide();
    if (before[x].excess > 0 && !source) value += before[x].excess;
    if (before[x].excess < 0 && source) value -= before[x].excess;
    for (int i = 0; i < 4; ++i) {
      const int y = before[x].neighbor[i];
      if (y >= 0 && source && !after[y].OnSourceSide()) value += before[x].capacity[i];
    }
  }
  return value;
}

int64_t BoostFlow(const Nodes& nodes) {
  using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
  using Graph = boost::adjacency_list<
      boost::vecS, boost::vecS, boost::directedS,
      boost::property<boost::vertex_index_t, long,
                      boost::property<boost::vertex_color_t, boost::default_color_type,
                                      boost::property<boost::vertex_distance_t, long,
                                                      boost::property<boost::vertex_predecessor_t,
                                                                      Traits::edge_descriptor>>>>,
      boost::property<
          boost::edge_capacity_t, int64_t,
          boost::property<boost::edge_residual_capacity_t, int64_t,
                          boost::property<boost::edge_reverse_t, Traits::edge_descriptor>>>>;
  Graph graph(nodes.size() + 2);
  const size_t source = nodes.size(), sink = source + 1;
  const auto add = [&](size_t a, size_t b, int64_t capacity) {
    const auto forward = boost::add_edge(a, b, graph).first;
    const auto backward = boost::add_edge(b, a, graph).first;
    boost::put(boost::edge_capacity, graph, forward, capacity);
    boost::put(boost::edge_capacity, graph, backward, 0);
    boost::put(boost::edge_reverse, graph, forward, backward);
    boost::put(boost::edge_reverse, graph, backward, forward);
  };
  for (size_t x = 0; x < nodes.size(); ++x) {
    if (nodes[x].excess > 0) add(source, x, nodes[x].excess);
    if (nodes[x].excess < 0) add(x, sink, -nodes[x].excess);
    for (int i = 0; i < 4; ++i) {
      const int y = nodes[x].neighbor[i];
      if (y >= 0 && nodes[x].capacity[i] > 0) add(x, static_cast<size_t>(y), nodes[x].capacity[i]);
    }
  }
  return boost::boykov_kolmogorov_max_flow(graph, source, sink);
}

void ExpectSameCutInParts(const Nodes& graph, const Nodes& whole, int64_t flow) {
  const size_t n = graph.size();
  for (const size_t part_size : {(n + 1) / 2, n / 7 + 1, n / 64 + 1, size_t{1}}) {
    Nodes cut = graph;
    EXPECT_EQ(MaximizeFlow(&cut, RunContext(1), part_size), flow) << part_size;
    size_t num_wrong = 0;
    for (size_t x = 0; x < n; ++x) num_wrong += cut[x].OnSourceSide() != whole[x].OnSourceSide();
    EXPECT_EQ(num_wrong, 0u) << "parts of " << part_size << " of " << n;
  }
}

void ExpectMinimumCut(const Nodes& graph) {
  Nodes cut = graph;
  const int64_t flow = MaximizeFlow(&cut, RunContext(1));
  EXPECT_EQ(flow, CutValue(graph, cut));
  EXPECT_EQ(flow, BoostFlow(graph));
  ExpectSameCutInParts(graph, cut, flow);
}

TEST(MinimumCut, EmptyGraphs) {
  Nodes nodes;
  EXPECT_EQ(MaximizeFlow(&nodes, RunContext(1)), 0);
  nodes.resize(3);
  EXPECT_EQ(MaximizeFlow(&nodes, RunContext(1)), 0);
  EXPECT_FALSE(nodes[0].OnSourceSide());
}

TEST(MinimumCut, ChainIsCutAtItsWeakestArc) {
  Nodes nodes(5);
  nodes[0].excess = 100;
  nodes[4].excess = -100;
  const int capacities[] = {9, 5, 3, 7};
  for (int i = 0; i < 4; ++i) Connect(&nodes, i, 1, i + 1, 0, capacities[i], 0);
  EXPECT_EQ(MaximizeFlow(&nodes, RunContext(1)), 3);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(nodes[i].OnSourceSide(), i <= 2) << i;
}

TEST(MinimumCut, NodesThatNothingTiesAreOnTheSinksSide) {
  Nodes nodes(3);
  nodes[0].excess = 5;
  Connect(&nodes, 0, 0, 1, 0, 0, 4);  // only towards the source's node
  EXPECT_EQ(MaximizeFlow(&nodes, RunContext(1)), 0);
  EXPECT_TRUE(nodes[0].OnSourceSide());
  EXPECT_FALSE(nodes[1].OnSourceSide());
  EXPECT_FALSE(nodes[2].OnSourceSide());
}

class RandomCuts : public testing::TestWithParam<GraphShape> {};

TEST_P(RandomCuts, HaveTheValueOfBoostsFlow) {
  std::mt19937 random(7);
#ifdef LSMVS_SANITIZED
  constexpr int kNumGraphs = 30;
#else
  constexpr int kNumGraphs = 300;
#endif
  for (int i = 0; i < kNumGraphs && !HasFailure(); ++i) {
    ExpectMinimumCut(RandomGraph(GetParam(), i % 2 == 0, &random));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RandomCuts,
                         testing::Values(GraphShape{2, 3, 1.0, 0.9}, GraphShape{6, 4, 0.9, 0.6},
                                         GraphShape{20, 2, 0.9, 0.3}, GraphShape{60, 10, 0.95, 0.4},
                                         GraphShape{200, 1000, 0.95, 0.1},
                                         GraphShape{300, 1, 0.9, 0.5},
                                         GraphShape{500, 100, 1.0, 0.02},
                                         GraphShape{500, 1 << 20, 0.7, 0.5}));

// The graph that a scene's rays make of its tetrahedra, as it is cut to make a surface.
Nodes SceneGraph(ShapeName shape, double outlier_fraction, double quality_regularization = 1) {
  const RunContext context(1);
  const SyntheticScene scene = MakeScene(shape, 10, 160, 120);
  SampledCloudOptions sampling;
  sampling.num_points = 2000;
  sampling.outlier_fraction = outlier_fraction;
  MergedCloud merged =
      MergePoints(scene.scene, SampleCloud(*scene.shape, scene.scene, sampling, context),
                  {.max_proj_dist = 2, .max_depth_dist = 0.01, .visibility_sigma = 3}, context);
  Tetrahedralization complex = BuildDelaunay(std::exchange(merged.positions, {}));
  WeighCells(scene.scene, merged,
             {.distance_sigma_factor = 1,
              .sink_distance_factor = 0.5,
              .quality_regularization = quality_regularization},
             context, &complex);
  return {complex.cells.begin(), complex.cells.end()};
}

TEST(MinimumCut, GraphsOfScenes) {
  for (const ShapeName shape :
       {ShapeName::kSphere, ShapeName::kPole, ShapeName::kRelief, ShapeName::kTerrain}) {
    for (const double outlier_fraction : {0.0, 0.3}) {
      const Nodes graph = SceneGraph(shape, outlier_fraction);
      EXPECT_GT(graph.size(), 1000u);
      ExpectMinimumCut(graph);
    }
  }
}

// Labels do not depend on the parts, whatever facets weigh against rays.
TEST(MinimumCut, GraphsOfScenesInPartsAtAnyQualityWeight) {
  for (const ShapeName shape :
       {ShapeName::kSphere, ShapeName::kTorus, ShapeName::kThinWalls, ShapeName::kTerrain}) {
    for (const double quality_regularization : {0.05, 0.7, 7.0}) {
      const Nodes graph = SceneGraph(shape, 0.5, quality_regularization);
      Nodes whole = graph;
      const int64_t flow = MaximizeFlow(&whole, RunContext(1));
      EXPECT_EQ(flow, CutValue(graph, whole));
      ExpectSameCutInParts(graph, whole, flow);
    }
  }
}

// A cube of cells in which flow must wind around blocked layers.
TEST(MinimumCut, LongPaths) {
  std::mt19937 random(3);
  GraphShape shape{20000, 50, 1.0, 0.01};
  ExpectMinimumCut(RandomGraph(shape, true, &random));
}

}  // namespace
}  // namespace lsmvs
