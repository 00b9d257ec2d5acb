// Makes COLMAP's sparse model of a survey from the air, of any number of photos and points, without
// rendering photos: a dense workspace whose photos are all the same grey file, to test and to plan
// runs of thousands of photos.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include "lsmvs/image/image_codec.h"
#include "lsmvs/synthetic/generator.h"
#include "lsmvs/util/atomic_file.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {
namespace {

namespace fs = std::filesystem;

struct ProgramOptions {
  std::string output;
  int side = 100;
  int points_per_photo = 1000;
  int width = 4000;

  void Describe(OptionSet* options) {
    options->Add("output", &output, "folder to write; it is made if it is missing");
    options->Add("side", &side, "photos along each side of the survey", {3, 1000});
    options->Add("points_per_photo", &points_per_photo,
                 "sparse points below each photo; each is seen by up to six", {1, 100000});
    options->Add("width", &width, "of the photos [pixels]; the height is three quarters of it",
                 {64, 20000});
  }
};

constexpr const char* kUsage =
    "usage: make_large_model --output FOLDER [--option value]...\n"
    "Photos on a grid look straight down on flat ground. FOLDER gets images/, hard links of one\n"
    "grey photo, and COLMAP's sparse model with points and tracks. Memory does not grow with it.\n";

// Photos are kSpacing apart and kHeight above the ground [m]; points lie around the foot of the
// photo that they belong to, and are seen by it and its neighbours.
constexpr double kSpacing = 20, kHeight = 60;
constexpr std::array<std::array<int, 2>, 6> kSeenBy = {
    {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}}};

class LargeModel {
 public:
  explicit LargeModel(const ProgramOptions& options)
      : options_(options), height_(options.width * 3 / 4), focal_px_(0.75 * options.width) {}

  void Write() const {
    WritePhotos();
    const fs::path sparse = fs::path(options_.output) / "sparse";
    WriteCameras(sparse / "cameras.bin");
    WriteImages(sparse / "images.bin");
    WritePoints(sparse / "points3D.bin");
    fs::create_directories(fs::path(options_.output) / "stereo");
  }

 private:
  static std::string Name(uint64_t photo) { return fmt::format("photo_{:06}.png", photo); }
  bool Has(int row, int column) const {
    return row >= 0 && column >= 0 && row < options_.side && column < options_.side;
  }
  uint64_t Photo(int row, int column) const {
    return static_cast<uint64_t>(row) * static_cast<uint64_t>(options_.side) +
           static_cast<uint64_t>(column);
  }
  uint64_t NumPoints() const { return static_cast<uint64_t>(options_.points_per_photo); }

  void WritePhotos() const {
    const fs::path folder = fs::path(options_.output) / "images";
    fs::create_directories(folder);
    ColorImage grey(options_.width, height_, Color::Constant(128));
    for (size_t i = 0; i < grey.size(); i += 7) grey.pixels[i].setConstant(90);
    const fs::path first = folder / Name(0);
    WritePng(first, grey);
    const auto num_photos = static_cast<uint64_t>(options_.side) * options_.side;
    for (uint64_t photo = 1; photo < num_photos; ++photo) {
      fs::create_hard_link(first, folder / Name(photo));
    }
  }

  void WriteCameras(const fs::path& path) const {
    AtomicFile file(path);
    file.WriteValue<uint64_t>(1);
    file.WriteValue<uint32_t>(1);
    file.WriteValue<int32_t>(1);  // PINHOLE
    file.WriteValue<uint64_t>(static_cast<uint64_t>(options_.width));
    file.WriteValue<uint64_t>(static_cast<uint64_t>(height_));
    for (const double value : {focal_px_, focal_px_, options_.width / 2.0, height_ / 2.0}) {
      file.WriteValue(value);
    }
    file.Commit();
  }

  // On the ground, of point `k` below a photo.
  std::array<double, 2> Place(int row, int column, uint64_t k) const {
    // An additive sequence that covers the square evenly.
    const double a = std::fmod(0.5 + 0.7548776662 * static_cast<double>(k + 1), 1.0);
    const double b = std::fmod(0.5 + 0.5698402909 * static_cast<double>(k + 1), 1.0);
    return {kSpacing * (column + a - 0.5), kSpacing * (row + b - 0.5)};
  }

