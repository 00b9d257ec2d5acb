#include "lsmvs/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace lsmvs {
namespace {

using testing::HasSubstr;
using testing::Not;

Report SmallReport() {
  Report report;
  report.title = "A <b>title</b>";
  report.program = "lsmvs 1";
  ReportMesh mesh;
  mesh.title = "one </script>";
  mesh.file = "one.ply";
  mesh.shown.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.shown.faces = {{0, 1, 2}};
  mesh.figures.name = "one.ply";
  mesh.figures.inspection = Inspect(mesh.shown);
  mesh.seconds = 3.5;
  report.meshes.push_back(mesh);
  report.missing.emplace_back("two", "because");
  return report;
}

TEST(Report, JsonHoldsTheFiguresAndNoGeometry) {
  const nlohmann::json json = nlohmann::json::parse(MakeReportJson(SmallReport()));
  EXPECT_EQ(json["meshes"][0]["figures"]["mesh"]["faces"], 1);
  EXPECT_EQ(json["meshes"][0]["seconds"], 3.5);
  EXPECT_FALSE(json["meshes"][0].contains("packed"));
  EXPECT_EQ(json["missing"][0]["reason"], "because");
}

TEST(Report, PageIsOneFileWithItsData) {
  if (!HasReportPage()) GTEST_SKIP() << "this build has no comparison page";
  const std::string page = MakeReportPage(SmallReport());
  EXPECT_THAT(page, HasSubstr("A &lt;b&gt;title&lt;/b&gt;"));
  EXPECT_THAT(page, HasSubstr("id=\"mesh-0\""));
  EXPECT_THAT(page, HasSubstr("one \\u003c/script>"));
  EXPECT_THAT(page, Not(HasSubstr("LSMVS-")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_EQ(page, MakeReportPage(SmallReport()));
}

TEST(Report, NeedsAMesh) { EXPECT_THROW(MakeReportPage(Report()), std::logic_error); }

}  // namespace
}  // namespace lsmvs
