#include "core/io/motion_import.h"

#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

fs::path write(const std::string& name, const std::string& text) {
  const fs::path path = test::scratchDirectory() / name;
  std::ofstream(path) << text;
  return path;
}

/// Four points that touch the box, one a frame, at 2 Hz: 1.5 s.
fs::path recording(const geometry::TriangleMesh& box) {
  const Eigen::Vector3d p = box.vertices().col(0);
  std::string frames;
  for (int k = 0; k < 4; ++k)
    frames += fmt::format(
        "{}{{\"frame\": {}, \"contacts\": [{{\"object_point\": [{}, {}, {}], "
        "\"hand_point\": [0, 0, 0], \"link\": \"tip\"}}]}}",
        k == 0 ? "" : ", ", k, p.x(), p.y(), p.z());
  return write("recorded.json", "{\"fps\": 2, \"frames\": [" + frames + "]}");
}

fs::path splines(double duration_s) {
  std::string data;
  for (int d = 0; d < 6; ++d)
    data +=
        fmt::format("{}{{\"units\": \"{}\", \"controlPointData\": [0, 0, 1, 0, 2, 0, 3, 0]}}",
                    d == 0 ? "" : ", ", d < 3 ? "meters" : "radians");
  return write("other.smexp",
               fmt::format("{{\"time\": {}, \"data\": [{}]}}", duration_s, data));
}

TEST(MotionImport, NotesThatTheObjectsPathLastsAnotherTime) {
  const geometry::TriangleMesh box =
      readMesh(test::sourceDirectory() / "server/models/objects/box.obj").mesh;
  const fs::path recorded = recording(box);
  for (const double duration_s : {1.5, 1.45, 1.55}) {
    EXPECT_THAT(readContactSequence(recorded, box, splines(duration_s)).notes, IsEmpty())
        << duration_s;
  }
  EXPECT_THAT(readContactSequence(recorded, box, splines(1.978)).notes,
              ElementsAre("the object's path 'other.smexp' lasts 1.978 s and the recording "
                          "1.500 s: the path is followed in the recording's time; is it of "
                          "another recording?"));
  EXPECT_THAT(readContactSequence(recorded, box, "").notes,
              ElementsAre(HasSubstr("no path of the object was given (--object-path)")));
}

}  // namespace
}  // namespace handgraft::io
