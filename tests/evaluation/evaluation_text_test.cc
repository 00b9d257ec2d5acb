#include "lsmvs/evaluation/evaluation_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "lsmvs/test_evaluation/test_meshes.h"

namespace lsmvs {
namespace {

MeshFigures Figures() {
  const RunContext context(1);
  const TriangleMesh mesh = test::PlaneMesh(10, 10, 0.02), truth = test::PlaneMesh(10, 10, 0);
  std::vector<View> views = {test::DownwardView({5, 5, 10}), test::DownwardView({6, 5, 10})};
  views[0].name = "left.jpg";
  views[1].name = "right.jpg";
  MeshFigures figures;
  figures.name = "mesh.ply";
  figures.inspection = Inspect(mesh);
  SurfaceEvaluationOptions options;
  options.num_samples = 100;
  figures.surface = EvaluateSurface(mesh, truth, views, options, context);
  figures.depth_errors =
      MeasureDepthErrors(MeshTracer(mesh, context), MeshTracer(truth, context), views, {}, context);
  return figures;
}

TEST(EvaluationText, JsonHoldsTheFigures) {
  const nlohmann::json json = nlohmann::json::parse(ToJson(Figures()));
  EXPECT_EQ(json["name"], "mesh.ply");
  EXPECT_EQ(json["mesh"]["faces"], 32);
  EXPECT_EQ(json["mesh"]["components"], 1);
  EXPECT_EQ(json["surface"]["status"], "ok");
  EXPECT_EQ(json["surface"]["thresholds"].size(), 4u);
  EXPECT_NEAR(json["surface"]["accuracy"]["mean_gsd"], 0.4, 1e-3);
  EXPECT_EQ(json["surface"]["f1"][0], 1);
  EXPECT_EQ(json["depth_errors"]["views"][1]["view"], "right.jpg");
  EXPECT_FALSE(json.contains("photometric"));
}

TEST(EvaluationText, TableIsReadable) {
  const std::string table = ToTable(Figures());
  EXPECT_THAT(table, testing::HasSubstr("mesh.ply"));
  EXPECT_THAT(table, testing::HasSubstr("F1"));
  EXPECT_THAT(table, testing::HasSubstr("left.jpg"));
  for (size_t begin = 0; begin < table.size();) {
    const size_t end = table.find('\n', begin);
    EXPECT_LE(end - begin, 100u);
    begin = end + 1;
  }
}

TEST(EvaluationText, TableNamesTheUnit) {
  MeshFigures figures = Figures();
  EXPECT_THAT(ToTable(figures), testing::HasSubstr("unit: 1 GSD (one pixel on the surface) = "));
  figures.surface->gsd = 0;
  figures.surface->unit_in_world = 0.014;
  EXPECT_THAT(ToTable(figures),
              testing::HasSubstr("unit: 1/1000 of the truth's diagonal (no cameras were given) = "
                                 "0.014 in the unit of the files"));
  figures.surface->unit_in_world = 1;
  EXPECT_THAT(ToTable(figures), testing::HasSubstr("unit: that of the files"));
}

}  // namespace
}  // namespace lsmvs
