#include "lsmvs/colmap_adapter/sparse_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "lsmvs/adapter_test/corruption.h"
#include "lsmvs/adapter_test/small_model.h"
#include "lsmvs/colmap_adapter/model/camera_model.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/test_support/temporary_folder.h"
#include "lsmvs/test_support/test_data.h"
#include "lsmvs/util/error.h"

namespace lsmvs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::vector<std::string> kBinaryFiles = {"cameras.bin", "images.bin", "points3D.bin",
                                               "rigs.bin", "frames.bin"};

TEST(CameraModelTest, EveryModelIsFoundByNumberAndName) {
  EXPECT_EQ(AllCameraModels().size(), 18u);
  for (const CameraModel& model : AllCameraModels()) {
    EXPECT_EQ(FindCameraModel(model.id), &model);
    EXPECT_EQ(FindCameraModel(model.name), &model);
  }
  EXPECT_EQ(FindCameraModel(18), nullptr);
  EXPECT_EQ(FindCameraModel(-1), nullptr);
  EXPECT_EQ(FindCameraModel("pinhole"), nullptr);
}

struct RoundTripCase {
  SparseFormat format;
  bool with_rigs;
};

class SparseModelRoundTripTest : public testing::TestWithParam<RoundTripCase> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(SparseModelRoundTripTest, ReadsWhatItWrote) {
  const SparseModel model = SmallModel(GetParam().with_rigs);
  WriteSparseModel(folder_.path(), model, GetParam().format);
  ExpectSameModel(ReadSparseModel(folder_.path()), model);
}

TEST_P(SparseModelRoundTripTest, EmptyModelIsLegal) {
  WriteSparseModel(folder_.path(), {}, GetParam().format);
  ExpectSameModel(ReadSparseModel(folder_.path()), {});
}

TEST_P(SparseModelRoundTripTest, EveryCameraModelSurvives) {
  SparseModel model;
  for (const CameraModel& camera_model : AllCameraModels()) {
    const CameraId id{static_cast<uint32_t>(camera_model.id + 1)};
    std::vector<double> params;
    for (size_t i = 0; i < camera_model.num_params; ++i) {
      params.push_back(0.1 * static_cast<double>(i));
    }
    model.cameras.push_back({id, camera_model.id, 100, 90, params});
  }
  WriteSparseModel(folder_.path(), model, GetParam().format);
  ExpectSameModel(ReadSparseModel(folder_.path()), model);
}

TEST_P(SparseModelRoundTripTest, SkippedFeaturesAreCounted) {
  WriteSparseModel(folder_.path(), SmallModel(GetParam().with_rigs), GetParam().format);
  const SparseModel model = ReadSparseModel(folder_.path(), {.keep_points2d = false});
  EXPECT_TRUE(model.images[0].points2d.empty());
  EXPECT_EQ(model.images[0].num_points2d, 2u);
}

INSTANTIATE_TEST_SUITE_P(Formats, SparseModelRoundTripTest,
                         testing::Values(RoundTripCase{SparseFormat::kBinary, false},
                                         RoundTripCase{SparseFormat::kBinary, true},
                                         RoundTripCase{SparseFormat::kText, false},
                                         RoundTripCase{SparseFormat::kText, true}));

TEST(SparseModelTest, RealModelKeepsItsBytes) {
  LSMVS_REQUIRE_SCENE("fountain-P11");
  const auto source = TestDataFolder() / "fountain-P11" / "sparse" / "0";
  const SparseModel model = ReadSparseModel(source);
  EXPECT_EQ(model.images.size(), 11u);
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), model);
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    EXPECT_TRUE(ReadWholeFile(source / name) == ReadWholeFile(folder.path() / name)) << name;
  }
}

TEST(SparseModelTest, RealTextModelIsRead) {
  LSMVS_REQUIRE_SCENE("fountain-P11-fused");
  const SparseModel model = ReadSparseModel(TestDataFolder() / "fountain-P11-fused" / "sparse");
  EXPECT_EQ(model.images.size(), 11u);
  EXPECT_GT(model.points3d.size(), 10000u);
}

