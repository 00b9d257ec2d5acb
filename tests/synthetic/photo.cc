#include "lsmvs/synthetic/photo.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr size_t kRowsPerBlock = 4;

// One pixel's hit; distance 0 where the ray meets nothing.
struct Hit {
  double distance = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

// Where the shadow lies while one photo is taken.
struct Shadow {
  Eigen::Vector3d across;
  double middle;
};

class Renderer {
 public:
  Renderer(const Shape& shape, const View& view, int view_idx, const PhotoOptions& options)
      : shape_(shape),
        options_(options),
        texture_(options.texture),
        camera_(view.camera),
        world_from_cam_(view.cam_from_world.rotation.transpose()),
        center_(view.CenterInWorld()),
        light_(options.light.normalized()) {
    Random random(options.seed, static_cast<uint64_t>(view_idx));
    gain_ = (1 + options.gain_sigma * random.Gaussian()) *
            (view_idx % 2 == 1 ? options.exposure_step : 1.0);
    offset_ = options.offset_sigma * random.Gaussian();
    const double angle = random.Uniform(0, 2 * std::numbers::pi);
    shadow_ = {{std::cos(angle), std::sin(angle), 0.0}, random.Uniform(-0.6, 0.6)};
    noise_seed_ = random.Bits();
  }

  ColorImage Render(const RunContext& context) const {
    const Raster<Hit> hits = CastAll(context);
    ColorImage image(camera_.width, camera_.height);
    ForRows(context, [&](int row) {
      Random random(noise_seed_, static_cast<uint64_t>(row));
      for (int column = 0; column < camera_.width; ++column) {
        const Eigen::Vector3d light = IsEdge(hits, column, row)
                                          ? Supersampled(column, row)
                                          : Shade(hits(column, row), column + 0.5, row + 0.5);
        image(column, row) = Develop(light, &random);
      }
    });
    return image;
  }

 private:
  template <class Body>
  void ForRows(const RunContext& context, const Body& body) const {
    ParallelFor(context, static_cast<size_t>(camera_.height), kRowsPerBlock,
                [&](size_t row) { body(static_cast<int>(row)); });
  }

  Eigen::Vector3d Direction(double x_px, double y_px) const {
    return world_from_cam_ * camera_.Ray({x_px, y_px}).normalized();
  }

  Hit Cast(double x_px, double y_px) const {
    const auto hit = shape_.Intersect(center_, Direction(x_px, y_px));
    return hit ? Hit{hit->distance, hit->normal} : Hit{};
  }

  Raster<Hit> CastAll(const RunContext& context) const {
    Raster<Hit> hits(camera_.width, camera_.height);
    ForRows(context, [&](int row) {
      for (int column = 0; column < camera_.width; ++column) {
        hits(column, row) = Cast(column + 0.5, row + 0.5);
      }
    });
    return hits;
  }

  // Whether the surface of a pixel does not go on smoothly into one of its four neighbours.
  bool IsEdge(const Raster<Hit>& hits, int column, int row) const {
    if (options_.supersampling <= 1) return false;
    const Hit& hit = hits(column, row);
    const auto breaks = [&](int c, int r) {
      if (!hits.Inside(c, r)) return false;
      const Hit& other = hits(c, r);
      if ((hit.distance > 0) != (other.distance > 0)) return true;
      if (hit.distance <= 0) return false;
      if (hit.normal.dot(other.normal) < 0.95) return true;
      const Eigen::Vector3d step = other.distance * Direction(c + 0.5, r + 0.5) -
                                   hit.distance * Direction(column + 0.5, row + 0.5);
      return std::abs(step.dot(hit.normal)) > hit.distance / camera_.MeanFocalLength();
    };
    return breaks(column - 1, row) || breaks(column + 1, row) || breaks(column, row - 1) ||
           breaks(column, row + 1);
  }

