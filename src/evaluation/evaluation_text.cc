#include "lsmvs/evaluation/evaluation_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace lsmvs {

namespace {

using Json = nlohmann::ordered_json;

std::string StatusName(SurfaceEvaluation::Status status) {
  switch (status) {
    case SurfaceEvaluation::Status::kOk:
      return "ok";
    case SurfaceEvaluation::Status::kEmptyReconstruction:
      return "empty_reconstruction";
    case SurfaceEvaluation::Status::kEmptyTruth:
      return "empty_truth";
    case SurfaceEvaluation::Status::kNothingSeen:
      return "nothing_seen";
  }
  return "";
}

Json InspectionJson(const MeshInspection& m) {
  return {{"vertices", m.num_vertices},
          {"faces", m.num_faces},
          {"edges", m.num_edges},
          {"components", m.num_components},
          {"border_edges", m.num_border_edges},
          {"nonmanifold_edges", m.num_nonmanifold_edges},
          {"nonmanifold_vertices", m.num_nonmanifold_vertices},
          {"misoriented_edges", m.num_misoriented_edges},
          {"degenerate_faces", m.num_degenerate_faces},
          {"duplicate_faces", m.num_duplicate_faces},
          {"unused_vertices", m.num_unused_vertices},
          {"area", m.area},
          {"manifold", m.IsManifold()},
          {"closed", m.IsClosed()}};
}

Json CloudJson(const CloudFigures& c) {
  Json json = {{"points", c.num_points}};
  if (c.mean_views) json["mean_views"] = *c.mean_views;
  if (c.mean_score) json["mean_score"] = *c.mean_score;
  if (c.coverage) json["coverage"] = *c.coverage;
  return json;
}

Json StatisticsJson(const DistanceStatistics& s, double gsd) {
  Json json = {{"points", s.num_points}, {"unseen_points", s.num_unseen},
               {"shares", s.shares},     {"mean", s.mean},
               {"median", s.median},     {"percentile_95", s.percentile_95}};
  if (gsd > 0) {
    json["mean_gsd"] = s.mean / gsd;
    json["median_gsd"] = s.median / gsd;
    json["percentile_95_gsd"] = s.percentile_95 / gsd;
  }
  return json;
}

Json SurfaceJson(const SurfaceEvaluation& e) {
  Json json = {{"status", StatusName(e.status)},
               {"kind", e.is_cloud ? "cloud" : "mesh"},
               {"vertices", e.num_vertices},
               {"faces", e.num_faces},
               {"left_out_not_finite", e.num_not_finite},
               {"unit_in_world", e.unit_in_world},
               {"thresholds", e.thresholds},
               {"accuracy", StatisticsJson(e.accuracy, e.gsd)},
               {"completeness", StatisticsJson(e.completeness, e.gsd)},
               {"f1", e.f1},
               {"seconds",
                {{"sampling", e.sampling_seconds},
                 {"visibility", e.visibility_seconds},
                 {"distances", e.distance_seconds}}}};
  if (e.gsd > 0) json["gsd"] = e.gsd;
  if (!e.message.empty()) json["message"] = e.message;
  return json;
}

Json HistogramJson(const DepthErrorHistogram& h) {
  return {{"view", h.name},           {"pixels", h.Total()},
          {"bins", h.bins},           {"larger", h.num_larger},
          {"missing", h.num_missing}, {"median_relative", h.median_relative}};
}

Json DepthErrorsJson(const DepthErrors& errors) {
  Json json = {{"all", HistogramJson(errors.all)}, {"views", Json::array()}};
  for (const DepthErrorHistogram& view : errors.views) json["views"].push_back(HistogramJson(view));
  return json;
}

Json PhotometricJson(const PhotometricScore& score) {
  Json json = {{"coverage", score.coverage},
               {"mean_zncc", score.mean_zncc},
               {"median_zncc", score.median_zncc},
               {"score", score.score},
               {"views", Json::array()}};
  for (const PhotometricViewScore& view : score.views) {
    json["views"].push_back({{"view", view.name},
                             {"coverage", view.Coverage()},
                             {"mean_zncc", view.MeanZncc()},
                             {"score", view.Score()}});
  }
  return json;
}

Json SilhouettesJson(const SilhouetteFigures& s) {
  return {{"views", s.num_views},         {"coverage", s.coverage},
          {"hole_share", s.hole_share},   {"torn_share", s.torn_share},
          {"crumb_share", s.crumb_share}, {"rim", s.rim}};
}

Json TextureJson(const TextureScore& score) {
  Json json = {{"completeness", score.completeness},
               {"psnr", score.psnr},
               {"ssim", score.ssim},
               {"one_minus_ncc", score.one_minus_ncc},
               {"views", Json::array()}};
  for (const TextureViewScore& view : score.views) {
    json["views"].push_back({{"view", view.name},
                             {"pixels", view.num_pixels},
                             {"completeness", view.completeness},
                             {"gain", view.gain},
                             {"bias", view.bias},
                             {"psnr", view.psnr},
                             {"ssim", view.ssim},
                             {"one_minus_ncc", view.one_minus_ncc}});
  }
  return json;
}

Json AtlasJson(const AtlasFigures& a) {
  return {{"pages", a.num_pages},
          {"texels", a.num_texels},
          {"charts", a.num_charts},
          {"utilisation", a.utilisation},
          {"seam_samples", a.num_seam_samples},
          {"seam_step", a.seam_step},
          {"inner_step", a.inner_step},
          {"seam_ratio", a.seam_ratio},
          {"photo_step", a.photo_step},
          {"photo_ratio", a.photo_ratio}};
}

template <class View>
std::vector<View> ByName(std::vector<View> views) {
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.name < b.name; });
  return views;
}