TEST(SparseModelTest, BinaryIsPreferredOverText) {
  const TemporaryFolder folder;
  SparseModel model = SmallModel(false);
  WriteSparseModel(folder.path(), model, SparseFormat::kBinary);
  model.points3d.clear();
  WriteSparseModel(folder.path(), model, SparseFormat::kText);
  EXPECT_EQ(ReadSparseModel(folder.path()).points3d.size(), 2u);
}

TEST(SparseModelTest, RegisteredOrderIsThatOfFramesWhereThereAreAny) {
  EXPECT_THAT(RegisteredImageOrder(SmallModel(false)), ElementsAre(0, 1, 2));
  EXPECT_THAT(RegisteredImageOrder(SmallModel(true)), ElementsAre(2, 0, 1));
}

TEST(SparseModelTest, TrivialFramesKeepOrderAndPoses) {
  SparseModel model = SmallModel(false);
  AddTrivialRigsAndFrames(&model);
  CheckSparseModel(model, "model");
  EXPECT_EQ(model.rigs.size(), 2u);
  EXPECT_THAT(RegisteredImageOrder(model), ElementsAre(0, 1, 2));
  EXPECT_EQ(model.frames[1].rig_from_world.translation, model.images[1].cam_from_world.translation);
}

TEST(SparseModelTest, TruncationAtEveryByteIsAnError) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true));
  for (const std::string& name : kBinaryFiles) {
    ExpectErrorAtEveryTruncation(folder.path() / name, [&] { ReadSparseModel(folder.path()); });
    ExpectErrorAtEveryTruncation(folder.path() / name,
                                 [&] { ReadSparseModel(folder.path(), {.keep_points2d = false}); });
  }
}

TEST(SparseModelTest, MutationsNeverCrash) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true));
  for (const std::string& name : kBinaryFiles) {
    ExpectSurvivesMutations(folder.path() / name, 300, [&] { ReadSparseModel(folder.path()); });
  }
}

TEST(SparseModelTest, MutatedAndCutTextNeverCrashes) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true), SparseFormat::kText);
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt", "rigs.txt", "frames.txt"}) {
    const auto path = folder.path() / name;
    ExpectSurvivesMutations(path, 300, [&] { ReadSparseModel(folder.path()); });
    const std::string text = ReadWholeFile(path);
    for (size_t length = 0; length < text.size(); ++length) {
      WriteWholeFile(path, text.substr(0, length));
      try {
        ReadSparseModel(folder.path());
      } catch (const InputError&) {
      }
    }
    WriteWholeFile(path, text);
  }
}

TEST(SparseModelTest, SurplusBytesAreAnError) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true));
  for (const std::string& name : kBinaryFiles) {
    const std::string bytes = ReadWholeFile(folder.path() / name);
    WriteWholeFile(folder.path() / name, bytes + "x");
    EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
                HasSubstr(name + ": has 1 bytes more"));
    WriteWholeFile(folder.path() / name, bytes);
  }
}

TEST(SparseModelTest, CorruptCountAllocatesNothing) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true));
  for (const std::string& name : kBinaryFiles) {
    const std::string bytes = ReadWholeFile(folder.path() / name);
    WriteWholeFile(folder.path() / name, std::string(7, '\xff') + '\x7f' + bytes.substr(8));
    EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
                HasSubstr("more than its size allows (at byte 0)"));
    WriteWholeFile(folder.path() / name, bytes);
  }
}

TEST(SparseModelTest, UnknownCameraModelIsNamed) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(false));
  const auto path = folder.path() / "cameras.bin";
  std::string bytes = ReadWholeFile(path);
  bytes[12] = 99;
  WriteWholeFile(path, bytes);
  EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
              HasSubstr("unknown camera model 99 (at byte 12)"));
  std::filesystem::remove(path);
  WriteSparseModel(folder.path(), SmallModel(false), SparseFormat::kText);
  WriteWholeFile(folder.path() / "cameras.txt", "# x\n1 FISHPOND 10 10 1 2 3\n");
  EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
              HasSubstr("cameras.txt: line 2: has the unknown camera model 'FISHPOND'"));
}