  // Looks down: x to the east, y to the south.
  void WriteImages(const fs::path& path) const {
    AtomicFile file(path);
    file.WriteValue<uint64_t>(Photo(options_.side - 1, options_.side - 1) + 1);
    for (int row = 0; row < options_.side; ++row) {
      for (int column = 0; column < options_.side; ++column) WriteImage(row, column, &file);
    }
    file.Commit();
  }

  void WriteImage(int row, int column, AtomicFile* file) const {
    const double x = kSpacing * column, y = kSpacing * row;
    file->WriteValue<uint32_t>(static_cast<uint32_t>(Photo(row, column) + 1));
    for (const double value : {0.0, 1.0, 0.0, 0.0, -x, y, kHeight}) file->WriteValue(value);
    file->WriteValue<uint32_t>(1);
    file->Write(Name(Photo(row, column)));
    file->WriteValue<char>('\0');
    file->WriteValue<uint64_t>(NumPoints() * kSeenBy.size());
    for (const auto& [down, right] : kSeenBy) {
      const int from_row = row - down, from_column = column - right;
      for (uint64_t k = 0; k < NumPoints(); ++k) {
        const auto [px, py] = Place(from_row, from_column, k);
        file->WriteValue(options_.width / 2.0 + focal_px_ * (px - x) / kHeight);
        file->WriteValue(height_ / 2.0 - focal_px_ * (py - y) / kHeight);
        const bool is_there = Has(from_row, from_column);
        file->WriteValue<uint64_t>(is_there ? Photo(from_row, from_column) * NumPoints() + k + 1
                                            : ~uint64_t{0});
      }
    }
  }

  void WritePoints(const fs::path& path) const {
    AtomicFile file(path);
    file.WriteValue<uint64_t>((Photo(options_.side - 1, options_.side - 1) + 1) * NumPoints());
    for (int row = 0; row < options_.side; ++row) {
      for (int column = 0; column < options_.side; ++column) {
        for (uint64_t k = 0; k < NumPoints(); ++k) WritePoint(row, column, k, &file);
      }
    }
    file.Commit();
  }

  void WritePoint(int row, int column, uint64_t k, AtomicFile* file) const {
    const auto [x, y] = Place(row, column, k);
    file->WriteValue<uint64_t>(Photo(row, column) * NumPoints() + k + 1);
    for (const double value : {x, y, 0.0}) file->WriteValue(value);
    for (int channel = 0; channel < 3; ++channel) file->WriteValue<uint8_t>(128);
    file->WriteValue(0.5);
    uint64_t num_views = 0;
    for (const auto& [down, right] : kSeenBy) num_views += Has(row + down, column + right) ? 1 : 0;
    file->WriteValue<uint64_t>(num_views);
    for (size_t i = 0; i < kSeenBy.size(); ++i) {
      const int seen_row = row + kSeenBy[i][0], seen_column = column + kSeenBy[i][1];
      if (!Has(seen_row, seen_column)) continue;
      file->WriteValue<uint32_t>(static_cast<uint32_t>(Photo(seen_row, seen_column) + 1));
      file->WriteValue<uint32_t>(static_cast<uint32_t>(i * NumPoints() + k));
    }
  }

  const ProgramOptions& options_;
  const int height_;
  const double focal_px_;
};

void Run(ProgramOptions options) {
  if (options.output.empty()) throw UsageError("--output is missing; see --help");
  LargeModel(options).Write();
  fmt::print("{}: {} photos, {} points\n", options.output, options.side * options.side,
             static_cast<int64_t>(options.side) * options.side * options.points_per_photo);
}

int Main(const std::vector<std::string>& arguments) { return RunGenerator(kUsage, arguments, Run); }

}  // namespace
}  // namespace lsmvs

int main(int argc, char** argv) { return lsmvs::Main({argv + 1, argv + argc}); }
