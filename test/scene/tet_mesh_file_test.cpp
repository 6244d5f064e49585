// Volumes of tetrahedra from files: what is read, and what is refused with the file and the line.
#include "deformable_sim/scene/tet_mesh_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

// Two tetrahedra of a unit corner, on either side of the face 1 2 3; lines are counted below.
const std::string kGmsh4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"                  // 1-3
    "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"   // 4-7
    "$Nodes\n1 5 10 14\n3 1 0 5\n10\n11\n12\n13\n14\n"        // 8-15
    "1 0 0\n0 1 0\n0 0 1\n0 0 0\n1 1 1\n$EndNodes\n"          // 16-21
    "$Elements\n2 3 1 3\n2 1 2 1\n1 10 11 12\n"               // 22-25
    "3 1 4 2\n2 10 11 12 14\n3 13 10 11 12\n$EndElements\n";  // 26-29
const std::string kGmsh2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"                    // 1-3
    "$Nodes\n5\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 0 0 0\n5 1 1 1\n"  // 4-10
    "$EndNodes\n$Elements\n3\n1 2 2 0 1 1 2 3\n"                // 11-14
    "2 4 2 0 1 1 2 3 5\n3 4 2 0 1 4 1 2 3\n$EndElements\n";     // 15-17
const std::string kMedit =
    "MeshVersionFormatted 2 # as TetGen and Netgen write it\n\nDimension 3\n"  // 1-3
    "Vertices\n5\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 0\n1 1 1 0\n"               // 4-10
    "Triangles\n1\n1 2 3 7\nTetrahedra\n2\n1 2 3 5 0\n4 1 2 3 0\nEnd\n";       // 11-18
const std::string kNode = "5 3 0 1\n0 1 0 0 1\n1 0 1 0 1\n2 0 0 1 1\n3 0 0 0 1\n4 1 1 1 1\n# made by hand\n";
const std::string kEle = "2 4 0\n0 0 1 2 4\n1 3 0 1 2\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// Text as a file of its own, in a folder of this process.
std::string file_of(const std::string& name, const std::string& text) {
  const std::filesystem::path dir = std::filesystem::path(testing::TempDir()) / "tet_mesh_file_test";
  std::filesystem::create_directories(dir);
  std::ofstream(dir / name, std::ios::binary) << text;
  return (dir / name).string();
}

