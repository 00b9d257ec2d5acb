#include "lsmvs/report/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "lsmvs/report/page/mesh_packing.h"
#include "lsmvs/report/page/page_template.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

using Json = nlohmann::ordered_json;

Json VectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ViewpointJson(const PosedCamera& viewpoint) {
  const PinholeCamera& c = viewpoint.camera;
  const Eigen::Matrix3d& r = viewpoint.cam_from_world.rotation;
  Json rotation = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(r(row, column));
  }
  return {
      {"width", c.width},     {"height", c.height},
      {"fx", c.fx},           {"fy", c.fy},
      {"cx", c.cx},           {"cy", c.cy},
      {"rotation", rotation}, {"translation", VectorJson(viewpoint.cam_from_world.translation)}};
}

Json MeshJson(const ReportMesh& mesh) {
  Json json = {{"title", mesh.title}, {"file", mesh.file}, {"origin", mesh.origin}};
  if (!mesh.picture.empty()) json["picture"] = mesh.picture;
  json["file_bytes"] = mesh.file_bytes;
  json["faces_shown"] = mesh.shown.faces.size();
  if (mesh.seconds) json["seconds"] = *mesh.seconds;
  if (mesh.peak_bytes) json["peak_bytes"] = *mesh.peak_bytes;
  json["figures"] = Json::parse(ToJson(mesh.figures));
  return json;
}

Json CloudJson(const ReportCloud& cloud) {
  return {{"title", cloud.title},
          {"file", cloud.file},
          {"origin", cloud.origin},
          {"file_bytes", cloud.file_bytes},
          {"figures", Json::parse(ToJson(cloud.figures))}};
}

Json ReportJson(const Report& report) {
  Json json = {
      {"title", report.title},   {"workspace", report.workspace}, {"program", report.program},
      {"meshes", Json::array()}, {"clouds", Json::array()},       {"missing", Json::array()},
      {"stages", Json::array()}, {"options", Json::array()},      {"notes", report.notes}};
  for (const ReportMesh& mesh : report.meshes) json["meshes"].push_back(MeshJson(mesh));
  for (const ReportCloud& cloud : report.clouds) json["clouds"].push_back(CloudJson(cloud));
  for (const auto& [title, reason] : report.missing) {
    json["missing"].push_back({{"title", title}, {"reason", reason}});
  }
  for (const ReportStage& stage : report.stages) {
    Json entry = {{"name", stage.name}, {"seconds", stage.seconds}};
    if (stage.peak_bytes) entry["peak_bytes"] = *stage.peak_bytes;
    json["stages"].push_back(entry);
  }
  for (const auto& [name, value] : report.options) {
    json["options"].push_back({{"name", name}, {"value", value}});
  }
  return json;
}

// Text that may stand between script tags: no "<" can end them.
std::string ScriptSafe(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string HtmlEscaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string DataElement(const std::string& id, const char* type, const std::string& content) {
  return fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", type, id, content);
}

// The elements that the page's program reads its data from.
std::string DataElements(const Report& report) {
  Json json = ReportJson(report);
  json["up"] = VectorJson(report.up);
  json["focus"] = VectorJson(report.focus);
  json["radius"] = report.radius;
  json["key_photo"] = report.key_photo;
  json["error_caption"] = report.error_caption;
  json["photos"] = Json::array();
  std::string elements;
  for (size_t i = 0; i < report.photos.size(); ++i) {
    const ReportPhoto& photo = report.photos[i];
    Json entry = ViewpointJson(photo.viewpoint);
    entry["name"] = photo.name;
    entry["has_picture"] = !photo.jpeg.empty();
    json["photos"].push_back(entry);
    if (photo.jpeg.empty()) continue;
    elements += DataElement(fmt::format("photo-{}", i), "text/plain", Base64(photo.jpeg));
  }
  for (size_t i = 0; i < report.meshes.size(); ++i) {
    const ReportMesh& mesh = report.meshes[i];
    const PackedMesh packed = PackMesh(mesh.shown, mesh.errors, mesh.texcoords, mesh.texture_size);
    json["meshes"][i]["packed"] = {
        {"origin", VectorJson(packed.origin)}, {"step", packed.step},
        {"vertices", packed.num_vertices},     {"faces", packed.num_faces},
        {"colors", packed.has_colors},         {"errors", packed.has_errors},
        {"texture", packed.has_texture}};
    if (packed.has_texture) {
      elements +=
          DataElement(fmt::format("texture-{}", i), "text/plain", Base64(mesh.texture_jpeg));
    }
    elements += DataElement(fmt::format("mesh-{}", i), "text/plain", Base64(packed.bytes));
  }
  return DataElement("report", "application/json",
                     ScriptSafe(json.dump(-1, ' ', false, Json::error_handler_t::replace))) +
         elements;
}

void Replace(const std::string& mark, const std::string& text, std::string* page) {
  const size_t place = page->find(mark);
  LSMVS_CHECK(place != std::string::npos);
  page->replace(place, mark.size(), text);
}

}  // namespace

bool HasReportPage() { return !PageTemplate().empty(); }

std::string MakeReportPage(const Report& report) {
  LSMVS_CHECK(!report.meshes.empty());
  if (!HasReportPage()) {
    throw Error(ExitCode::kUsage,
                "this build has no comparison page; build with npm installed and "
                "-DLSMVS_BUILD_REPORT_PAGE=ON");
  }
  std::string page(PageTemplate());
  Replace("<!--LSMVS-TITLE-->", HtmlEscaped(report.title), &page);
  Replace("<!--LSMVS-DATA-->", DataElements(report), &page);
  return page;
}

std::string MakeReportJson(const Report& report) {
  return ReportJson(report).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace lsmvs
