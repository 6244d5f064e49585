#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>

#include "deformable_sim/core/error.h"
#include "face_files.h"

namespace deformable_sim {
namespace {

constexpr size_t kHeader = 80, kTriangle = 50;  // bytes
constexpr size_t kBegin = kHeader + 4;
constexpr size_t kNormal = 12;

std::uint32_t triangle_count(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeader, sizeof count);
  return count;
}

void end_triangle(Faces* faces) {
  for (size_t k = 3; k > 0; --k) faces->add_corner(static_cast<long>(faces->point_count() - k));
  faces->end_face();
}

Faces read_binary(const std::string& bytes, const std::string& name) {
  const size_t count = triangle_count(bytes), there = (bytes.size() - kBegin) / kTriangle;
  if (count > there) {
    throw InputError(name + ": claims " + std::to_string(count) + " triangles and has " + std::to_string(there));
  }
  Faces faces;
  for (size_t t = 0; t < count; ++t) {
    const char* at = bytes.data() + kBegin + kTriangle * t + kNormal;
    for (size_t k = 0; k < 3; ++k) {
      Faces::Point point;
      std::memcpy(point.data(), at + k * sizeof point, sizeof point);
      faces.add_point(point);
    }
    end_triangle(&faces);
  }
  return faces;
}

Faces read_ascii(const std::string& bytes, const std::string& name) {
  MeshText text(name, bytes, 1, 0);
  Faces faces;
  size_t ended = 0;  // points of triangles
  while (!text.done()) {
    std::string word = text.word("a statement");
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    if (word == "vertex") {
      Faces::Point point;
      for (float& coordinate : point) coordinate = text.coordinate();
      faces.add_point(point);
    } else if (word == "endfacet") {
      if (faces.point_count() - ended != 3) text.refuse("a facet has three vertices");
      ended = faces.point_count();
      end_triangle(&faces);
    } else if (word == "solid" || word == "endsolid" || word == "facet") {
      text.skip_line();  // names, and normals that follow from the vertices
    } else if (word != "outer" && word != "loop" && word != "endloop") {
      text.refuse("STL has solid, facet, outer loop, vertex, endloop, endfacet and endsolid");
    }
  }
  if (faces.point_count() != ended) text.refuse("the file ends within a facet");
  return faces;
}

}  // namespace

Faces read_stl(const std::string& bytes, const std::string& name) {
  const bool says_solid = bytes.rfind("solid", 0) == 0;
  const bool fits = bytes.size() >= kBegin && bytes.size() == kBegin + kTriangle * size_t{triangle_count(bytes)};
  if (fits || (bytes.size() >= kBegin && !says_solid)) return read_binary(bytes, name);
  return read_ascii(bytes, name);
}

}  // namespace deformable_sim