std::string refusal_of(const std::string& path) {
  try {
    load_tet_mesh(path, 1.0);
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

void expect_the_two_tetrahedra(const std::string& path) {
  const TetMesh mesh = load_tet_mesh(path, 0.5);
  ASSERT_EQ(mesh.rest.cols(), 5) << path;
  ASSERT_EQ(mesh.tets.size(), 2u) << path;
  EXPECT_EQ(mesh.rest.col(0), Vec3(0.5, 0, 0)) << "scaled";
  // A corner of the unit cube, 1/6, and what lies between it and the opposite corner, 1/3; both positive.
  EXPECT_NEAR(volume_of(mesh, 0), 0.125 / 3.0, 1e-15) << path;
  EXPECT_NEAR(volume_of(mesh, 1), 0.125 / 6.0, 1e-15) << path;
  EXPECT_NO_THROW(check_mesh(mesh)) << path;
}

TEST(TetMeshFiles, AreReadFromThreeProgramsAlike) {
  expect_the_two_tetrahedra(file_of("a.msh", kGmsh4));
  expect_the_two_tetrahedra(file_of("b.msh", kGmsh2));
  expect_the_two_tetrahedra(file_of("c.mesh", kMedit));
  file_of("d.ele", kEle);
  expect_the_two_tetrahedra(file_of("d.node", kNode));
  expect_the_two_tetrahedra(file_of("d.ele", kEle));
}

TEST(TetMeshFiles, WithDosLineEndsAreReadToo) {
  std::string text;
  for (const char c : kGmsh2) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_the_two_tetrahedra(file_of("dos.msh", text));
}

TEST(TetMeshFiles, WoundTheOtherWayAreTurned) {
  const std::string turned = replaced(replaced(kEle, "0 1 2 4", "1 0 2 4"), "3 0 1 2", "3 1 0 2");
  file_of("turned.node", kNode);
  expect_the_two_tetrahedra(file_of("turned.ele", turned));
}

TEST(TetMeshFiles, AreRefusedWithTheirLine) {
  struct Case {
    std::string name, text, expected;
  };
  const std::vector<Case> cases{
      {"nan.msh", replaced(kGmsh4, "0 1 0\n", "0 nan 0\n"), ":17: a coordinate must be a finite number, not 'nan'"},
      {"inf.mesh", replaced(kMedit, "0 1 0 0\n", "0 1e999 0 0\n"), ":7: a coordinate must be a finite number"},
      {"word.msh", replaced(kGmsh2, "1 2 3 5", "1 2 x 5"),
       ":15: a node of a tetrahedron must be a whole number, not 'x'"},
      {"gone.msh", replaced(kGmsh2, "4 1 2 3\n$End", "9 1 2 3\n$End"), ":16: there is no node 9"},
      {"twice.msh", replaced(kGmsh2, "5 1 1 1", "4 1 1 1"), ":10: node 4 is given twice"},
      {"inverted.msh", replaced(kGmsh4, "3 13 10 11 12", "3 10 13 11 12"), ":28: the tetrahedron is inverted"},
      {"flat.msh", replaced(kGmsh2, "4 0 0 0\n", "4 0.5 0.5 0\n"), ":16: the tetrahedron has no volume"},
      {"unused.msh", replaced(replaced(kGmsh2, "$Nodes\n5", "$Nodes\n6"), "$EndNodes", "6 2 2 2\n$EndNodes"),
       ":11: node 6 belongs to no tetrahedron"},
      {"quadratic.msh", replaced(kGmsh2, "2 4 2 0 1 1 2 3 5", "2 11 2 0 1 1 2 3 5 1 1 1 1 1 1"),
       ":15: second order tetrahedra are not read"},
      {"none.msh", kGmsh2.substr(0, kGmsh2.find("3\n1 2 2 0")) + "0\n$EndElements\n",
       ":14: the file ends without a tetrahedron"},
      {"truncated.msh", kGmsh4.substr(0, kGmsh4.size() - 22), ":28: the file ends where"},
      {"counted.msh", replaced(kGmsh2, "$Elements\n3\n", "$Elements\n4\n"), ":17: "},
      {"binary.msh", replaced(kGmsh4, "4.1 0 8", "4.1 1 8"), ":2: is binary"},
      {"old.msh", replaced(kGmsh4, "4.1 0 8", "4.0 0 8"), ":2: version 4.0 is not read; allowed: 4.1, 2.2"},
      {"not.msh", "solid\n", ":1: a Gmsh file starts with $MeshFormat"},
      {"not.mesh", "solid\n", ":1: a MEDIT file starts with MeshVersionFormatted"},
      {"flat.mesh", replaced(kMedit, "Dimension 3", "Dimension 2"), ":3: a volume needs 3 dimensions"},
      {"huge.mesh", replaced(kMedit, "Vertices\n5", "Vertices\n200001"), ":5: the number of vertices 200001 is out of"},
      {"empty.mesh", "", ":1: the file ends where MeshVersionFormatted should stand"}};
  for (const Case& c : cases) {
    const std::string path = file_of(c.name, c.text), message = refusal_of(path);
    EXPECT_EQ(message.rfind(path + c.expected, 0), 0u) << "expected: " << c.expected << "\ngot:      " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line";
  }
}

TEST(TetMeshFiles, ThatDoNotExistOrAreNoTextAreRefused) {
  EXPECT_EQ(refusal_of("/nowhere/a.msh"), "/nowhere/a.msh: no such mesh file");
  const std::string lonely = file_of("lonely.node", kNode);
  EXPECT_NE(refusal_of(lonely).find("lonely.ele: no such mesh file"), std::string::npos);
  EXPECT_NE(refusal_of(file_of("zero.msh", kGmsh2 + '\0')).find("is binary"), std::string::npos);
  EXPECT_NE(refusal_of(file_of("a.obj", "")).find("volumes are .msh (Gmsh)"), std::string::npos);
}

TEST(TetMeshFiles, CutAnywhereAreReadOrRefused) {
  for (const auto& [name, text] :
       {std::make_pair(std::string("cut.msh"), kGmsh4), {"cut2.msh", kGmsh2}, {"cut.mesh", kMedit}}) {
    int refused = 0;
    for (size_t n = 0; n < text.size(); ++n) refused += refusal_of(file_of(name, text.substr(0, n))) != "(accepted)";
    // Only a file that lacks nothing but its last words is still a mesh.
    EXPECT_GT(refused, static_cast<int>(text.size()) - 20) << name;
  }
}

}  // namespace
}  // namespace deformable_sim