std::string InspectionTable(const MeshInspection& m) {
  return fmt::format(
      "  {} vertices, {} faces, {} components; {}, {} border edges, {} non-manifold edges\n",
      m.num_vertices, m.num_faces, m.num_components, m.IsManifold() ? "manifold" : "not manifold",
      m.num_border_edges, m.num_nonmanifold_edges);
}

std::string CloudTable(const CloudFigures& c) {
  std::string text = fmt::format("  cloud of {} points", c.num_points);
  if (c.mean_views) text += fmt::format(", seen by {:.2f} photos each", *c.mean_views);
  if (c.mean_score) text += fmt::format(", own score {:.3f}", *c.mean_score);
  if (c.coverage) {
    text += fmt::format("; points in {:.3f} of the photos' cells of {} x {} pixels", *c.coverage,
                        kCloudCellPixels, kCloudCellPixels);
  }
  return text + "\n";
}

std::string StatisticsRow(const char* name, const DistanceStatistics& s, double unit) {
  return fmt::format("  {:<14}{:>10.4g}{:>10.4g}{:>10.4g}   {} points ({} unseen)\n", name,
                     s.mean / unit, s.median / unit, s.percentile_95 / unit, s.num_points,
                     s.num_unseen);
}

std::string UnitText(const SurfaceEvaluation& e) {
  if (e.unit_in_world == 1) return "  unit: that of the files\n";
  return fmt::format("  unit: {} = {:.6g} in the unit of the files\n",
                     e.gsd > 0 ? "1 GSD (one pixel on the surface)"
                               : "1/1000 of the truth's diagonal (no cameras were given)",
                     e.unit_in_world);
}

std::string SurfaceTable(const SurfaceEvaluation& e) {
  if (e.status != SurfaceEvaluation::Status::kOk) return fmt::format("  {}\n", e.message);
  std::string text = UnitText(e);
  text += fmt::format("  {:<14}{:>10}{:>14}{:>10}\n", "within", "accuracy", "completeness", "F1");
  for (size_t k = 0; k < e.thresholds.size(); ++k) {
    text += fmt::format("  {:<14g}{:>10.4f}{:>14.4f}{:>10.4f}\n", e.thresholds[k],
                        e.accuracy.shares[k], e.completeness.shares[k], e.f1[k]);
  }
  text += fmt::format("  {:<14}{:>10}{:>10}{:>10}\n", "distance", "mean", "median", "95 %");
  text += StatisticsRow("accuracy", e.accuracy, e.unit_in_world);
  text += StatisticsRow("completeness", e.completeness, e.unit_in_world);
  if (e.num_not_finite > 0) {
    text += fmt::format("  left out: {} {} that are not finite\n", e.num_not_finite,
                        e.is_cloud ? "points" : "faces");
  }
  return text;
}

std::string HistogramRow(const DepthErrorHistogram& h) {
  const int last = static_cast<int>(h.bins.size());
  const double total = static_cast<double>(std::max<size_t>(1, h.Total()));
  return fmt::format("  {:<24.24}{:>8.3f}{:>8.3f}{:>8.3f}{:>9.3f}{:>9.3f}{:>12.2e}\n", h.name,
                     h.ShareBelow(std::min(1, last)), h.ShareBelow(std::min(3, last)),
                     h.ShareBelow(last), static_cast<double>(h.num_larger) / total,
                     static_cast<double>(h.num_missing) / total, h.median_relative);
}