  Eigen::Vector3d Supersampled(int column, int row) const {
    const int side = options_.supersampling;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double x = column + (i + 0.5) / side, y = row + (j + 0.5) / side;
        sum += Shade(Cast(x, y), x, y);
      }
    }
    return sum / (side * side);
  }

  // Light that a pixel around (x_px, y_px) gets: red, green, blue in [0, 255], before gain and
  // noise.
  Eigen::Vector3d Shade(const Hit& hit, double x_px, double y_px) const {
    if (hit.distance <= 0) return options_.background.cast<double>();
    const Eigen::Vector3d direction = Direction(x_px, y_px);
    const Eigen::Vector3d x = center_ + hit.distance * direction;
    const Eigen::Vector3d albedo = FilteredAlbedo(hit, x, x_px, y_px, direction);
    const double lambert = std::max(0.0, hit.normal.dot(light_)) * LightReaching(x, hit.normal);
    const double light = options_.ambient + (1 - options_.ambient) * lambert;
    Eigen::Vector3d color = 255.0 * light * ShadowFactor(x) * albedo;
    if (options_.specular > 0) {
      const Eigen::Vector3d half = (light_ - direction).normalized();
      const double shine =
          std::pow(std::max(0.0, half.dot(hit.normal)), options_.specular_exponent);
      color.array() += 255.0 * options_.specular * shine;
    }
    return color;
  }

  // On slanted surfaces a pixel covers a long strip: the average of up to four places along it.
  Eigen::Vector3d FilteredAlbedo(const Hit& hit, const Eigen::Vector3d& x, double x_px, double y_px,
                                 const Eigen::Vector3d& direction) const {
    const double footprint = hit.distance / camera_.MeanFocalLength();
    const double cosine = std::max(0.05, -direction.dot(hit.normal));
    const int num_taps = std::clamp(static_cast<int>(std::ceil(0.9 / cosine)), 1, 4);
    if (num_taps == 1) return texture_.Albedo(x, footprint).cast<double>();
    const Eigen::Vector3d normal_in_cam = world_from_cam_.transpose() * hit.normal;
    const Eigen::Vector2d along = normal_in_cam.head<2>().normalized();
    const double tap_footprint = footprint * std::max(1.0, 1.0 / (cosine * num_taps));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < num_taps; ++i) {
      const Eigen::Vector2d shift = along * ((i + 0.5) / num_taps - 0.5);
      const Eigen::Vector3d ray = Direction(x_px + shift.x(), y_px + shift.y());
      // Where the shifted ray meets the tangent plane.
      const double distance = hit.distance * direction.dot(hit.normal) / ray.dot(hit.normal);
      const bool ahead = distance > 0 && distance < 2 * hit.distance;
      const Eigen::Vector3d place = ahead ? Eigen::Vector3d(center_ + distance * ray) : x;
      sum += texture_.Albedo(place, tap_footprint).cast<double>();
    }
    return sum / num_taps;
  }

  double LightReaching(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
    if (!options_.cast_shadows || normal.dot(light_) <= 0) return 1.0;
    const double lift = 1e-4 * (x - center_).norm();
    return shape_.Intersect(x + lift * normal, light_) ? 0.0 : 1.0;
  }

  double ShadowFactor(const Eigen::Vector3d& x) const {
    if (options_.moving_shadow <= 0) return 1.0;
    constexpr double kHalfWidth = 0.25, kSoftness = 0.05;
    const double aside = std::abs(x.dot(shadow_.across) - shadow_.middle);
    const double lit = std::clamp((aside - kHalfWidth) / kSoftness + 0.5, 0.0, 1.0);
    return 1.0 - options_.moving_shadow * (1.0 - lit);
  }

  Color Develop(const Eigen::Vector3d& light, Random* random) const {
    Eigen::Vector3d value = gain_ * light + Eigen::Vector3d::Constant(offset_);
    if (options_.noise_sigma > 0) value += options_.noise_sigma * random->Gaussian3();
    return value.array().round().max(0.0).min(255.0).matrix().cast<uint8_t>();
  }

  const Shape& shape_;
  const PhotoOptions& options_;
  SolidTexture texture_;
  PinholeCamera camera_;
  Eigen::Matrix3d world_from_cam_;
  Eigen::Vector3d center_, light_;
  double gain_ = 1, offset_ = 0;
  Shadow shadow_;
  uint64_t noise_seed_ = 0;
};

}  // namespace

void PhotoOptions::Describe(OptionSet* options) {
  options->Add("Photo.contrast", &texture.contrast, "contrast of the texture", {0.0, 10.0});
  options->Add("Photo.weak_fraction", &texture.weak_fraction,
               "share of the surface that has hardly any texture", {0.0, 1.0});
  options->Add("Photo.ambient", &ambient, "share of light from everywhere; 1: no shading",
               {0.0, 1.0});
  options->Add("Photo.cast_shadows", &cast_shadows, "whether the shape casts shadows");
  options->Add("Photo.gain_sigma", &gain_sigma, "standard deviation of the gain of each photo",
               {0.0, 1.0});
  options->Add("Photo.offset_sigma", &offset_sigma,
               "standard deviation of what is added to each photo, grey levels", {0.0, 255.0});
  options->Add("Photo.noise_sigma", &noise_sigma,
               "standard deviation of the sensor noise, grey levels", {0.0, 255.0});
  options->Add("Photo.exposure_step", &exposure_step, "gain of every second photo", {0.01, 100.0});
  options->Add("Photo.moving_shadow", &moving_shadow,
               "share of light that a band takes away which lies elsewhere in each photo",
               {0.0, 1.0});
  options->Add("Photo.specular", &specular, "strength of a highlight, share of white", {0.0, 1.0});
  options->Add("Photo.supersampling", &supersampling, "rays per side of a pixel at edges; 1: none",
               {1, 16});
}

ColorImage RenderPhoto(const Shape& shape, const Scene& scene, int view_idx,
                       const PhotoOptions& options, const RunContext& context) {
  LSMVS_CHECK_LT(view_idx, scene.num_views());
  const View& view = scene.views[static_cast<size_t>(view_idx)];
  return Renderer(shape, view, view_idx, options).Render(context);
}

void WriteImage(const std::string& path, const ColorImage& image) {
  constexpr int kJpegQuality = 95;
  if (std::filesystem::path(path).extension() == ".png") {
    WritePng(path, image);
  } else {
    WriteJpeg(path, image, kJpegQuality);
  }
}

void WritePhotos(const Shape& shape, const PhotoOptions& options, const std::string& folder,
                 Scene* scene, const RunContext& context) {
  for (int v = 0; v < scene->num_views(); ++v) {
    const std::string path = (std::filesystem::path(folder) / scene->views[v].name).string();
    WriteImage(path, RenderPhoto(shape, *scene, v, options, context));
    context.Report((v + 1.0) / scene->num_views());
  }
  scene->image_folder = folder;
}

}  // namespace lsmvs