TEST(SparseModelTest, MissingFilesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_FALSE(IsSparseModelFolder(folder.path()));
  EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }), HasSubstr("no sparse model"));
  WriteSparseModel(folder.path(), SmallModel(true));
  EXPECT_TRUE(IsSparseModelFolder(folder.path()));
  std::filesystem::remove(folder.path() / "rigs.bin");
  EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
              HasSubstr("rigs.bin: is missing beside"));
}

// What each change to a consistent model must be answered with.
struct Inconsistency {
  const char* message;
  void (*change)(SparseModel*);
};

class InconsistentModelTest : public testing::TestWithParam<Inconsistency> {};

TEST_P(InconsistentModelTest, IsRefused) {
  SparseModel model = SmallModel(true);
  GetParam().change(&model);
  for (const SparseFormat format : {SparseFormat::kBinary, SparseFormat::kText}) {
    const TemporaryFolder folder;
    WriteSparseModel(folder.path(), model, format);
    EXPECT_THAT(InputErrorOf([&] { ReadSparseModel(folder.path()); }),
                HasSubstr(GetParam().message));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, InconsistentModelTest,
    testing::Values(
        Inconsistency{"two cameras 1",
                      [](SparseModel* m) { m->cameras[1].camera_id = CameraId{1}; }},
        Inconsistency{"impossible size 0 x 480", [](SparseModel* m) { m->cameras[0].width = 0; }},
        Inconsistency{"impossible size", [](SparseModel* m) { m->cameras[0].height = 1ull << 40; }},
        Inconsistency{"camera 1 has a parameter that is not finite",
                      [](SparseModel* m) { m->cameras[0].params[0] = kNan; }},
        Inconsistency{"two images 5", [](SparseModel* m) { m->images[1].image_id = ImageId{5}; }},
        Inconsistency{"two images named b.jpg",
                      [](SparseModel* m) { m->images[1].name = "b.jpg"; }},
        Inconsistency{"image 5 (b.jpg) refers to the missing camera 8",
                      [](SparseModel* m) { m->images[0].camera_id = CameraId{8}; }},
        Inconsistency{"image 5 (b.jpg) has a pose that is not finite",
                      [](SparseModel* m) { m->images[0].cam_from_world.translation[1] = kNan; }},
        Inconsistency{"image 3 (sub folder/a.jpg) has a pose that is not finite",
                      [](SparseModel* m) { m->images[1].cam_from_world.rotation.w() = kNan; }},
        Inconsistency{
            "rotation of length 0",
            [](SparseModel* m) { m->images[0].cam_from_world.rotation.coeffs().setZero(); }},
        Inconsistency{"two points 100",
                      [](SparseModel* m) { m->points3d[1].point3d_id = Point3dId{100}; }},
        Inconsistency{"point 200 is not finite",
                      [](SparseModel* m) { m->points3d[1].x_in_world[2] = kNan; }},
        Inconsistency{"two rigs 4", [](SparseModel* m) { m->rigs[1].rig_id = RigId{4}; }},
        Inconsistency{"rig 4 refers to the missing camera 2",
                      [](SparseModel* m) { m->rigs[0].sensors[0].sensor.id = 2; }},
        Inconsistency{
            "rig 4 has a pose that is not finite",
            [](SparseModel* m) { m->rigs[0].sensors[1].sensor_from_rig->translation[0] = kNan; }},
        Inconsistency{"two of frame 2", [](SparseModel* m) { m->frames[1].frame_id = FrameId{2}; }},
        Inconsistency{"frame 2 refers to the missing rig 5",
                      [](SparseModel* m) { m->frames[0].rig_id = RigId{5}; }},
        Inconsistency{"frame 2 refers to the missing image 13",
                      [](SparseModel* m) { m->frames[0].data[0].data_id = 13; }},
        Inconsistency{"image 3 is in two frames",
                      [](SparseModel* m) { m->frames[1].data[1].data_id = 3; }},
        Inconsistency{"image 12 (c.jpg) is in no frame",
                      [](SparseModel* m) { m->frames[0].data.clear(); }}));

// As converters write them: dummy tracks, features left out.
TEST(SparseModelTest, TracksThatReferToNothingAreDropped) {
  for (const SparseFormat format : {SparseFormat::kBinary, SparseFormat::kText}) {
    SparseModel model = SmallModel(true);
    SparseModel expected = model;
    model.points3d[0].track.push_back({ImageId{6}, 0});
    model.points3d[1].track.push_back({ImageId{5}, 2});
    model.images[2].points2d[0].point3d_id = Point3dId{12345};
    expected.images[2].points2d[0].point3d_id = SparseModel::kNoPoint3d;
    const TemporaryFolder folder;
    WriteSparseModel(folder.path(), model, format);
    const SparseModel read = ReadSparseModel(folder.path());
    ExpectSameModel(read, expected);
    EXPECT_THAT(read.warnings, ElementsAre(HasSubstr(folder.path().string() + ": 2 of the 4 ")));
    EXPECT_EQ(ReadSparseModel(folder.path(), {.keep_points2d = false}).warnings, read.warnings);
    WriteSparseModel(folder.path(), read, format);
    EXPECT_TRUE(ReadSparseModel(folder.path()).warnings.empty());
  }
}

TEST(SparseModelTextTest, NumpyByteOrderMarksAndUnsignedMinusOne) {
  const TemporaryFolder folder;
  const std::string mark = "\xef\xbb\xbf";
  WriteWholeFile(folder.path() / "cameras.txt", mark + "1 PINHOLE 10 20 1.5 2 5 10\n");
  WriteWholeFile(folder.path() / "images.txt",
                 mark +
                     "# i\n1.000e+00 np.float64(1.0) 0 0 0 0 0 0 np.int64(1) a.jpg\n"
                     "5 5 18446744073709551615 6 6 -1.0e+00 7 7 7.000e+00\n");
  WriteWholeFile(folder.path() / "points3D.txt",
                 mark + "7.0e+00 1 2 3 4.0e+00 5.0e+00 6.0e+00 5.0e-01 1 2\n");
  const SparseModel model = ReadSparseModel(folder.path());
  ASSERT_EQ(model.images.size(), 1u);
  ASSERT_EQ(model.images[0].points2d.size(), 3u);
  EXPECT_EQ(model.images[0].points2d[0].point3d_id, SparseModel::kNoPoint3d);
  EXPECT_EQ(model.images[0].points2d[1].point3d_id, SparseModel::kNoPoint3d);
  EXPECT_EQ(model.images[0].points2d[2].point3d_id, Point3dId{7});
  ASSERT_EQ(model.points3d.size(), 1u);
  EXPECT_EQ(model.points3d[0].color, Color(4, 5, 6));
  ASSERT_EQ(model.points3d[0].track.size(), 1u);
}

TEST(SparseModelTextTest, TakesWhatPeopleWrite) {
  const TemporaryFolder folder;
  WriteWholeFile(folder.path() / "cameras.txt", "\r\n# c\r\n1 PINHOLE 10 20 +1.5 2e0 5 10  \r\n");
  // Empty feature lines must not be skipped as blank ones; names may hold blanks; the last line may
  // be missing.
  WriteWholeFile(folder.path() / "images.txt",
                 "# i\n1 1 0 0 0 0 0 0 1 my photo.jpg \n\n2 1 0 0 0 0 0 1 1 b.jpg\n1 2 -1 3 4 7");
  WriteWholeFile(folder.path() / "points3D.txt", "7 1 2 3 4 5 6 0.5 2 1\n\n");
  const SparseModel model = ReadSparseModel(folder.path());
  ASSERT_EQ(model.images.size(), 2u);
  EXPECT_EQ(model.cameras[0].params, (std::vector<double>{1.5, 2, 5, 10}));
  EXPECT_EQ(model.images[0].name, "my photo.jpg");
  EXPECT_EQ(model.images[0].num_points2d, 0u);
  ASSERT_EQ(model.images[1].num_points2d, 2u);
  EXPECT_EQ(model.images[1].points2d[0].point3d_id, SparseModel::kNoPoint3d);
  EXPECT_EQ(model.images[1].points2d[1].point3d_id, Point3dId{7});
}

TEST(SparseModelTextTest, ErrorsNameTheLine) {
  const TemporaryFolder folder;
  WriteSparseModel(folder.path(), SmallModel(true), SparseFormat::kText);
  const auto error_with = [&](const std::string& name, const std::string& text) {
    const std::string before = ReadWholeFile(folder.path() / name);
    WriteWholeFile(folder.path() / name, text);
    const std::string message = InputErrorOf([&] { ReadSparseModel(folder.path()); });
    WriteWholeFile(folder.path() / name, before);
    return message;
  };
  EXPECT_THAT(error_with("cameras.txt", "#\n1 PINHOLE 10 20 1 x 3 4\n"),
              HasSubstr("line 2: has 'x' where a number should be"));
  EXPECT_THAT(error_with("cameras.txt", "1 PINHOLE 10 20 1 2 3 4 5\n"),
              HasSubstr("line 1: has '5' where it should end"));
  EXPECT_THAT(error_with("cameras.txt", "-1 PINHOLE 10 20 1 2 3 4\n"), HasSubstr("whole number"));
  EXPECT_THAT(error_with("images.txt", "1 1 0 0 0 0 0 0 1\n\n"), HasSubstr("no image name"));
  EXPECT_THAT(error_with("images.txt", "1 1 0 0 0 0 0 0 1 a\n1 2\n"),
              HasSubstr("line 2: ends too early"));
  // Features left out: the next image is where they should be.
  EXPECT_THAT(error_with("images.txt", "1 1 0 0 0 0.5 0 0 1 a\n2 1 0.1 0 0 0 0 0 1 b\n"),
              AllOf(HasSubstr("line 2: has '0.1'"), HasSubstr("an image takes two lines")));
  EXPECT_THAT(error_with("cameras.txt", "1 PINHOLE 10 20 1,5 2 3 4\n"),
              AllOf(HasSubstr("line 1: has '1,5'"), HasSubstr("a point instead of a comma")));
  EXPECT_THAT(error_with("cameras.txt", std::string("\xff\xfe#\0\n\0", 6)), HasSubstr("UTF-16"));
  EXPECT_THAT(error_with("points3D.txt", "1.5 1 2 3 4 5 6 0\n"), HasSubstr("whole number"));
  EXPECT_THAT(error_with("points3D.txt", "-1.0 1 2 3 4 5 6 0\n"), HasSubstr("whole number"));
  EXPECT_THAT(error_with("points3D.txt", "1 1 2 3 4 5 256 0\n"), HasSubstr("at most 255"));
  EXPECT_THAT(error_with("rigs.txt", "1 999999999 CAMERA 1\n"), HasSubstr("more than it has room"));
  EXPECT_THAT(error_with("frames.txt", "1 4 1 0 0 0 0 0 0 1 LIDAR 1 5\n"),
              HasSubstr("unknown sensor type 'LIDAR'"));
}

TEST(SparseModelTest, WritingAnImpossibleCameraIsAProgrammersError) {
  const TemporaryFolder folder;
  SparseModel model = SmallModel(false);
  model.cameras[0].params.pop_back();
  EXPECT_THROW(WriteSparseModel(folder.path(), model), std::logic_error);
}

}  // namespace
}  // namespace lsmvs