std::string DepthErrorsTable(const DepthErrors& errors) {
  const size_t num_bins = errors.all.bins.size();
  std::string text = "  depth errors: share of the pixels that see the truth\n";
  text += fmt::format("  {:<24}{:>8}{:>8}{:>8}{:>9}{:>9}{:>12}\n", "view", "< 1 s",
                      fmt::format("< {} s", std::min<size_t>(3, num_bins)),
                      fmt::format("< {} s", num_bins), "larger", "missing", "median rel.");
  for (const DepthErrorHistogram& view : ByName(errors.views)) text += HistogramRow(view);
  return text + HistogramRow(errors.all);
}

std::string PhotometricTable(const PhotometricScore& score) {
  std::string text =
      fmt::format("  photos: coverage {:.4f}, mean ZNCC {:.4f}, median {:.4f}, score {:.4f}\n",
                  score.coverage, score.mean_zncc, score.median_zncc, score.score);
  text += fmt::format("  {:<24}{:>10}{:>10}{:>10}\n", "view", "coverage", "ZNCC", "score");
  for (const PhotometricViewScore& view : ByName(score.views)) {
    text += fmt::format("  {:<24.24}{:>10.4f}{:>10.4f}{:>10.4f}\n", view.name, view.Coverage(),
                        view.MeanZncc(), view.Score());
  }
  return text;
}

std::string SilhouettesTable(const SilhouetteFigures& s) {
  return fmt::format(
      "  from the photos' poses: hole share {:.4f}, torn share {:.4f}, rim {:.1f}, crumbs {:.4f}, "
      "covered {:.3f}\n",
      s.hole_share, s.torn_share, s.rim, s.crumb_share, s.coverage);
}

std::string TextureTable(const TextureScore& score) {
  std::string text = fmt::format(
      "  colours on {} photos: PSNR {:.2f} dB, SSIM {:.4f}, 1 - NCC {:.4f}, completeness {:.4f}\n",
      score.num_scored_views, score.psnr, score.ssim, score.one_minus_ncc, score.completeness);
  text += fmt::format("  {:<24}{:>8}{:>9}{:>10}{:>14}{:>22}\n", "view", "PSNR", "SSIM", "1 - NCC",
                      "completeness", "gain");
  for (const TextureViewScore& view : ByName(score.views)) {
    text += fmt::format("  {:<24.24}{:>8.2f}{:>9.4f}{:>10.4f}{:>14.4f}{:>8.3f}{:>7.3f}{:>7.3f}\n",
                        view.name, view.psnr, view.ssim, view.one_minus_ncc, view.completeness,
                        view.gain[0], view.gain[1], view.gain[2]);
  }
  return text;
}

std::string AtlasTable(const AtlasFigures& a) {
  std::string text =
      fmt::format("  texture: {} pages, {:.1f} million texels, utilisation {:.3f}, {} charts\n",
                  a.num_pages, a.num_texels / 1e6, a.utilisation, a.num_charts);
  if (a.num_seam_samples > 0) {
    text +=
        fmt::format("  seams: step {:.2f} grey levels, {:.2f} inside; ratio {:.3f} ({} samples)\n",
                    a.seam_step, a.inner_step, a.seam_ratio, a.num_seam_samples);
    text += fmt::format("  a photo shows {:.2f} between the same points; ratio {:.3f}\n",
                        a.photo_step, a.photo_ratio);
  }
  return text;
}

}  // namespace

std::string ToJson(const MeshFigures& figures) {
  Json json = {{"name", figures.name}};
  if (figures.inspection) json["mesh"] = InspectionJson(*figures.inspection);
  if (figures.cloud) json["cloud"] = CloudJson(*figures.cloud);
  if (figures.surface) json["surface"] = SurfaceJson(*figures.surface);
  if (figures.depth_errors) json["depth_errors"] = DepthErrorsJson(*figures.depth_errors);
  if (figures.photometric) json["photometric"] = PhotometricJson(*figures.photometric);
  if (figures.silhouettes) json["silhouettes"] = SilhouettesJson(*figures.silhouettes);
  if (figures.texture) json["texture"] = TextureJson(*figures.texture);
  if (figures.atlas) json["atlas"] = AtlasJson(*figures.atlas);
  return json.dump(2) + "\n";
}

std::string ToTable(const MeshFigures& figures) {
  std::string text = figures.name + "\n";
  if (figures.inspection) text += InspectionTable(*figures.inspection);
  if (figures.cloud) text += CloudTable(*figures.cloud);
  if (figures.silhouettes) text += SilhouettesTable(*figures.silhouettes);
  if (figures.surface) text += SurfaceTable(*figures.surface);
  if (figures.depth_errors) text += DepthErrorsTable(*figures.depth_errors);
  if (figures.photometric) text += PhotometricTable(*figures.photometric);
  if (figures.atlas) text += AtlasTable(*figures.atlas);
  if (figures.texture) text += TextureTable(*figures.texture);
  return text;
}

}  // namespace lsmvs
