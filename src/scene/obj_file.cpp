#include <charconv>

#include "deformable_sim/core/error.h"
#include "face_files.h"

namespace deformable_sim {
namespace {

/// The point of a corner `i`, `i/j`, `i//k` or `i/j/k`; negative counts back from the last point so far.
long point_of(const MeshText& text, const std::string& word, size_t points) {
  long number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool whole = error == std::errc() && (end == word.data() + word.size() || *end == '/');
  if (!whole || number == 0) text.refuse("a face names vertices by numbers from 1, or by negative ones");
  const long count = static_cast<long>(points);
  if (number > count || number < -count) {
    text.refuse("a face names vertex " + std::to_string(number) + " of " + std::to_string(count));
  }
  return number > 0 ? number - 1 : count + number;
}

void read_face(MeshText* text, Faces* faces) {
  while (text->more_on_line()) faces->add_corner(point_of(*text, text->word("a corner"), faces->point_count()));
  if (faces->open_corners() < 3) text->refuse("a face needs three vertices");
  faces->end_face();
}

}  // namespace

Faces read_obj(const std::string& bytes, const std::string& name) {
  MeshText text(name, bytes, 1, '#');
  Faces faces;
  while (!text.done()) {
    const std::string keyword = text.word("a statement");
    if (keyword == "v") {
      Faces::Point point;
      for (float& coordinate : point) coordinate = text.coordinate();
      faces.add_point(point);
    } else if (keyword == "f") {
      read_face(&text, &faces);
      continue;
    } else if (keyword == "l" || keyword == "p") {
      text.refuse("lines and points are no cloth");
    }
    text.skip_line();
  }
  faces.check();
  return faces;
}

}  // namespace deformable_sim
