// Sizes that nobody means are refused before memory is taken, and files that are not to be read are not.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/mesh_file.h"
#include "deformable_sim/scene/tet_mesh_file.h"

namespace deformable_sim {
namespace {

constexpr rlim_t kMostMemory = 256u << 20;  // bytes beyond what the process has

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Bytes of address space.
rlim_t mapped() {
  std::ifstream stream("/proc/self/statm");
  rlim_t pages = 0;
  stream >> pages;
  return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

/// Runs `action` with little memory left, in a process of its own; ends it with 0 when it is refused with `part`.
[[noreturn]] void expect_refusal(const std::string& part, const std::function<void()>& action) {
  const rlim_t most = mapped() + kMostMemory;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
  try {
    const std::string what = refusal(action);
    if (what.find(part) != std::string::npos) std::exit(0);
    fprintf(stderr, "refused with: %s\n", what.c_str());
  } catch (const std::exception& error) {
    fprintf(stderr, "failed with: %s\n", error.what());
  }
  std::exit(1);
}

#define EXPECT_REFUSED_EARLY(part, ...) \
  EXPECT_EXIT(expect_refusal(part, [&] { __VA_ARGS__; }), testing::ExitedWithCode(0), "")

TriangleMesh faces(const std::string& bytes, const std::string& name) {
  return faces_from_bytes(bytes, name, Vec3::Ones());
}

std::string ply(const std::string& format, const std::string& vertices, const std::string& count_type,
                const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces + "\nproperty list " +
         count_type + " int vertex_indices\nend_header\n";
}

TEST(HostileScene, CountsAreRefusedWithTheirLine) {
  const std::string cloth = "bodies:\n  - cloth: {name: a, ";
  EXPECT_REFUSED_EARLY("s:2: bodies[0].cloth.cells",
                       load_scene_text(cloth + "cells: [1000000000, 1000000000]}\n", "s"));
  EXPECT_REFUSED_EARLY("s:2: bodies[0].cloth.cells", load_scene_text(cloth + "cells: [1e9, 1e9]}\n", "s"));
  EXPECT_REFUSED_EARLY("s:2: bodies[0].rope.segments",
                       load_scene_text("bodies:\n  - rope: {name: a, segments: 1000000000000}\n", "s"));
  EXPECT_REFUSED_EARLY(
      "s:2: bodies[0].soft: ",
      load_scene_text("bodies:\n  - soft: {name: a, box: {size: [1, 1, 1], cells: [999, 999, 999]}}\n", "s"));
}

TEST(HostileScene, AFineVisualSurfaceOfAFineClothIsRefused) {
  // 400 x 400 cells cut into 32 x 32 each: 1.6e8 vertices.
  EXPECT_REFUSED_EARLY(
      "s:2: bodies[0].cloth.visual.upsample",
      load_scene_text("bodies:\n  - cloth: {name: a, cells: [400, 400], visual: {upsample: 32}}\n", "s"));
}

TEST(HostileScene, OpenBracketsAreRefusedBeforeTheParserKeepsThem) {
  EXPECT_REFUSED_EARLY("nested deeper than 32", load_scene_text(std::string(4000000, '['), "s"));
  EXPECT_REFUSED_EARLY("larger than 4 MiB", load_scene_text(std::string(5000000, ' '), "s"));
}

/// CPU seconds of loading so many ropes.
double seconds_to_load(int ropes, const std::string& keys) {
  std::string text = "bodies:\n";
  for (int k = 0; k < ropes; ++k) text += "  - rope: {name: r" + std::to_string(k) + ", segments: 1" + keys + "}\n";
  const std::clock_t begin = std::clock();
  EXPECT_EQ(static_cast<size_t>(ropes), load_scene_text(text, "s").bodies.size());
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

// The tables are read once, however many bodies name a material of theirs: 20 000 of them took minutes.
TEST(HostileScene, ManyNamedMaterialsCostLittleMoreThanTheirNames) {
  EXPECT_LT(seconds_to_load(500, ", material: nylon_yarn"), 20.0 * seconds_to_load(500, ""));
}

TEST(HostileMesh, PlyThatClaimsWhatIsNotThereIsRefused) {
  const std::string data = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  EXPECT_REFUSED_EARLY("a.ply:3: ", faces(ply("ascii", "4000000000", "uchar", "1") + data, "a.ply"));
  EXPECT_REFUSED_EARLY("a.ply:7: ", faces(ply("ascii", "3", "uchar", "4000000000") + data, "a.ply"));
  EXPECT_REFUSED_EARLY("a.ply:13: ", faces(ply("ascii", "3", "uchar", "3000000") + data, "a.ply"));
  const std::string points(36, '\0'), count(4, '\xff');
  EXPECT_REFUSED_EARLY("ends before", faces(ply("binary_little_endian", "3", "uint", "1") + points + count, "a.ply"));
  EXPECT_REFUSED_EARLY("ends before", faces(ply("binary_big_endian", "2000000", "uint", "1") + points, "a.ply"));
}

TEST(HostileMesh, StlThatClaimsWhatIsNotThereIsRefused) {
  const std::string header(80, '\0'), triangle(50, '\0');
  EXPECT_REFUSED_EARLY("claims 4294967295 triangles and has 1",
                       faces(header + std::string(4, '\xff') + triangle, "a.stl"));
  EXPECT_NE("", refusal([&] { faces(header, "a.stl"); }));
  EXPECT_NE(std::string::npos, refusal([] { faces("solid\nvertex 0 0 0\n", "a.stl"); }).find("a.stl:2: "));
}

TEST(HostileMesh, ObjVerticesThatAreNotThereAreRefusedWithTheirLine) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* face : {"f 1 2 4", "f 1 2 -4", "f 1 2 0", "f 1 2 99999999999999999999", "f 1 2 x", "f 1 2", "f"}) {
    EXPECT_NE(std::string::npos, refusal([&] { faces(points + face + "\n", "a.obj"); }).find("a.obj:4: ")) << face;
  }
  EXPECT_EQ(1u, faces(points + "f -3/1 -2//7 -1/1/1\n", "a.obj").triangles.size());
}

// Cutting ears looks at all corners for each, and for all of them again.
TEST(HostileMesh, LongPolygonsAreCutAtOnceOrRefused) {
  std::string round, star, face = "f";
  for (int k = 0; k < 20000; ++k) {
    const double angle = 2.0 * 3.14159265358979323846 * k / 20000, radius = k % 2 == 0 ? 1000.0 : 500.0;
    const auto point = [angle](double r) {
      return "v " + std::to_string(r * std::cos(angle)) + " " + std::to_string(r * std::sin(angle)) + " 0\n";
    };
    star += point(radius);
    face += " " + std::to_string(k + 1);
  }
  for (int k = 0; k < 500; ++k) {
    const double angle = 2.0 * 3.14159265358979323846 * k / 500;
    round += "v " + std::to_string(10.0 * std::cos(angle)) + " " + std::to_string(10.0 * std::sin(angle)) + " 0\n";
  }
  EXPECT_NE(std::string::npos, refusal([&] { faces(star + face + "\n", "a.obj"); }).find("20000 corners"));
  std::string disc = "f";
  for (int k = 1; k <= 500; ++k) disc += " " + std::to_string(k);
  EXPECT_EQ(498u, faces(round + disc + "\n", "a.obj").triangles.size());
}

// Area is kept: an L of three unit squares, whose fan from its first corner would cover more.
TEST(Mesh, APolygonThatIsNotConvexIsCutWithinItself) {
  const TriangleMesh mesh = faces("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\n", "a.obj");
  ASSERT_EQ(4u, mesh.triangles.size());
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.rest.col(t[0]), b = mesh.rest.col(t[1]), c = mesh.rest.col(t[2]);
    area += 0.5 * (b - a).cross(c - a).norm();
    EXPECT_GT((b - a).cross(c - a).z(), 0.0);
  }
  EXPECT_NEAR(area, 3.0, 1e-12);
}

TEST(HostileMesh, ColladaIsScreenedBeforeItsReader) {
  const auto refused = [](const std::string& text) { return refusal([&] { faces(text, "a.dae"); }); };
  EXPECT_NE(std::string::npos,
            refused("<COLLADA><float_array count=\"4000000000\">1</float_array></COLLADA>").find("4000000000"));
  EXPECT_NE(std::string::npos, refused("<COLLADA><float_array count = '4000000000'/></COLLADA>").find("4000000000"));
  EXPECT_NE(std::string::npos, refused("<COLLADA><accessor count=\"&#57;999999\"/></COLLADA>").find("whole number"));
  EXPECT_NE(std::string::npos, refused("<!DOCTYPE a [<!ENTITY b \"c\">]><COLLADA/>").find("document type"));
  EXPECT_NE(std::string::npos,
            refused("<COLLADA><node><instance_node url=\"#a\"/></node></COLLADA>").find("instance_node"));
  EXPECT_NE(std::string::npos, refused(std::string("<\0C\0", 4)).find("zero bytes"));
  for (const char* indices : {"0 1// 2", "0 1 &#47;", "0 <!-- --> / 1", "0 <![CDATA[/]]> 1", "1.5", "x"}) {
    const std::string text = std::string("<COLLADA><p>") + indices + "</p></COLLADA>";
    EXPECT_NE(std::string::npos, refused(text).find("an index is no whole number")) << text;
  }
  EXPECT_NE(std::string::npos, refused("<COLLADA><p><q/>/</p></COLLADA>").find("an element among indices"));
  EXPECT_EQ(std::string::npos, refused("<COLLADA><p>0 -1\n2</p> / </COLLADA>").find("ind"));
  std::string deep;
  for (int k = 0; k < 100000; ++k) deep += "<node><!-- </node> -->";
  EXPECT_NE(std::string::npos, refused(deep).find("nested deeper"));
}

// What an OBJ calls its materials, and what a mesh is named, opens nothing else.
TEST(HostileMesh, NamesWithinAMeshOpenNothing) {
  EXPECT_EQ(1u, faces("mtllib /dev/stdin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", "a.obj").triangles.size());
}

/// Scenes of the network, which may name what lies in one folder.
class AllowedFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    top_ = std::filesystem::canonical(std::filesystem::temp_directory_path()) /
           ("allowed_files_" + std::to_string(::getpid()));
    std::filesystem::create_directories(top_ / "inside");
    std::ofstream(top_ / "inside" / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(top_ / "outside.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(top_ / "outside.ele") << "1 4 0\n1 1 2 3 4\n";
    std::ofstream(top_ / "inside" / "a.node") << "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
    std::filesystem::create_symlink(top_ / "outside.obj", top_ / "inside" / "link.obj");
    std::filesystem::create_symlink(top_ / "outside.ele", top_ / "inside" / "a.ele");
    std::ofstream(top_ / "inside" / "scene.yaml") << scene("cloth", "a.obj");
  }
  void TearDown() override { std::filesystem::remove_all(top_); }

  static std::string scene(const std::string& kind, const std::string& file) {
    return "bodies:\n  - " + kind + ":\n      name: a\n      mesh: " + file + "\n";
  }
  std::string refused(const std::string& text) const {
    return refusal([&] { load_scene_text(text, "s", {}, AllowedPaths({(top_ / "inside").string()})); });
  }

  std::filesystem::path top_;
};

TEST_F(AllowedFiles, MeshesOfASceneLieInThem) {
  EXPECT_EQ("", refused(scene("cloth", "a.obj")));
  EXPECT_EQ("", refused(scene("cloth", (top_ / "inside" / "a.obj").string())));
  for (const std::string& file : {std::string("../outside.obj"), std::string("link.obj"), std::string("/etc/passwd"),
                                  (top_ / "outside.obj").string(), std::string("package://deformable_sim/../x.obj")}) {
    const std::string what = refused(scene("cloth", file));
    EXPECT_EQ(0u, what.find("s:4: bodies[0].cloth.mesh: file ")) << file << ": " << what;
    EXPECT_NE(std::string::npos, what.find("outside of the folders")) << file << ": " << what;
  }
}

TEST_F(AllowedFiles, BothFilesOfATetGenPairLieInThem) {
  EXPECT_NE(std::string::npos, refused(scene("soft", "a.node")).find("s:4: bodies[0].soft.mesh: file "));
}

TEST_F(AllowedFiles, CollidersAndVisualSurfacesLieInThem) {
  const std::string cloth = "bodies:\n  - cloth: {name: a, visual: {mesh: ../outside.obj}}\n";
  EXPECT_NE(std::string::npos, refused(cloth).find("s:2: bodies[0].cloth.visual.mesh: file "));
  const std::string rope = "bodies:\n  - rope: {name: a}\ncolliders:\n  - ";
  EXPECT_NE(std::string::npos,
            refused(rope + "mesh: {name: b, file: /etc/x.stl}\n").find("s:4: colliders[0].mesh.file: file "));
  EXPECT_NE(std::string::npos,
            refused(rope + "octomap: {name: b, file: /etc/x.bt}\n").find("s:4: colliders[0].octomap.file: file "));
}

TEST_F(AllowedFiles, ScenesLieInThem) {
  const std::string folder = (top_ / "inside").string();
  const AllowedPaths files({folder});
  EXPECT_EQ(folder + "/scene.yaml", find_scene("scene", folder, files));
  EXPECT_EQ(folder + "/scene.yaml", find_scene(folder + "/scene.yaml", folder, files));
  for (const char* name : {"../outside.obj", "/etc/passwd", "../inside_not/scene.yaml"}) {
    EXPECT_NE(std::string::npos, refusal([&] { find_scene(name, folder, files); }).find("outside of the folders"))
        << name;
  }
  EXPECT_EQ("", refusal([&] { load_scene_file(folder + "/scene.yaml", {}, files); }));
}

}  // namespace
}  // namespace deformable_sim
